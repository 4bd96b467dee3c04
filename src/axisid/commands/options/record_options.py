"""Options of every command that reads a record, collected into one object."""

import csv
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast

import click

from .option_checks import with_options

if TYPE_CHECKING:
    from axisid.codegen.artefacts import GeneratedAxis
    from axisid.estimation.records import Record

#: First and last time, s; None for the log's own.
Window = tuple[float | None, float | None]

_GIGABYTE = 1e9
_SHIFTS = "N in samples or a time, as in control=1 or control=2ms"
_BETWEEN = "as in velocity=spline or velocity=linear"


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """How a log is to be read, as the command line says it."""

    sample_period: float | None
    columns: dict[str, str]
    injected_at: Literal["control", "reference"] | None
    resample: float | Literal["auto"] | None
    gaps: Literal["split"] | None
    wrap: str | None
    mask: Literal["clipped"] | None
    tail: Literal["drop"] | None
    shift: dict[str, str]
    between: dict[str, str]
    window: tuple[Window, ...]
    max_memory: float | None

    @property
    def given(self) -> list[str]:
        """Names of the options that were given."""
        values = {name: getattr(self, name) for name in self.__slots__}
        return [f"--{name.replace('_', '-')}" for name, value in values.items() if value]

    def record(
        self, file: str, axis: "GeneratedAxis", windows: "tuple[Window, ...] | None" = None
    ) -> "Record":
        """Read a log as the record of an axis, within other windows where they are given."""
        from axisid.estimation.records import read_record

        given = self.arguments()
        return read_record(
            file, axis, **given if windows is None else {**given, "windows": windows}
        )

    def arguments(self) -> dict[str, Any]:
        """Arguments of `read_record`."""
        from axisid.estimation.records import Repairs

        repairs = Repairs(
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
            "windows": self.window,
            "repairs": repairs,
            "max_memory": self.max_memory,
        }

    def with_columns(self, columns: str) -> "Reading":
        """The same with columns of one log in place of those of all."""
        return replace(self, columns=_roles(columns, "--columns-of"))


_ENDS = (
    click.option(
        "--from",
        "start",
        type=float,
        metavar="S",
        help="Take the log from this time on, s, as its own time counts.",
    ),
    click.option("--to", "stop", type=float, metavar="S", help="Take the log up to this time, s."),
)
_OPTIONS = (
    click.option(
        "--columns",
        metavar="ROLE=NAME[:UNIT],...",
        help="Columns by name or number (#3); roles: time, position, velocity and acceleration "
        "(measured), reference, control, force, injected (a test signal), signals that AXIS "
        "declares; units such as mm, deg, rpm, ms, mA, or a scaling: "
        "position=inc:counts*360deg/4096/50+0.2deg.",
    ),
    click.option(
        "--injected-at",
        type=click.Choice(["control", "reference"]),
        help="What the test signal in the column injected was added to; to the control before the "
        "drive's limit.",
    ),
    click.option(
        "--sample-period",
        type=float,
        metavar="S",
        help="In place of the time column's mean step; confirms that the log is not sampled as "
        "the control law runs, which is then simulated at its own period.",
    ),
    click.option(
        "--window",
        "windows",
        multiple=True,
        metavar="FROM..TO",
        help="Take only this part of the log, s; again for each, filtered and simulated by itself.",
    ),
    click.option(
        "--shift",
        "shifts",
        metavar="ROLE=N,...",
        help="Move a column N samples to later times, or by a time such as 2ms, where the log "
        "wrote it too early: control=1.",
    ),
    click.option(
        "--between",
        metavar="ROLE=HOW,...",
        help="What a measured velocity, acceleration or force is between its values, where they "
        "are written in every few samples alone: spline, linear or held.",
    ),
    click.option(
        "--resample", metavar="HZ|auto", help="Uneven or different times onto an even grid."
    ),
    click.option(
        "--gaps",
        type=click.Choice(["split"]),
        help="Cut the log where samples are missing or its clock goes back; each piece is "
        "filtered by itself.",
    ),
    click.option(
        "--wrap",
        metavar="[ROLE=]MODULUS,...",
        help="Undo jumps of the position by it, as in 360:deg; give others a lost sign back, as in "
        "control=65536.",
    ),
    click.option(
        "--mask",
        type=click.Choice(["clipped"]),
        help="Leave out the rows that samples reach which the drive's limit or a recorder cut off.",
    ),
    click.option(
        "--tail",
        type=click.Choice(["drop"]),
        help="Leave out what is no row at the end of a text: a line or number cut off, a footer.",
    ),
    click.option(
        "--max-memory",
        type=float,
        metavar="GB",
        help="Memory that reading a log may take.  [default: half of the machine's]",
    ),
)


def record_options(command: Callable[..., None], *, ends: bool = True) -> Callable[..., None]:
    """Add the options; the command takes them as one `reading`.

    Parameters
    ----------
    command : callable
    ends : bool
        Whether ``--from`` and ``--to`` are of the log, and not something of the command's own.
    """

    @functools.wraps(command)
    def collected(
        *,
        columns: str | None,
        injected_at: Literal["control", "reference"] | None,
        sample_period: float | None,
        resample: str | None,
        gaps: Literal["split"] | None,
        wrap: str | None,
        mask: Literal["clipped"] | None,
        tail: Literal["drop"] | None,
        windows: tuple[str, ...],
        shifts: str | None,
        between: str | None,
        max_memory: float | None,
        start: float | None = None,
        stop: float | None = None,
        **others: Any,
    ) -> None:
        reading = Reading(
            sample_period=_period(sample_period),
            columns=_roles(columns),
            injected_at=injected_at,
            resample=_rate(resample),
            gaps=gaps,
            wrap=wrap,
            mask=mask,
            tail=tail,
            shift=_amounts(shifts, "--shift", "N", _SHIFTS),
            between=_amounts(between, "--between", "HOW", _BETWEEN),
            window=_windows(start, stop, windows),
            max_memory=_bytes(max_memory),
        )
        command(reading=reading, **others)

    return with_options(collected, (*(_ENDS if ends else ()), *_OPTIONS))


def is_log(file: str) -> bool:
    """Whether an argument is a log, by its ending."""
    from axisid.estimation.logs import log_endings

    return Path(file).suffix.lower() in log_endings()


def _period(sample_period: float | None) -> float | None:
    if sample_period is not None and not (math.isfinite(sample_period) and sample_period > 0):
        raise click.BadParameter(
            f"{sample_period!r} is no period; give a positive number of seconds",
            param_hint="--sample-period",
        )
    return sample_period


def _bytes(gigabytes: float | None) -> float | None:
    if gigabytes is None:
        return None
    if not gigabytes > 0:
        raise click.BadParameter(
            f"{gigabytes!r} is no amount of memory; give a positive number of GB",
            param_hint="--max-memory",
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
        raise click.BadParameter(
            f"{text!r} is no rate; give hertz, or auto", param_hint="--resample"
        )
    return rate


def _windows(
    start: float | None, stop: float | None, windows: tuple[str, ...]
) -> tuple[Window, ...]:
    if start is None and stop is None:
        return tuple(window_of(text, "--window") for text in windows)
    if windows:
        raise click.UsageError(
            "--from and --to are one window, and --window is another; give each by --window "
            "FROM..TO."
        )
    return ((start, stop),)


def window_of(text: str, option: str) -> Window:
    """The times of ``FROM..TO``, of which one may be left out."""
    first, dots, last = (part.strip() for part in text.partition(".."))
    try:
        start, stop = (float(part) if part else None for part in (first, last))
    except ValueError:
        dots = ""
    if not dots or (start is None and stop is None):
        raise click.BadParameter(
            f"{text!r} is no window; give FROM..TO in seconds, such as 2..5, 2.. or ..5",
            param_hint=option,
        )
    return start, stop


def _amounts(text: str | None, option: str, what: str, such: str) -> dict[str, str]:
    """What is said of columns by role."""
    found: dict[str, str] = {}
    for pair in text.split(",") if text else ():
        role, equals, amount = (part.strip() for part in pair.partition("="))
        if not equals or not role or not amount or role in found:
            raise click.BadParameter(
                f"{pair!r} is not ROLE={what} with each role once, {such}", param_hint=option
            )
        found[role] = amount
    return found


def _roles(columns: str | None, option: str = "--columns") -> dict[str, str]:
    roles: dict[str, str] = {}
    for pair in next(csv.reader([columns], skipinitialspace=True)) if columns else ():
        role, equals, name = (part.strip() for part in pair.partition("="))
        if not equals or not role or not name or role in roles:
            raise click.BadParameter(
                f"{pair!r} is not ROLE=NAME or ROLE=NAME:UNIT with each role once, as in "
                "time=t,position=qm:mm; quote a pair whose name has a comma: "
                'time=t,"control=I, raw"',
                param_hint=option,
            )
        roles[role] = name
    return roles
