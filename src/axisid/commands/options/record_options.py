"""Options of every command that reads a record."""

import csv
import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal, cast

import click

from . import stages
from .groups import Options, option

#: First and last time, s; None for the log's own.
Window = tuple[float | None, float | None]

_GIGABYTE = 1e9
_COLUMNS = (
    'as in time=t,position=qm:mm; quote a pair whose name has a comma: time=t,"control=I, raw"'
)
_SHIFTS = "N in samples or a time, as in control=1 or control=2ms"
_BETWEEN = "as in velocity=spline or velocity=linear"
_NOTHING: tuple[Any, ...] = (None, (), {})


def is_log(file: str) -> bool:
    """Whether an argument is a log, by its ending."""
    return Path(file).suffix.lower() in stages.log_endings()


def _period(sample_period: float | None) -> float | None:
    if sample_period is not None and not (math.isfinite(sample_period) and sample_period > 0):
        raise click.BadParameter(
            f"{sample_period!r} is no period; give a positive number of seconds"
        )
    return sample_period


def _bytes(gigabytes: float | None) -> float | None:
    if gigabytes is None:
        return None
    if not gigabytes > 0:
        raise click.BadParameter(
            f"{gigabytes!r} is no amount of memory; give a positive number of GB"
        )
    return gigabytes * _GIGABYTE


def _rate(text: str | None) -> float | Literal["auto"] | None:
    if text is None:
        return None
    if text == "auto":
        return "auto"
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not (math.isfinite(rate) and rate > 0):
        raise click.BadParameter(f"{text!r} is no rate; give hertz, or auto")
    return rate


def read_windows(texts: tuple[str, ...]) -> tuple[Window, ...]:
    """The times of each ``FROM..TO``."""
    return tuple(map(window_of, texts))


def window_of(text: str) -> Window:
    """The times of ``FROM..TO``, of which one may be left out."""
    first, dots, last = (part.strip() for part in text.partition(".."))
    try:
        start, stop = (float(part) if part else None for part in (first, last))
    except ValueError:
        dots = ""
    if not dots or (start is None and stop is None):
        raise click.BadParameter(
            f"{text!r} is no window; give FROM..TO in seconds, such as 2..5, 2.. or ..5"
        )
    return start, stop


def _amounts(what: str, such: str, text: str | None) -> dict[str, str]:
    """What is said of columns by role."""
    found: dict[str, str] = {}
    for pair in next(csv.reader([text], skipinitialspace=True)) if text else ():
        role, equals, amount = (part.strip() for part in pair.partition("="))
        if not equals or not role or not amount or role in found:
            raise click.BadParameter(f"{pair!r} is not ROLE={what} with each role once, {such}")
        found[role] = amount
    return found


roles = partial(_amounts, "NAME or ROLE=NAME:UNIT", _COLUMNS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading(Options):
    """How a log is to be read, as the command line says it."""

    start: float | None = option(
        "Take the log from this time on, s, as its own time counts.",
        name="from",
        type=float,
        metavar="S",
    )
    stop: float | None = option(
        "Take the log up to this time, s.", name="to", type=float, metavar="S"
    )
    columns: dict[str, str] = option(
        "Columns by name or number (#3); roles: time, position, velocity and acceleration "
        "(measured), reference, control, force, injected (a test signal), signals that AXIS "
        "declares; units such as mm, deg, rpm, ms, mA, or a scaling: "
        "position=inc:counts*360deg/4096/50+0.2deg.",
        read=roles,
        metavar="ROLE=NAME[:UNIT],...",
    )
    injected_at: Literal["control", "reference"] | None = option(
        "What the test signal in the column injected was added to; to the control before the "
        "drive's limit.",
        type=click.Choice(["control", "reference"]),
    )
    sample_period: float | None = option(
        "In place of the time column's mean step; confirms that the log is not sampled as "
        "the control law runs, which is then simulated at its own period.",
        read=_period,
        type=float,
        metavar="S",
    )
    windows: tuple[Window, ...] = option(
        "Take only this part of the log, s; again for each, filtered and simulated by itself.",
        name="window",
        read=read_windows,
        multiple=True,
        metavar="FROM..TO",
    )
    shift: dict[str, str] = option(
        "Move a column N samples to later times, or by a time such as 2ms, where the log "
        "wrote it too early: control=1.",
        read=partial(_amounts, "N", _SHIFTS),
        metavar="ROLE=N,...",
    )
    between: dict[str, str] = option(
        "What a measured velocity, acceleration or force is between its values, where they "
        "are written in every few samples alone: spline, linear or held.",
        read=partial(_amounts, "HOW", _BETWEEN),
        metavar="ROLE=HOW,...",
    )
    resample: float | Literal["auto"] | None = option(
        "Uneven or different times onto an even grid.", read=_rate, metavar="HZ|auto"
    )
    gaps: Literal["split"] | None = option(
        "Cut the log where samples are missing or its clock goes back; each piece is "
        "filtered by itself.",
        type=click.Choice(["split"]),
    )
    wrap: str | None = option(
        "Undo jumps of the position by it, as in 360:deg; give others a lost sign back, as in "
        "control=65536.",
        metavar="[ROLE=]MODULUS,...",
    )
    mask: Literal["clipped"] | None = option(
        "Leave out the rows that samples reach which the drive's limit or a recorder cut off.",
        type=click.Choice(["clipped"]),
    )
    tail: Literal["drop"] | None = option(
        "Leave out what is no row at the end of a text: a line or number cut off, a footer.",
        type=click.Choice(["drop"]),
    )
    max_memory: float | None = option(
        "Memory that reading a log may take.  [default: half of the machine's]",
        read=_bytes,
        type=float,
        metavar="GB",
    )

    def __post_init__(self) -> None:
        if self.windows and self.taken is not self.windows:
            raise click.UsageError(
                "--from and --to are one window, and --window is another; give each by --window "
                "FROM..TO."
            )

    @property
    def given(self) -> list[str]:
        """Names of the options that were given."""
        values = self.arguments()
        return [option for name, option in self.names().items() if values[name] not in _NOTHING]

    @property
    def taken(self) -> tuple[Window, ...]:
        """The parts of the log that are wanted, all of it if there is none."""
        ends = (self.start, self.stop)
        return self.windows if ends == (None, None) else (ends,)

    def record(
        self, file: str, axis: "stages.GeneratedAxis", windows: "tuple[Window, ...] | None" = None
    ) -> "stages.Record":
        """Read a log as the record of an axis, within other windows where they are given."""
        given = self.settings()
        return stages.read_record(
            file, axis, **given if windows is None else {**given, "windows": windows}
        )

    def settings(self) -> dict[str, Any]:
        """Arguments of `read_record`."""
        repairs = stages.Repairs(
            resample=self.resample,
            gaps=self.gaps,
            wrap=self.wrap,
            mask=self.mask,
            tail=self.tail,
            shift=self.shift,
            between=cast(Any, self.between),
        )
        return {
            "columns": self.columns,
            "injected_at": self.injected_at,
            "sample_period": self.sample_period,
            "windows": self.taken,
            "repairs": repairs,
            "max_memory": self.max_memory,
        }
