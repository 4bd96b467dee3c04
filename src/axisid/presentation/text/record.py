"""Text about records: size, columns, repairs, known values, and the rows of the regression."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np

from axisid.estimation.identification import RecordInfo
from axisid.estimation.records import Record
from axisid.estimation.signals import Sampling
from axisid.estimation.thresholds import MIN_ROW_WEIGHT
from axisid.modeling.declaration import Drive, known_text
from axisid.modeling.quantities import Signal
from axisid.presentation.documents import (
    Document,
    Heading,
    TableBlock,
    TableColumn,
    text_columns,
    text_table,
)
from axisid.presentation.result_files import SavedIdentification
from axisid.support.wording import or_dash


def rows_text(
    samplings: Sequence[Sampling],
    used: int,
    force: Sequence[str],
    motions: Sequence[Sequence[str]],
) -> str:
    """Return a note on the rows of one regression: their number, the filters and the force.

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
    source, *remarks = force
    # Records with equal filters and quantities share their sentences.
    filters: dict[str, None] = {}
    for sampling, motion in zip(samplings, motions, strict=True):
        settings = sampling.filter.settings
        text = (
            f"Low-pass of the {_measured_text(motion)}: Butterworth, {settings.cutoff:g} Hz, order "
            f"{settings.order}, forward and backward. {source}{_HOLDS[settings.hold]}"
        )
        filters[text] = None
    samples = sum(sampling.samples for sampling in samplings)
    return " ".join(
        (
            f"{used} rows from {samples} samples{_segments(samplings)}.",
            *filters,
            *remarks,
            *_rows_in_steps(samplings),
        )
    )


#: Sentences on the force that is paired with a sample of the motion, by `Prefilter.hold`.
_HOLDS: Mapping[str | None, str] = {
    None: "",
    "zoh": " Each sample of the motion is paired with the mean of the force before and the force "
    "after the sample (hold = zoh).",
    "raw": " Each sample of the motion is paired with the force after the sample (hold = raw).",
}
#: Ends of a record to which the rows are aligned, by `Prefilter.decimation`.
_ALIGNMENTS: Mapping[str, str] = {
    "matlab": "counted from the end of the record, as in MATLAB's decimate",
    "scipy": "counted from the start of the record, as in SciPy's decimate",
}


def _segments(samplings: Sequence[Sampling]) -> str:
    """Return the number of records, or of segments of a single record, after a blank."""
    if len(samplings) > 1:
        return f" in {len(samplings)} records"
    (sampling,) = samplings
    used, number = len(sampling.spans), len(sampling.segments)
    if not number:
        return ""
    if used != number:
        return f" in {used} of {number} segments (the others are too short)"
    return f" in {number} segments"


def _rows_in_steps(samplings: Sequence[Sampling]) -> list[str]:
    """Return sentences on the steps from filtered samples to rows, in the order of the steps."""
    sentences = []
    excluded = sum(sampling.excluded_samples for sampling in samplings)
    masked = sum(sampling.masked_rows for sampling in samplings)
    if excluded:
        sentences.append(
            f"Before the decimation, {excluded} samples near reversals and standstill get the "
            "weight 0."
        )
    if len(samplings) == 1:
        (sampling,) = samplings
        start, end = sampling.filter.dropped
        of_each = " of each segment" if sampling.segments else ""
        sentences.append(f"{start} samples are dropped at the start and {end} at the end{of_each}.")
    else:
        sentences.append("The filter's transients are dropped at both ends of each record.")
    kept = []
    for sampling in samplings:
        settings = sampling.filter.settings
        if settings.decimate == 1:
            kept.append("all samples are kept")
        else:
            alignment = _ALIGNMENTS[settings.decimation]
            kept.append(f"one sample in {settings.decimate} is kept, {alignment}")
    if len({*kept}) > 1:
        sentences.append(f"Then, in the order of the records: {'; '.join(kept)}.")
    elif samplings[0].filter.settings.decimate == 1:
        sentences.append("All other samples are kept.")
    else:
        sentences.append(f"Then a decimation filter is applied, and {kept[0]}.")
    if excluded:
        sentences.append(
            "A kept sample is a row if the samples that its decimation filter combines have more "
            f"than {100 * MIN_ROW_WEIGHT.value:g} % of their full weight."
        )
    if masked:
        sentences.append(f"{masked} rows that masked samples affect are excluded.")
    return sentences


def force_told(drive: Drive, remark: str, *, is_gain: bool, measured: bool) -> tuple[str, ...]:
    """Return sentences: the source of the force in the rows, then the drive's timing and motor.

    Parameters
    ----------
    drive : Drive
    remark : str
        Remark on the motor; empty for none.
    is_gain : bool
        True if the force is the gain times the control.
    measured : bool
        True if the record has a column of the force; there are then no remarks.
    """
    if measured:
        return ("The force is that of the force column.",)
    source = "The force is that of the drive model for the control."
    if is_gain:
        source = "The force is the drive gain times the control."
    remarks = "; ".join(filter(None, (drive.timing_text, remark))).split("; ")
    return (source, *(f"{text[0].upper()}{text[1:]}." for text in remarks if text))


def signals_text(signals: Sequence[Signal]) -> str:
    """Return a sentence on the recorded signals in the rows, after a blank; empty for none."""
    if not signals:
        return ""
    listed = ", ".join(f"{s.name} in {s.unit}" for s in signals)
    held = ", ".join(s.name for s in signals if s.is_held)
    mean = f"; {held}: mean of the values held before and after each sample" if held else ""
    return f" Recorded signals are not filtered: {listed}{mean}."


def _measured_text(motion: Sequence[str]) -> str:
    """Return the names of the measured quantities of the motion, within a sentence."""
    *others, last = (role if role == "position" else f"measured {role}" for role in motion)
    return f"{', '.join(others)} and {last}" if others else last


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
    """Return a record as a document: its facts, and the range of each signal in SI units."""
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
    """Return size, columns, assumptions and repairs of records as texts by name, for a heading.

    With several records the names are numbered, except for facts that are the same for all records.
    Known values are part of the fact ``record``.

    Parameters
    ----------
    records : sequence of RecordInfo
    known : sequence of mapping of str to (float, float)
        Known values of each record with their standard errors; empty for none.
    units : mapping of str to str
        Units of the known values.
    """
    by_record = [record_facts(record) for record in records]
    for facts_of_one, known_of_one in zip(by_record, known, strict=False):
        values = (
            f"{name} = {known_text(*value)} {units.get(name, '')}".rstrip()
            for name, value in known_of_one.items()
        )
        facts_of_one["record"] = "; ".join([facts_of_one["record"], *values])
    if len(by_record) == 1:
        return by_record[0]
    facts: dict[str, str] = {}
    for name in by_record[0]:
        texts = [facts_of_one[name] for facts_of_one in by_record]
        # Each record has its own line, even if sources and sizes are equal.
        is_common = name != "record" and len({*texts}) == 1
        for i, text in enumerate(texts, 1):
            facts[name if is_common else f"{name} {i}"] = text
    return facts


def set_aside_facts(set_aside: Mapping[str, str]) -> dict[str, str]:
    """Return the fact ``not used``: the records that could not be used, with reasons.

    Parameters
    ----------
    set_aside : mapping of str to str
        Reason by record; if it is empty, so is the result.
    """
    if not set_aside:
        return {}
    count = "1 record" if len(set_aside) == 1 else f"{len(set_aside)} records"
    reasons = (
        f"{name} ({why.removeprefix(f'{Path(name).name}: ').removesuffix('.')})"
        for name, why in set_aside.items()
    )
    return {"not used": f"{count}: {'; '.join(reasons)}"}


def records_table(result: SavedIdentification) -> TableBlock:
    """Return a table of the records: rows, weight, residual, errors, and difference of each.

    The errors are those of the judged estimate. The unit of the force is known only if the result
    has its declared axis.
    """
    force_unit = ""
    if result.declared is not None:
        force_unit = str(result.declared.coordinate.force_unit)
    return TableBlock(
        columns=(
            *text_columns(["record", "rows", "weight"]),
            TableColumn("residual", force_unit),
            TableColumn("equation", "%"),
            TableColumn("simulation", "%"),
            TableColumn("difference", "%"),
            TableColumn("p"),
        ),
        rows=tuple(
            (
                f"{i}  {member.record.provenance.source}",
                str(member.rows),
                f"{member.weight:.3g}",
                f"{member.noise:.3g}",
                f"{member.equation_error_percent:.4f}",
                or_dash(member.simulation_error_percent, ".4f"),
                or_dash(member.share_percent, ".2g"),
                or_dash(member.p_value, ".2g"),
            )
            for i, member in enumerate(result.of_records, 1)
        ),
        title="Records",
        said=(
            "weight: factor of the record's rows in the regression. residual: rms residual of the "
            f"{result.preferred.method.upper()} estimate. equation, simulation: equation error and "
            f"simulation error of the {result.preferred.method.upper()} estimate, relative to the "
            "force (rms).",
            "difference: change of the force if the record gets its own parameters, relative to "
            "its force (rms). p: p-value of this difference.",
        ),
    )


def several_notes(result: SavedIdentification) -> list[str]:
    """Return notes on the common regression of several records; none for a single record."""
    if not result.of_records:
        return []
    weights = ", ".join(f"{member.weight:.3g}" for member in result.of_records)
    gain = result.declared_gain
    notes = [
        "All records are fitted in one regression; rows of different records are not neighbours. "
        "Rows are weighted by the inverse of the record's noise, which is its residual in a first "
        "least-squares fit of all records (feasible generalised least squares); weights "
        f"{weights}.",
        "Table of records: equation and simulation error in percent of the measured quantity. p: "
        "probability that noise alone causes such a difference.",
        *local_notes(result.local_names),
    ]
    if gain is not None:
        notes.append(
            f"drive_gain: identified from the known force; the declared value is {gain:g} "
            f"{result.preferred.parameters['drive_gain'].unit}. Standard errors of the other "
            "parameters include its uncertainty."
        )
    if any(sd for member in result.of_records for _, sd in member.known.values()):
        notes.append(
            "Standard errors include the uncertainty of the known values. Known values that are "
            "equal and have equal standard errors count as one measurement."
        )
    return notes


def local_notes(local: Mapping[str, Sequence[str]]) -> list[str]:
    """Return a note on the names of each declared parameter with a separate value per record.

    Parameters
    ----------
    local : mapping of str to sequence of str
        Names of the separate parameters by record, by declared parameter; a name is empty if the
        parameter is identified only in products.
    """
    notes = []
    for name, names in local.items():
        if any(names):
            different = ", ".join(dict.fromkeys(filter(None, names)))
            notes.append(f"{different}: {name} of the records, in their order.")
        else:
            notes.append(
                f"{name}: one value per record, identified only in products; numbered by record."
            )
    return notes
