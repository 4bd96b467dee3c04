"""What commands make of their arguments: the axis, its records, and what several of these share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from axisid.presentation.console import ProgressLine
from axisid.support.errors import AxisidError, UsageError

from . import stages
from .groups import Options, option
from .record_options import Reading, is_log

leave_out_option = click.option(
    "--leave-out",
    "left_out",
    multiple=True,
    metavar="NAME",
    help="A parameter that is not identified, as the record does not show it: held at what --fix "
    "says, else at 0 (at its nominal value if it enters nonlinearly); again for each.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """The axis that was named, and its records or its twin's.

    Attributes
    ----------
    axis : GeneratedAxis
    records : tuple of Record
    used : tuple of int
        Which of the logs they are.
    set_aside : mapping of str to str
        Logs that could not be read and were to be skipped, with the reason.
    """

    axis: "stages.GeneratedAxis"
    records: "tuple[stages.Record, ...]"
    used: tuple[int, ...]
    set_aside: "Mapping[str, str]"

    def say_set_aside(self) -> None:
        """Tell of each log that could not be read."""
        for name, why in self.set_aside.items():
            click.echo(f"axisid: without {name}: {why}", err=True)


def axis_and_records(
    axis: str,
    logs: Sequence[str],
    reading: Reading,
    further: Sequence[str] = (),
    *,
    fixed: tuple[str, ...] = (),
    left_out: tuple[str, ...] = (),
    skip_bad: bool = False,
) -> Inputs:
    """The axis that was named, and its records or its twin's.

    Parameters
    ----------
    axis : str
    logs : sequence of str
    reading : Reading
    further : sequence of str
        Other logs that `reading` is of.
    fixed, left_out : tuple of str
    skip_bad : bool
    """
    named = f"the twin of {axis}" if not logs else " and ".join(logs)
    with ProgressLine(f"reading {named}"):
        if is_log(axis):
            raise UsageError(f"{axis} is a log; the axis comes first: AXIS RECORD.")
        whole = stages.fix(stages.load_axis(axis), **stages.read_fixed(fixed))
        generated = stages.build(stages.leave_out(whole, *left_out))
        if logs:
            return _read(generated, logs, reading, skip_bad=skip_bad)
        if reading.given and not further:
            verb = "describes" if len(reading.given) == 1 else "describe"
            said = f"{' and '.join(reading.given)} {verb} a record"
            raise UsageError(f"{said}; name its file.")
        # The twin has every term, as an axis does whatever is identified of it.
        own = stages.build(whole) if left_out else generated
        return Inputs(axis=generated, records=(stages.twin_record(own),), used=(0,), set_aside={})


def _read(
    axis: "stages.GeneratedAxis",
    logs: Sequence[str],
    reading: Reading,
    *,
    skip_bad: bool,
) -> Inputs:
    """Read every log; what cannot be read is named with the others that cannot."""
    found: dict[int, stages.Record] = {}
    bad: dict[str, str] = {}
    for i, log in enumerate(logs):
        try:
            found[i] = reading.record(log, axis)
        except AxisidError as error:
            if len(logs) == 1:
                raise
            bad[log if log not in bad else f"{log} ({i + 1})"] = str(error)
    stages.check_bad(bad, len(logs), skip_bad=skip_bad)
    return Inputs(axis=axis, records=tuple(found.values()), used=tuple(found), set_aside=bad)


def file_of(argument: str) -> Path:
    """The file that an argument names, without the variable of an axis file."""
    head, found, _ = argument.partition(".py:")
    return Path(f"{head}.py" if found else argument)


def names_in(text: str | None) -> tuple[str, ...]:
    """The names of a list as options take it, ``M,Fv``."""
    return tuple(name.strip() for name in (text or "").split(",") if name.strip())


def _known(texts: tuple[str, ...]) -> dict[str, tuple[tuple[float, float], ...]]:
    return stages.read_known(texts)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sharing(Options):
    """What several records share and what is each one's own, as the command line says it."""

    local: tuple[str, ...] = option(
        "Parameters that each of several records, two or more, has for itself.",
        read=names_in,
        metavar="NAME[,NAME]",
    )
    known: Mapping[str, tuple[tuple[float, float], ...]] = option(
        "What is known of each record, SI: a parameter (a payload, an angle, a temperature) "
        "or a gain of the control law, a value for each in their order; again for each name.",
        read=_known,
        multiple=True,
        metavar="NAME=V1,V2+-SD,...",
    )
    skip_bad: bool = option(
        "Go on without those of several records that cannot be used; they are counted and named, "
        "and what is not identified without them is told. With one record it changes nothing.",
        False,
    )

    def check_validates(self, like: int | None) -> None:
        """Refuse to hold estimates against a record of which nothing says what is its own."""
        if (self.local or self.known) and like is None:
            raise click.UsageError(
                "--validate holds parameters against another record, of which nothing says what "
                "--local and --known say of each; name the record that it is like: "
                "--validate-like 1."
            )

    def of(self, inputs: Inputs, logs: int) -> dict[str, Any]:
        """Arguments of `identify` for the logs that are used.

        Raises
        ------
        UsageError
            There are not as many known values as logs, or something is each log's own of one.
        """
        stages.known_of(self.known, max(logs, 1))
        if not inputs.set_aside:
            return {"local": self.local, "known": self.known}
        local = self.local if len(inputs.used) > 1 else ()
        return {"local": local, "known": stages.known_without(inputs.used, self.known)}
