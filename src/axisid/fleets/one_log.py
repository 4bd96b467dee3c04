"""One log: read, identified, judged, written; by whichever process works on it."""

from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

from axisid.codegen.artefacts import replace_file
from axisid.estimation.identification import Identification, identify
from axisid.estimation.records import read_record
from axisid.fleets.items import FleetItem
from axisid.support.errors import AxisidError, DataError, UsageError
from axisid.support.files.json_text import json_text
from axisid.support.remedy import as_options

from .row import FleetRow, judged
from .settings import LOG_NOT_READ, Settings, log_digest

_NOT_WRITTEN = "fleet-result-not-written"


@dataclass(frozen=True, slots=True, kw_only=True)
class Named:
    """An item with the name of its result."""

    name: str
    item: FleetItem

    def row(self, **what: Any) -> FleetRow:
        """A row of it."""
        said = {
            name: getattr(self.item, name) for name in ("log", "serial", "columns", "conditions")
        }
        return FleetRow(name=self.name, **{"axis": self.item.axis, **said, **what})


def result_file(folder: str | Path, name: str) -> Path:
    """Where the result of a log is."""
    return Path(folder, f"{name}.json")


def identify_log(settings: Settings, named: Named) -> FleetRow:
    """Identify an axis from one log and write the result; what is wrong with the log is told.

    What is no fault of the log or the options is raised.
    """
    begin = process_time()
    key, axis = "", named.item.axis or str(getattr(settings.axis, "name", settings.axis))
    try:
        generated = settings.generated(named.item)
        axis = generated.axis.name
        key = _key(settings, named.item)
        document = result_of(settings, named.item).to_dict(settings.draws)
        _write(document, result_file(settings.folder, named.name))
    except AxisidError as error:
        said = " ".join(error.worded(as_options).split())
        return named.row(
            axis=axis,
            status="failed",
            reason=said,
            code=error.code,
            key="" if error.code == _NOT_WRITTEN else key,  # another time there may be room
            seconds=process_time() - begin,
        )
    return named.row(
        axis=axis, status="ok", key=key, **judged(document), seconds=process_time() - begin
    )


def _key(settings: Settings, item: FleetItem) -> str:
    try:
        return settings.key(item, log_digest(Path(item.log)))
    except OSError as error:
        raise DataError(
            f"{item.log} cannot be read: {error.strerror}. Check the path.",
            code=LOG_NOT_READ,
        ) from error


def _write(document: dict[str, Any], file: Path) -> None:
    """Write the result whole or not at all."""
    try:
        replace_file(file, json_text(document))
    except OSError as error:
        raise UsageError(
            f"{file} cannot be written: {error.strerror}; make room for it and resume, or name "
            "another folder.",
            code=_NOT_WRITTEN,
        ) from error


def result_of(settings: Settings, item: FleetItem) -> Identification:
    """What is identified from a log.

    Raises
    ------
    AxisidError
        As `read_record` and `identify`.
    """
    generated = settings.generated(item)
    reading = {**settings.reading, **({"columns": item.columns} if item.columns else {})}
    record = read_record(item.log, generated, **reading)
    return identify(generated, record, settings.prefilter, **settings.identifying)
