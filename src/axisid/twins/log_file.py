"""The log of a twin, which says what is true of it."""

from pathlib import Path

from axisid.estimation.records import Record
from axisid.estimation.records.columns import log_content
from axisid.modeling.declaration import Axis

#: What the file of a twin's log says it is.
MARK = "axisid.twin/1"
#: Endings of logs.
ENDINGS = (".csv", ".parquet")


def twin_content(record: Record, axis: Axis, file: Path) -> str | bytes:
    """The content of a log with the units of its columns and the truth of its twin.

    Raises
    ------
    ModelError, DataError
        As `log_content`.
    """
    units = {parameter.name: parameter.unit for parameter in axis.parameters}
    truth = {name: record.provenance.truth[name] for name in units}
    told = ", ".join(f"{name} = {value:.9g} {units[name]}" for name, value in truth.items())
    about = f"{record.provenance.source}; true values {told}"
    return log_content(record.channels(), axis, MARK, about, file)
