"""A record in words: its size, columns, repairs, and how it became rows."""

import numpy as np

from axisid.estimation.identification import RecordInfo
from axisid.estimation.records import Record
from axisid.estimation.signals import Sampling
from axisid.modeling.declaration import Drive
from axisid.presentation.blocks import Document, Heading, Table, text_columns
from axisid.support.remedy import Wording, as_arguments


def rows_text(sampling: Sampling, used: int, drive: Drive, *, measured: bool) -> str:
    """How a record became the rows of a regression, for the notes of a table.

    Parameters
    ----------
    sampling : Sampling
    used : int
        Rows of the regression.
    drive : Drive
    measured : bool
        Whether the force was.
    """
    start, end = sampling.filter.dropped
    masked, quiet = sampling.masked_rows, sampling.excluded_samples
    lost = f", {masked} left out that masked samples reach" if masked else ""
    each = " of each" if sampling.segments else ""
    lost += f", {quiet} samples near reversals and rests left out before" if quiet else ""
    return (
        f"{used} rows of {sampling.samples} samples{_of_segments(sampling)}: {start} dropped at "
        f"the start, {end} at the end{each}, then {kept_text(sampling)}{lost}. "
        f"{filter_text(sampling, drive, measured=measured)}"
    )


def kept_text(sampling: Sampling) -> str:
    """Which of the samples that are not dropped become rows."""
    f = sampling.prefilter
    return "all kept" if f.decimate == 1 else f"one in {f.decimate} kept ({f.decimation} alignment)"


def filter_text(sampling: Sampling, drive: Drive, *, measured: bool) -> str:
    """The low-pass and the force, in sentences."""
    f = sampling.prefilter
    commanded = "drive gain x control" if drive.is_gain else "what the drive makes of the control"
    force = "force column" if measured else commanded
    return (
        f"Position low-passed by Butterworth {f.cutoff:g} Hz, order {f.order}, forward and "
        f"backward. Force: {force}, hold {f.hold}."
    )


def _of_segments(sampling: Sampling) -> str:
    if not sampling.segments:
        return ""
    used, there = len(sampling.spans), len(sampling.segments)
    if used == there:
        return f" in {there} segments"
    return f" in {used} of {there} segments (the others are too short)"


def record_facts(record: RecordInfo, wording: Wording) -> dict[str, str]:
    """What a heading says of a record: its size, columns, what was assumed and repaired."""
    source = record.provenance
    assumed = (*source.assumed, *(doubt.worded(wording) for doubt in source.doubts))
    return {
        "record": f"{source.source}, {record.size}",
        "columns": ", ".join(f"{role} = {name}" for role, name in source.columns.items()),
        "assumed": "; ".join(assumed),
        "repaired": "; ".join(repair.text for repair in source.repairs),
    }


def record_document(record: Record, *, wording: Wording = as_arguments) -> Document:
    """Where it comes from, what was assumed and repaired, and how far its columns reach."""
    rows = tuple(
        (role, *(f"{x:.6g}" for x in (values.min(), values.max(), np.ptp(values))))
        for role, values in record.channels().items()
    )
    columns = text_columns(["", "least", "most", "range"])
    table = Table(columns=columns, rows=rows, said=("Values are SI.",))
    return Heading(facts=tuple(record_facts(record, wording).items())), table
