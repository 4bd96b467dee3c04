"""What commands make of their arguments: the axis, its record, and the files that they name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click

from axisid.presentation.console import ProgressLine
from axisid.support.errors import AxisidError, UsageError
from axisid.support.remedy import Note, as_options

from . import stages
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
    set_aside : mapping of str to Note
        Logs that could not be read and were to be skipped, with the reason.
    """

    axis: "stages.GeneratedAxis"
    records: "tuple[stages.Record, ...]"
    used: tuple[int, ...]
    set_aside: "Mapping[str, Note]"

    def say_set_aside(self) -> None:
        """Tell of each log that could not be read."""
        for name, why in self.set_aside.items():
            click.echo(f"axisid: without {name}: {why.worded(as_options)}", err=True)


def axis_and_records(
    axis: str,
    logs: Sequence[str],
    reading: Reading,
    further: Sequence[str] = (),
    *,
    fixed: tuple[str, ...] = (),
    left_out: tuple[str, ...] = (),
    no_native: bool,
    skip_bad: bool = False,
    own_columns: Mapping[int, dict[str, str]] | None = None,
    drive_time: str | None = None,
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
    no_native, skip_bad : bool
    own_columns : mapping of int to dict, optional
        Columns of single logs, by their place.
    drive_time : str, optional
        The drive's time that is estimated, ``lag`` or ``delay``.
    """
    named = f"the twin of {axis}" if not logs else " and ".join(logs)
    with ProgressLine(f"reading {named}"):
        if is_log(axis):
            raise UsageError(f"{axis} is a log by its ending; the axis comes first: AXIS RECORD.")
        whole = stages.fix(stages.load_axis(axis), **stages.read_fixed(fixed))
        if drive_time is not None:
            whole = replace(whole, drive=whole.drive.estimating(drive_time))
        generated = stages.build(stages.leave_out(whole, *left_out), native=not no_native)
        if logs:
            return _read(generated, logs, reading, own_columns or {}, skip_bad=skip_bad)
        if reading.given and not further:
            verb = "describes" if len(reading.given) == 1 else "describe"
            said = f"{' and '.join(reading.given)} {verb} a record"
            raise UsageError(f"{said}; name its file.")
        # The twin has every term, as an axis does whatever is identified of it.
        own = stages.build(whole, native=not no_native) if left_out else generated
        return Inputs(axis=generated, records=(stages.twin_record(own),), used=(0,), set_aside={})


def _read(
    axis: "stages.GeneratedAxis",
    logs: Sequence[str],
    reading: Reading,
    own_columns: Mapping[int, dict[str, str]],
    *,
    skip_bad: bool,
) -> Inputs:
    """Read every log; what cannot be read is named with the others that cannot."""
    found: dict[int, stages.Record] = {}
    bad: dict[str, Note] = {}
    for i, log in enumerate(logs):
        own = replace(reading, columns=own_columns.get(i, reading.columns))
        try:
            found[i] = own.record(log, axis)
        except AxisidError as error:
            if len(logs) == 1:
                raise
            bad[log if log not in bad else f"{log} ({i + 1})"] = error.note
    stages.check_bad(bad, len(logs), skip_bad=skip_bad)
    return Inputs(axis=axis, records=tuple(found.values()), used=tuple(found), set_aside=bad)


def file_of(argument: str) -> Path:
    """The file that an argument names, without the variable of an axis file."""
    head, found, _ = argument.partition(".py:")
    return Path(f"{head}.py" if found else argument)
