"""Records in words, one or several: size, columns, repairs, what is known, how they became rows."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np

from axisid.estimation.identification import RecordInfo
from axisid.estimation.records import Record
from axisid.estimation.signals import Sampling
from axisid.modeling.declaration import Drive, known_text
from axisid.modeling.quantities import Signal
from axisid.presentation.documents import Document, Heading, TableBlock, text_table
from axisid.presentation.result_files import SavedIdentification
from axisid.support.errors import or_dash


def rows_text(
    samplings: Sequence[Sampling],
    used: int,
    force: Sequence[str],
    motions: Sequence[Sequence[str]],
) -> str:
    """How records became the rows of one regression, for the notes of a table.

    Parameters
    ----------
    samplings : sequence of Sampling
        Of each record.
    used : int
        Rows of the regression.
    force : sequence of str
        What is taken as the force, as `force_told` has it.
    motions : sequence of sequence of str
        What of the motion was measured in each record.
    """
    masked = sum(sampling.masked_rows for sampling in samplings)
    quiet = sum(sampling.excluded_samples for sampling in samplings)
    lost = f", {masked} left out that masked samples reach" * bool(masked)
    lost += f", {quiet} samples near reversals and rests left out before" * bool(quiet)
    taken, *said = force
    filters = dict.fromkeys(
        f"{_measured_text(motion)} low-passed by Butterworth {f.cutoff:g} Hz, order {f.order}, "
        f"forward and backward. Force: {'; '.join([f'{taken}, hold {f.hold}', *said])}."
        for f, motion in zip((each.filter.settings for each in samplings), motions, strict=True)
    )
    samples = sum(sampling.samples for sampling in samplings)
    return f"{used} rows of {samples} samples{_dropped(samplings)}{lost}. {' '.join(filters)}"


def _dropped(samplings: Sequence[Sampling]) -> str:
    """Which samples are of no row, and which of the others are."""
    kept = [
        "all kept" if f.decimate == 1 else f"one in {f.decimate} kept ({f.decimation} alignment)"
        for f in (sampling.filter.settings for sampling in samplings)
    ]
    if len(samplings) == 1:
        (sampling,) = samplings
        start, end = sampling.filter.dropped
        used, there = len(sampling.spans), len(sampling.segments)
        of = f"{there} segments"
        of = of if used == there else f"{used} of {of} (the others are too short)"
        pieces, each = (f" in {of}", " of each") if there else ("", "")
        return f"{pieces}: {start} dropped at the start, {end} at the end{each}, then {kept[0]}"
    which = kept[0] if len({*kept}) == 1 else f"of the records in their order {', '.join(kept)}"
    return (
        f" in {len(samplings)} records: the filter's transients dropped at both ends of each, then "
        f"{which}"
    )


def force_told(drive: Drive, remark: str, *, is_gain: bool, measured: bool) -> tuple[str, ...]:
    """What is taken as the force, and what is said of how it acts."""
    if measured:
        return ("force column",)
    return (
        "drive gain x control" if is_gain else "what the drive makes of the control",
        *filter(None, (drive.timing_text, remark)),
    )


def signals_text(signals: Sequence[Signal]) -> str:
    """How recorded signals stand in the rows, in a sentence; empty for none."""
    listed = ", ".join(f"{s.name} in {s.unit}" for s in signals)
    held = ", ".join(s.name for s in signals if s.is_held)
    mean = f"; {held} by the mean of what is held before and after" if held else ""
    return f" Recorded signals as they were recorded: {listed}{mean}." if signals else ""


def _measured_text(motion: Sequence[str]) -> str:
    """What passes the low-pass."""
    *others, last = (role if role == "position" else f"measured {role}" for role in motion)
    text = f"{', '.join(others)} and {last}" if others else last
    return text[0].upper() + text[1:]


def record_facts(record: RecordInfo) -> dict[str, str]:
    """What a heading says of a record: its size, columns, what was assumed and repaired."""
    source = record.provenance
    return {
        "record": f"{source.source}, {record.size}",
        "columns": ", ".join(f"{role} = {name}" for role, name in source.columns.items()),
        "assumed": "; ".join((*source.assumed, *source.doubts)),
        "repaired": "; ".join(repair.text for repair in source.repairs),
    }


def record_document(record: Record) -> Document:
    """Where it comes from, what was assumed and repaired, and how far its columns reach."""
    table = text_table(
        ["", "least", "most", "range"],
        (
            (role, *(f"{x:.6g}" for x in (values.min(), values.max(), np.ptp(values))))
            for role, values in record.channels().items()
        ),
        said=("Values are SI.",),
    )
    return Heading(facts=record_facts(record)), table


def records_facts(
    records: Sequence[RecordInfo],
    known: Sequence[Mapping[str, tuple[float, float]]] = (),
    units: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, str]:
    """What a heading says of records, numbered if several; what is the same of all is told once.

    Parameters
    ----------
    records : sequence of RecordInfo
    known : sequence of mapping of str to (float, float)
        What is known of each, with its deviation.
    units : mapping of str to str
        Of what is known.
    """
    told = [record_facts(record) for record in records]
    for own, of_one in zip(told, known, strict=False):
        listed = (
            f"{name} = {known_text(*value)} {units.get(name, '')}".rstrip()
            for name, value in of_one.items()
        )
        own["record"] = "; ".join([own["record"], *listed])
    if len(told) == 1:
        return told[0]
    facts: dict[str, str] = {}
    for name in told[0]:
        each = [own[name] for own in told]
        # Records of one source and size are told one by one all the same.
        same = name != "record" and len({*each}) == 1
        facts |= {name if same else f"{name} {i}": text for i, text in enumerate(each, 1)}
    return facts


def set_aside_facts(set_aside: Mapping[str, str]) -> dict[str, str]:
    """Records that could not be used, with the reason."""
    counted = f"{len(set_aside)} record{'s' * (len(set_aside) > 1)}"
    reasons = (
        f"{n} ({why.removeprefix(f'{Path(n).name}: ').removesuffix('.')})"
        for n, why in set_aside.items()
    )
    return {"set aside": f"{counted}: {'; '.join(reasons)}"} if set_aside else {}


def records_table(result: SavedIdentification) -> TableBlock:
    """Each record beside the others, by the estimate that is judged."""
    return text_table(
        (
            *("record", "rows", "weight", "noise", "equation error", "simulation error"),
            *("apart", "chance"),
        ),
        (
            (
                f"{i}  {of_one.record.provenance.source}",
                str(of_one.rows),
                f"{of_one.weight:.3g}",
                f"{of_one.noise:.3g}",
                f"{of_one.equation_error_percent:.4f}",
                or_dash(of_one.simulation_error_percent, ".4f"),
                or_dash(of_one.share_percent, ".2g"),
                or_dash(of_one.p_value, ".2g"),
            )
            for i, of_one in enumerate(result.of_records, 1)
        ),
    )


def several_notes(result: SavedIdentification) -> list[str]:
    """How several records became one estimate; nothing of one."""
    if not result.of_records:
        return []
    weights = ", ".join(f"{of_one.weight:.3g}" for of_one in result.of_records)
    gain = result.declared_gain
    return [
        "One regression of all records, none of whose rows is a neighbour of another record's. "
        f"Rows are weighted by the inverse of each record's noise, weights {weights}: what least "
        "squares of all leaves of each in a first pass (feasible generalised least squares).",
        f"Records one by one: errors by {result.preferred.method.upper()}, percent. Noise: "
        "residuals, root mean square, in the unit of the force. Apart: force that the parameters "
        "which the record has alone make otherwise, percent of its force; chance: that noise alone "
        "makes as much.",
        *local_notes(result.local_names),
        *(
            []
            if gain is None
            else [
                f"drive_gain: identified by the known force; {gain:g} "
                f"{result.preferred.parameters['drive_gain'].unit} is declared. The deviations of "
                "the other parameters contain its own."
            ]
        ),
        *(
            [
                "Deviations contain what those of the known values add; equal values with equal "
                "deviations are taken as one thing, weighed once."
            ]
            if any(sd for of_one in result.of_records for _, sd in of_one.known.values())
            else []
        ),
    ]


def local_notes(local: Mapping[str, Sequence[str]]) -> list[str]:
    """What records have for themselves, by the names that it has in each."""
    return [
        f"{', '.join(dict.fromkeys(filter(None, names)))}: {name} of each record, in their order."
        if any(names)
        else f"{name}: each record has its own, in products alone, numbered in their order."
        for name, names in local.items()
    ]
