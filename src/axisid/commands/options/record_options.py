"""Options of every command that reads a record; all else of a log is said in its run.toml."""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from axisid.estimation.choices import LOG_KEYS

from . import stages
from .groups import Options, option


def is_log(file: str) -> bool:
    """Whether an argument is a log, by its ending, or a run.toml, which stands in its place."""
    return Path(file).suffix.lower() in stages.log_endings() or stages.log_of(file) != Path(file)


def _roles(text: str | None) -> dict[str, str]:
    """Columns by role."""
    found: dict[str, str] = {}
    for pair in next(csv.reader([text], skipinitialspace=True)) if text else ():
        role, equals, column = (part.strip() for part in pair.partition("="))
        if not equals or not role or not column or role in found:
            raise click.BadParameter(
                f"{pair!r} is not ROLE=NAME or ROLE=NAME:UNIT with each role once, as in "
                "time=t,position=qm:mm; quote a pair whose name has a comma: "
                'time=t,"control=I, raw"'
            )
        found[role] = column
    return found


def _rate(text: str | None) -> float | str | None:
    """Hertz, where it is a number."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return text


def _of_log(key: str, read: Callable[[Any], Any] | None = None, **how: Any) -> Any:
    """The option of a key."""
    row = LOG_KEYS[key]
    return option(row.said, name=row.option, read=read, metavar=row.metavar, **how)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading(Options):
    """What the command line says of a log."""

    columns: dict[str, str] = _of_log("columns", _roles)
    windows: tuple[str, ...] = _of_log("windows", multiple=True)
    resample: float | str | None = _of_log("resample", _rate)
    gaps: str | None = _of_log("gaps")

    @property
    def given(self) -> list[str]:
        """Names of the options that were given."""
        return [name for field, name in self.names().items() if getattr(self, field)]

    def record(
        self, file: str, axis: "stages.GeneratedAxis", *, whole: bool = False
    ) -> "stages.Record":
        """Read a log as the record of an axis, whole or within the windows."""
        given = self.settings()
        return stages.read_record(file, axis, **given if not whole else {**given, "windows": ()})

    def settings(self) -> dict[str, Any]:
        """Arguments of `read_record`."""
        said = self.arguments()
        repairs = {key: said.pop(key) for key in [*said] if LOG_KEYS[key].is_repair}
        return {**said, "repairs": stages.Repairs(**repairs)}
