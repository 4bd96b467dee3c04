"""``axisid new``: write a first declaration of an axis, or a run.toml of a log."""

import os
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

import click

from axisid.commands.options import Command, check_idle, complete_file, stages, write_output
from axisid.support.checks import refuse
from axisid.support.errors import ModelError, UsageError


@click.command(
    cls=Command,
    short_help="Write a first declaration, or a run.toml of a log.",
    epilog="Examples: axisid new my_axis && axisid identify my_axis.toml, or "
    "axisid new --record log.csv && axisid identify my_axis.toml run.toml",
)
@click.argument("name", required=False)
@click.option(
    "--newton/--lagrange",
    default=True,
    help="Declare forces (Newton), or energies (Lagrange).  [default: newton]",
)
@click.option(
    "--toml/--python", default=True, help="Write a TOML file, or a Python file.  [default: toml]"
)
@click.option(
    "--record",
    metavar="LOG",
    shell_complete=complete_file,
    help="Do not write a declaration. Write a run.toml (or NAME.toml) into the folder of this log. "
    "The run.toml describes the log with the columns and units found in the log. In other "
    "commands, name the run.toml instead of the log.",
)
def new(name: str | None, newton: bool, toml: bool, record: str | None) -> None:
    """Write a first declaration of an axis with comments: NAME.toml or NAME.py in this folder.

    The declaration is complete: a linear stage (with --lagrange a pendulum) with a control law. It
    also declares an experiment, so that `axisid identify NAME.toml` works at once, on a simulated
    record.
    """
    if record is not None:
        for option, opposite in (("--newton", "--lagrange"), ("--toml", "--python")):
            reason = f"(or {opposite}) applies to a declaration, but --record writes a run.toml"
            check_idle(option, reason)
        log, name = Path(record), name or "run"
        if Path(name).name != name:
            raise UsageError(
                f"{name!r} is not a file name. The file is written into the folder of {log}. Give "
                "a name without a folder."
            )
        file = log.parent / f"{name.removesuffix('.toml')}.toml"
        _check_free(file)
        write_output(str(file), stages.started_run(log))
        click.echo(f"wrote {file}. Remove the # from the lines that you need, then run:")
        click.echo(f"  axisid identify AXIS {file}")
        return
    if name is None:
        raise click.UsageError(
            "neither an axis nor a log is given. Give the NAME of a new axis, or a log with "
            "--record LOG."
        )
    file = Path(f"{name}.toml" if toml else f"{name}.py")
    try:
        stages.check_name(name, "the axis")
    except ModelError as error:
        raise UsageError(str(error)) from error
    _check_free(file)
    refuse(
        UsageError,
        (name in stages.LIBRARY, f"{name!r} is an axis of the library. Choose another name"),
        (
            not toml and find_spec(name),
            f"{name}.py would hide the Python module {name}. Choose another name",
        ),
    )
    write_output(str(file), scaffold(name, newton=newton, toml=toml))
    click.echo(
        f"wrote {file}. Edit the file, then run the commands below. identify uses a simulated "
        "record, unless you add a log at the end."
    )
    click.echo(f"  axisid show {file}")
    click.echo(f"  axisid identify {file}")


def scaffold(name: str, *, newton: bool, toml: bool) -> str:
    """Return the text of a first declaration: a file of `scaffolds`, with `name` for NAME."""
    file = f"{'newton' if newton else 'lagrange'}.{'toml' if toml else 'py.txt'}"
    template = resources.files("axisid.commands") / "scaffolds" / file
    return template.read_text(encoding="utf-8").replace("NAME", name)


def _check_free(file: Path) -> None:
    """Refuse a file that exists already."""
    if os.path.lexists(file):
        raise UsageError(f"{file} exists already. Choose another name, or move the file.")
