"""The records that are used of those that were given, those set aside, and what they share."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.choices import ROW_LOSSES, check_among
from axisid.estimation.parameters import GAIN, JointForm, KnownValue, prefilters_of
from axisid.estimation.problems import Problem, check_time_known
from axisid.estimation.records import Record, record_labels
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.errors import AxisidError, UsageError, quoted

from .bound import bound_records, layout_for, tells_gain, weighted


def usable_records(
    axis: GeneratedAxis, records: Sequence[Record], as_given: Prefilter | None, *, skip_bad: bool
) -> tuple[list[int], dict[str, str]]:
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
    usable, bad = [], dict[str, str]()
    pairs = zip(record_labels(records), records, filters, strict=True)
    for i, (name, record, prefilter) in enumerate(pairs):
        try:
            with np.errstate(all="ignore"):
                _ = FilteredRecord.bind(axis, record, prefilter).force
            usable.append(i)
        except AxisidError as error:
            bad[name] = str(error)
    check_bad(bad, len(records), skip_bad=skip_bad)
    return usable, bad


def check_bad(bad: Mapping[str, str], count: int, *, skip_bad: bool) -> None:
    """Refuse records that cannot be used, all of them at once, each with its reason.

    Raises
    ------
    UsageError
        They are not to be skipped, or all are bad.
    """
    if not bad or (skip_bad and len(bad) < count):
        return
    reasons = "; ".join(f"{name}: {_unnamed(name, note)}" for name, note in bad.items())
    said = f"{len(bad)} of {count} records cannot be used: {reasons}"
    if len(bad) < count:
        said += " Mend them, or go on without them: skip-bad."
    raise UsageError(said, code="record")


def _unnamed(name: str, note: str) -> str:
    """A reason that does not begin with the record's name once more."""
    for said in (name, Path(name).name):
        note = note.removeprefix(f"{said}: ").removeprefix(f"{said}, ")
    return note


def layout_without(
    axis: GeneratedAxis,
    whole: JointForm | None,
    used: Sequence[int],
    aside: Mapping[str, str],
    local: Sequence[str],
    known: Mapping[str, Sequence[KnownValue]] | None,
    *,
    commanded: bool,
) -> tuple[JointForm | None, tuple[str, ...], dict[str, list[KnownValue]], dict[str, str]]:
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
    aside : mapping of str to str
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
        why[name] = f"{note} Without {'it' if len(why) == 1 else 'these'} {lost}."
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


@dataclass(frozen=True, slots=True, kw_only=True)
class JointRecords:
    """Records that are used, what is each one's own, and what is known of each.

    Attributes
    ----------
    axis : GeneratedAxis
        That was asked of.
    own_layout : JointForm or None
        Its own.
    records : tuple of Record
    local : tuple of str
    known : mapping of str to sequence
        As `identify` takes it.
    commanded : bool
        Whether a known force may tell the drive gain.
    set_aside : mapping of str to str
        Records that are not used, with the reason.
    """

    axis: GeneratedAxis
    own_layout: JointForm | None
    records: tuple[Record, ...]
    local: tuple[str, ...]
    known: Mapping[str, Sequence[KnownValue]]
    commanded: bool
    set_aside: Mapping[str, str]

    def layout(self, axis: GeneratedAxis) -> JointForm | None:
        """How the parameters of an axis are shared; None where all are, of all records.

        A candidate may be without a parameter that others have for each record.

        Raises
        ------
        UsageError, ModelError
            As `layout_of` does.
        """
        if axis is self.axis:
            return self.own_layout
        declared = [p.name for p in axis.declared.parameters]
        own = [name for name in self.local if name in declared]
        return layout_for(axis, len(self.records), own, self.known, commanded=self.commanded)

    def axes(self, axis: GeneratedAxis, layout: JointForm | None) -> list[GeneratedAxis]:
        """That of each record, with what is known of it put in."""
        return [axis] * len(self.records) if layout is None else [m.axis for m in layout.members]

    def problem(
        self, axis: GeneratedAxis, prefilter: Prefilter, loss: str = ROW_LOSSES[0]
    ) -> Problem:
        """The records under a prefilter, each of its own axis, weighted by its own noise."""
        layout = self.layout(axis)
        into = () if layout is None else [*map(layout.slopes, range(len(self.records)))]
        data = bound_records(self.axes(axis, layout), self.records, prefilter, into)
        return weighted(Problem(axis=axis, data=data, layout=layout), loss)


def shared_records(
    axis: GeneratedAxis,
    records: Sequence[Record],
    prefilter: Prefilter | None,
    local: object,
    known: Mapping[str, Sequence[KnownValue]] | None,
    gain: str,
    *,
    skip_bad: bool,
) -> JointRecords:
    """The records that a prefilter serves, or all without one, and what is said of each.

    Parameters
    ----------
    axis : GeneratedAxis
        Of which names are checked, and what is not identified without records that are set aside.
    records : sequence of Record
    prefilter : Prefilter or None
        None where records are not filtered.
    local, known, gain, skip_bad
        As of `identify`.

    Raises
    ------
    UsageError, ModelError
        Records cannot be used, and are not to be skipped; a name is none; or what is known is not
        of each record.
    """
    own = _names("local", local)
    check_among(("gain", gain, ("identified", "declared")))
    check_time_known(axis)
    if not isinstance(skip_bad, bool):
        raise UsageError(f"skip_bad is {quoted(skip_bad)}; give True or False.", code="record")
    if own and len(records) == 1:
        raise UsageError(
            f"{', '.join(own)} {'is' if len(own) == 1 else 'are'} to be each record's own, "
            "and there is 1 record; give several, or leave local out.",
            code="parameters",
        )
    commanded = tells_gain(records, gain)
    whole = layout_for(axis, len(records), own, known, commanded=commanded)
    used, aside = usable_records(axis, records, prefilter, skip_bad=skip_bad)
    layout, own, known, aside = layout_without(
        axis, whole, used, aside, own, known, commanded=commanded
    )
    return JointRecords(
        axis=axis,
        own_layout=layout,
        records=tuple(records[i] for i in used),
        local=own,
        known=known,
        commanded=commanded,
        set_aside=aside,
    )


def _names(what: str, names: object) -> tuple[str, ...]:
    """Names that were given as one text or several."""
    if isinstance(names, str):
        return (names,) if names else ()
    if not isinstance(names, Iterable) or not all(isinstance(name, str) for name in names):
        raise UsageError(
            f"{what} is {quoted(names)}; give the names of parameters.", code="parameters"
        )
    return tuple(names)
