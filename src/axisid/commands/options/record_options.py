"""Options of every command that reads a record, collected into one object."""

import csv
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

if TYPE_CHECKING:
    from axisid.codegen.artefacts import GeneratedAxis
    from axisid.estimation.records import LogBlocks, Record

_GIGABYTE = 1e9


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
    max_memory: float | None

    @property
    def given(self) -> list[str]:
        """Names of the options that were given."""
        values = {name: getattr(self, name) for name in self.__slots__}
        return [f"--{name.replace('_', '-')}" for name, value in values.items() if value]

    def record(self, file: str, axis: "GeneratedAxis") -> "Record":
        """Read a log as the record of an axis."""
        from axisid.estimation.records import Repairs, read_record

        repairs = Repairs(
            resample=self.resample,
            gaps=self.gaps,
            wrap=self.wrap,
            mask=self.mask,
            tail=self.tail,
        )
        return read_record(
            file,
            axis,
            columns=self.columns,
            injected_at=self.injected_at,
            sample_period=self.sample_period,
            repairs=repairs,
            max_memory=self.max_memory,
        )

    def blocks(self, file: str, axis: "GeneratedAxis") -> "LogBlocks":
        """The same in blocks, for a log larger than memory; nothing can be repaired then."""
        from axisid.estimation.records import LogBlocks

        repairs = {*self.given} - {"--columns", "--injected-at", "--sample-period"}
        if repairs:
            raise click.UsageError(
                f"{' and '.join(sorted(repairs))} cannot be done in blocks; leave --stream out."
            )
        return LogBlocks(
            file=Path(file), axis=axis, columns=self.columns, injected_at=self.injected_at
        )


_OPTIONS = (
    click.option(
        "--columns",
        metavar="ROLE=NAME[:UNIT],...",
        help="Columns; roles: time, position, reference, control, force, injected (a test signal); "
        "units such as mm, deg, ms, mA.",
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
        "--resample", metavar="HZ|auto", help="Uneven or different times onto an even grid."
    ),
    click.option(
        "--gaps",
        type=click.Choice(["split"]),
        help="Cut the log where samples are missing or its clock goes back; each piece is "
        "filtered by itself.",
    ),
    click.option(
        "--wrap", metavar="MODULUS", help="Undo jumps of the position by it, as in 360:deg."
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

#: Names of all of them on the command line.
RECORD_OPTIONS = tuple(f"--{name.replace('_', '-')}" for name in Reading.__dataclass_fields__)


def record_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options; the command takes them as one `reading`."""

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
        max_memory: float | None,
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
            max_memory=_bytes(max_memory),
        )
        command(reading=reading, **others)

    for option in reversed(_OPTIONS):
        collected = option(collected)
    return collected


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


def _roles(columns: str | None) -> dict[str, str]:
    roles: dict[str, str] = {}
    for pair in next(csv.reader([columns], skipinitialspace=True)) if columns else ():
        role, equals, name = (part.strip() for part in pair.partition("="))
        if not equals or not role or not name or role in roles:
            raise click.BadParameter(
                f"{pair!r} is not ROLE=NAME or ROLE=NAME:UNIT with each role once, as in "
                "time=t,position=qm:mm; quote a pair whose name has a comma: "
                'time=t,"control=I, raw"',
                param_hint="--columns",
            )
        roles[role] = name
    return roles
