"""What commands make of their arguments: the axis, its records, and what several of these share.

Few options are of a log; all else of it is said in its run.toml.
"""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from axisid.estimation.choices import LOG_KEYS
from axisid.support.errors import AxisidError, UsageError

from . import stages
from .groups import Options, given_options, option
from .terminal import ProgressLine

leave_out_option = click.option(
    "--leave-out",
    "left_out",
    multiple=True,
    metavar="NAME",
    help="A parameter that is not identified, as the record does not show it: held at what --fix "
    "says, else at 0 (at its nominal value if it enters nonlinearly); again for each.",
)


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading(Options):
    """What the command line says of a log."""

    columns: dict[str, str] = option(key="columns", read=_roles)
    windows: tuple[str, ...] = option(key="windows", multiple=True)
    resample: float | str | None = option(key="resample", read=_rate)
    gaps: str | None = option(key="gaps")

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
    shared : mapping
        Arguments of `identify`: what the records that are used have for themselves.
    """

    axis: "stages.GeneratedAxis"
    records: "tuple[stages.Record, ...]"
    used: tuple[int, ...]
    set_aside: Mapping[str, str]
    shared: Mapping[str, Any]

    def say_set_aside(self) -> None:
        """Tell of each log that could not be read."""
        for name, why in self.set_aside.items():
            click.echo(f"axisid: without {name}: {why}", err=True)


def names_in(text: str | None) -> tuple[str, ...]:
    """The names of a list as options take it, ``M,Fv``, none of them twice."""
    names = tuple(map(str.strip, text.split(","))) if text else ()
    for name in names:
        if not name or names.count(name) > 1:
            raise click.BadParameter(
                f"{text!r} has {f'{name!r} twice' if name else 'an empty name'}; name each once, "
                "as in M,Fv."
            )
    return names


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
        read=lambda texts: stages.read_known(texts),  # noqa: PLW0108 - imported when it is read
        multiple=True,
        metavar="NAME=V1,V2+-SD,...",
    )
    skip_bad: bool = option(
        "Go on without those of several records that cannot be used; they are counted and named. "
        "With one record it changes nothing.",
        False,
    )


def axis_and_records(
    axis: str,
    logs: Sequence[str],
    reading: Reading,
    sharing: Sharing,
    further: Sequence[str] = (),
    *,
    fixed: tuple[str, ...] = (),
    left_out: tuple[str, ...] = (),
) -> Inputs:
    """The axis that was named, and its records or its twin's.

    Parameters
    ----------
    axis : str
    logs : sequence of str
    reading : Reading
    sharing : Sharing
    further : sequence of str
        Other logs that `reading` is of.
    fixed, left_out : tuple of str

    Raises
    ------
    UsageError
        There are not as many known values as logs.
    AxisidError
        What cannot be read; of several logs it is named with the others that cannot.
    """
    with ProgressLine(f"reading {' and '.join(logs) or f'the twin of {axis}'}"):
        if is_log(axis):
            raise UsageError(f"{axis} is a log; the axis comes first: AXIS RECORD.")
        whole = stages.fix(stages.load_axis(axis), **stages.read_fixed(fixed))
        generated = stages.build(stages.leave_out(whole, *left_out))
        found: dict[int, stages.Record] = {}
        bad: dict[str, str] = {}
        for i, log in enumerate(logs):
            try:
                found[i] = reading.record(log, generated)
            except AxisidError as error:
                if len(logs) == 1:
                    raise
                bad[log if log not in bad else f"{log} ({i + 1})"] = str(error)
        stages.check_bad(bad, len(logs), skip_bad=sharing.skip_bad)
        if not logs:
            given = [name for name in reading.names().values() if name in given_options()]
            if given and not further:
                raise UsageError(
                    f"{' and '.join(given)} {'describes' if len(given) == 1 else 'describe'} a "
                    "record; name its file."
                )
            # The twin has every term, as an axis does whatever is identified of it.
            found[0] = stages.twin_record(stages.build(whole) if left_out else generated)
    stages.known_of(sharing.known, max(len(logs), 1))
    records, used = tuple(found.values()), tuple(found)
    shared: dict[str, Any] = {
        "local": () if bad and len(used) == 1 else sharing.local,
        "known": stages.known_without(used, sharing.known),
    }
    return Inputs(axis=generated, records=records, used=used, set_aside=bad, shared=shared)
