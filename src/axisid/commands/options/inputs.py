"""What commands make of their arguments: the axis, its record, and the files that they name."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from axisid.presentation.console import ProgressLine

from .record_options import Reading, is_log

if TYPE_CHECKING:
    from axisid.codegen.artefacts import GeneratedAxis
    from axisid.estimation.records import Record

leave_out_option = click.option(
    "--leave-out",
    "left_out",
    multiple=True,
    metavar="NAME",
    help="A parameter that is not identified, as the record does not show it: held at what --fix "
    "says, else at 0 (at its nominal value if it enters nonlinearly); again for each.",
)


def axis_and_record(
    axis: str,
    record: str | None,
    reading: Reading,
    second: str | None = None,
    *,
    fixed: tuple[str, ...] = (),
    left_out: tuple[str, ...] = (),
    no_native: bool,
) -> "tuple[GeneratedAxis, Record]":
    """The axis that was named, and its record or its twin's."""
    with ProgressLine(f"reading {record or f'the twin of {axis}'}"):
        from axisid.codegen.artefacts import build
        from axisid.estimation.simulation import twin_record
        from axisid.modeling.declaration import fix, leave_out, read_fixed
        from axisid.modeling.text import load_axis
        from axisid.support.errors import UsageError

        if is_log(axis):
            raise UsageError(f"{axis} is a log by its ending; the axis comes first: AXIS RECORD.")
        whole = fix(load_axis(axis), **read_fixed(fixed))
        generated = build(leave_out(whole, *left_out), native=not no_native)
        if record is not None:
            return generated, reading.record(record, generated)
        if reading.given and second is None:
            verb = "describes" if len(reading.given) == 1 else "describe"
            said = f"{' and '.join(reading.given)} {verb} a record"
            raise UsageError(f"{said}; name its file.")
        # The twin has every term, as an axis does whatever is identified of it.
        own = build(whole, native=not no_native) if left_out else generated
        return generated, twin_record(own)


def file_of(argument: str) -> Path:
    """The file that an argument names, without the variable of an axis file."""
    head, found, _ = argument.partition(".py:")
    return Path(f"{head}.py" if found else argument)
