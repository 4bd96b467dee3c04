"""Records that are set aside of several: which, why, and what is not identified without them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.parameters import GAIN, JointForm, Told, prefilters_of
from axisid.estimation.records import Record, record_labels
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.errors import AxisidError, UsageError
from axisid.support.remedy import Note, Remedy, Setting

from .bound import layout_for


def usable_records(
    axis: GeneratedAxis, records: Sequence[Record], as_given: Prefilter | None, *, skip_bad: bool
) -> tuple[list[int], dict[str, Note]]:
    """Which of several records the filter serves, and why not the others.

    One is refused later; without a filter all serve.

    Raises
    ------
    UsageError
        Some cannot be used, and are not to be skipped; or none is left.
    """
    if len(records) == 1 or as_given is None:
        return [*range(len(records))], {}
    filters = prefilters_of(as_given, records[0].period, [record.period for record in records])
    usable, bad = [], dict[str, Note]()
    pairs = zip(record_labels(records), records, filters, strict=True)
    for i, (name, record, prefilter) in enumerate(pairs):
        try:
            with np.errstate(all="ignore"):
                _ = FilteredRecord.bind(axis, record, prefilter).force
            usable.append(i)
        except AxisidError as error:
            bad[name] = error.note
    check_bad(bad, len(records), skip_bad=skip_bad)
    return usable, bad


def check_bad(bad: Mapping[str, Note], count: int, *, skip_bad: bool) -> None:
    """Refuse records that cannot be used, all of them at once, each with its reason.

    Raises
    ------
    UsageError
        They are not to be skipped, or all are bad.
    """
    if not bad or (skip_bad and len(bad) < count):
        return
    reasons = Note.joined(
        "; ", (Note.of(f"{name}: ", _unnamed(name, note)) for name, note in bad.items())
    )
    said = Note.of(f"{len(bad)} of {count} records cannot be used: ", reasons)
    if len(bad) < count:
        advice = Remedy.of(" Mend them, or go on without them: ", Setting("skip-bad"), ".")
        said = Note(said.text, Remedy.of(said.remedy or "", advice))
    raise UsageError(said.text, said.remedy, code="bad-records")


def _unnamed(name: str, note: Note) -> Note:
    """A reason that does not begin with the record's name once more."""
    text = note.text
    for said in (name, Path(name).name):
        text = text.removeprefix(f"{said}: ").removeprefix(f"{said}, ")
    return Note(text, note.remedy)


def layout_without(
    axis: GeneratedAxis,
    whole: JointForm | None,
    used: Sequence[int],
    aside: Mapping[str, Note],
    local: Sequence[str],
    known: Mapping[str, Sequence[Told]] | None,
    *,
    commanded: bool,
) -> tuple[JointForm | None, tuple[str, ...], dict[str, list[Told]], dict[str, Note]]:
    """What several records share, each has for itself, and is known of each, where some are left.

    Where one is left, its own parameters are those of all. The reasons are given again, the last of
    them with what is not identified without the records.

    Parameters
    ----------
    axis : GeneratedAxis
    whole : JointForm or None
        How the parameters of all records are shared.
    used : sequence of int
        The records that are left.
    aside : mapping of str to Note
        Why others are set aside.
    local, known, commanded
        As of `layout_for`, of all records.
    """
    own = tuple(local) if len(used) > 1 else ()
    of_used = {name: [values[i] for i in used] for name, values in (known or {}).items()}
    if not aside:
        return whole, own, of_used, {}
    left, why = layout_for(axis, len(used), own, of_used, commanded=commanded), dict(aside)
    if whole is not None and (lost := _lost(axis, whole, left, used)):
        name, note = list(why.items())[-1]
        why[name] = Note.of(note, f" Without {'it' if len(why) == 1 else 'these'} {lost}.")
    return left, own, of_used, why


def _lost(
    axis: GeneratedAxis, whole: JointForm, left: JointForm | None, used: Sequence[int]
) -> str:
    """What the records that are left identify no more, and why; empty for nothing."""
    alone = len(used) == 1
    said = []
    if whole.gain is not None and (left is None or left.gain is None):
        known = ", ".join(each.name for each in whole.known if each.differs)
        why = "1 record does not tell it" if alone else f"{known} is the same in all that are left"
        said.append(f"{GAIN} is not identified, as {why}, and the declared {whole.gain:g} believed")
    before = _shared(axis, whole)
    after = _shared(axis, left)
    gone = [name for name in before if name not in after]
    if gone:
        new = [name for name in after if name not in before]
        place = (
            f", and {' and '.join(new)} {'is' if len(new) == 1 else 'are'} identified"
            if new
            else ""
        )
        said.append(f"nothing tells {' and '.join(gone)} apart{place}")
    if alone and whole.local:
        verb = "is" if len(whole.local) == 1 else "are"
        said.append(f"{' and '.join(whole.local)} {verb} of the 1 record that is left")
    return ", and ".join(said)


def _shared(axis: GeneratedAxis, layout: JointForm | None) -> list[str]:
    """Names of the parameters that all records share."""
    if layout is None:
        return [p.name for p in axis.axis.parameters]
    own = {name for each in layout.local.values() for name in each}
    return [p.name for p in layout.parameters if p.name not in {*own, *layout.local, GAIN}]
