"""Text about records: size, columns, repairs, known values, and how they became rows."""

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
from axisid.support.wording import or_dash


def rows_text(
    samplings: Sequence[Sampling],
    used: int,
    force: Sequence[str],
    motions: Sequence[Sequence[str]],
) -> str:
    """Return a note on how records became the rows of one regression.

    Parameters
    ----------
    samplings : sequence of Sampling
        Filter and used samples of each record.
    used : int
        Number of rows of the regression.
    force : sequence of str
        Source of the force and remarks on it, from `force_told`.
    motions : sequence of sequence of str
        Measured quantities of the motion in each record.
    """
    masked = sum(sampling.masked_rows for sampling in samplings)
    quiet = sum(sampling.excluded_samples for sampling in samplings)
    lost = f", {masked} rows affected by masked samples left out" * bool(masked)
    lost += f", {quiet} samples near reversals and standstill left out before" * bool(quiet)
    taken, *said = force
    filters = dict.fromkeys(
        f"{_measured_text(motion)} low-passed by Butterworth {f.cutoff:g} Hz, order {f.order}, "
        f"forward and backward. Force: {'; '.join([f'{taken}, hold {f.hold}', *said])}."
        for f, motion in zip((each.filter.settings for each in samplings), motions, strict=True)
    )
    samples = sum(sampling.samples for sampling in samplings)
    return f"{used} rows of {samples} samples{_dropped(samplings)}{lost}. {' '.join(filters)}"


def _dropped(samplings: Sequence[Sampling]) -> str:
    """Return a clause on the samples dropped at the ends and on the decimation."""
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
    which = kept[0] if len({*kept}) == 1 else f"in the order of the records {', '.join(kept)}"
    return (
        f" in {len(samplings)} records: the filter's transients dropped at both ends of each, then "
        f"{which}"
    )


def force_told(drive: Drive, remark: str, *, is_gain: bool, measured: bool) -> tuple[str, ...]:
    """Return the source of the force as text, then remarks on the drive's timing and motor.

    Parameters
    ----------
    drive : Drive
    remark : str
        Remark on the motor; empty for none.
    is_gain : bool
        Whether the force is the gain times the control.
    measured : bool
        Whether the record has a column of the force; there are then no remarks.
    """
    if measured:
        return ("force column",)
    return (
        "drive gain x control" if is_gain else "drive model applied to the control",
        *filter(None, (drive.timing_text, remark)),
    )


def signals_text(signals: Sequence[Signal]) -> str:
    """Return a sentence on how recorded signals enter the rows; empty for none."""
    listed = ", ".join(f"{s.name} in {s.unit}" for s in signals)
    held = ", ".join(s.name for s in signals if s.is_held)
    mean = f"; {held}: mean of the values held before and after each sample" if held else ""
    return f" Recorded signals are not filtered: {listed}{mean}." if signals else ""


def _measured_text(motion: Sequence[str]) -> str:
    """Return the names of the quantities that are low-passed, as the start of a sentence."""
    *others, last = (role if role == "position" else f"measured {role}" for role in motion)
    text = f"{', '.join(others)} and {last}" if others else last
    return text[0].upper() + text[1:]


def record_facts(record: RecordInfo) -> dict[str, str]:
    """Return size, columns, assumptions and repairs of a record as texts by name."""
    source = record.provenance
    return {
        "record": f"{source.source}, {record.size}",
        "columns": ", ".join(f"{role} = {name}" for role, name in source.columns.items()),
        "assumed": "; ".join((*source.assumed, *source.doubts)),
        "repaired": "; ".join(repair.text for repair in source.repairs),
    }


def record_document(record: Record) -> Document:
    """Return a record as a document: its facts, and the range of each column in SI units."""
    table = text_table(
        ["", "minimum", "maximum", "range"],
        (
            (role, *(f"{x:.6g}" for x in (values.min(), values.max(), np.ptp(values))))
            for role, values in record.channels().items()
        ),
        said=("Values are in SI units.",),
    )
    return Heading(facts=record_facts(record)), table


def records_facts(
    records: Sequence[RecordInfo],
    known: Sequence[Mapping[str, tuple[float, float]]] = (),
    units: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, str]:
    """Return the facts of records as texts by name, for a heading.

    With several records the names are numbered, except for facts that are the same for all records.

    Parameters
    ----------
    records : sequence of RecordInfo
    known : sequence of mapping of str to (float, float)
        Known values of each record with their standard errors.
    units : mapping of str to str
        Units of the known values.
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
        # Each record has its own line, even if sources and sizes are equal.
        same = name != "record" and len({*each}) == 1
        facts |= {name if same else f"{name} {i}": text for i, text in enumerate(each, 1)}
    return facts


def set_aside_facts(set_aside: Mapping[str, str]) -> dict[str, str]:
    """Return a text on the records that could not be used, with reasons; empty without any.

    `set_aside` has the reason by record.
    """
    counted = f"{len(set_aside)} record{'s' * (len(set_aside) > 1)}"
    reasons = (
        f"{n} ({why.removeprefix(f'{Path(n).name}: ').removesuffix('.')})"
        for n, why in set_aside.items()
    )
    return {"set aside": f"{counted}: {'; '.join(reasons)}"} if set_aside else {}


def records_table(result: SavedIdentification) -> TableBlock:
    """Return a table of the records, with errors by the judged estimate."""
    return text_table(
        (
            *("record", "rows", "weight", "noise", "equation error", "simulation error"),
            *("difference", "p"),
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
    """Return notes on how several records became one estimate; none for a single record."""
    if not result.of_records:
        return []
    weights = ", ".join(f"{of_one.weight:.3g}" for of_one in result.of_records)
    gain = result.declared_gain
    return [
        "All records are fitted in one regression; rows of different records are not neighbours. "
        "Rows are weighted by the inverse of the record's noise, which is its residual in a first "
        "least-squares fit of all records (feasible generalised least squares); weights "
        f"{weights}.",
        f"Table of records: errors by {result.preferred.method.upper()} in percent. Noise: rms "
        "residual in the unit of the force. Difference: change of the force if the record has its "
        "own parameters, in percent of its force; p: probability that noise alone causes such a "
        "difference.",
        *local_notes(result.local_names),
        *(
            []
            if gain is None
            else [
                f"drive_gain: identified from the known force; the declared value is {gain:g} "
                f"{result.preferred.parameters['drive_gain'].unit}. Standard errors of the other "
                "parameters include its uncertainty."
            ]
        ),
        *(
            [
                "Standard errors include the uncertainty of the known values. Known values that "
                "are equal and have equal standard errors count as one measurement."
            ]
            if any(sd for of_one in result.of_records for _, sd in of_one.known.values())
            else []
        ),
    ]


def local_notes(local: Mapping[str, Sequence[str]]) -> list[str]:
    """Return a note on each declared parameter that has a separate value for each record.

    Parameters
    ----------
    local : mapping of str to sequence of str
        Names of the separate parameters, by declared parameter; empty if a parameter is identified
        only in products.
    """
    return [
        f"{', '.join(dict.fromkeys(filter(None, names)))}: {name} of the records, in their order."
        if any(names)
        else f"{name}: one value per record, identified only in products; numbered by record."
        for name, names in local.items()
    ]
