"""``axisid new`` and ``axisid show``: start a declaration, and print what one declares."""

import os
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    ProgressLine,
    check_idle,
    complete_axis,
    complete_file,
    print_document,
    stages,
    write_output,
)
from axisid.support.errors import ModelError, UsageError, refuse


@click.command(
    cls=Command,
    short_help="Start a declaration, or a run.toml of a log.",
    epilog="Examples: axisid new my_axis && axisid identify my_axis.toml, or "
    "axisid new --record log.csv && axisid identify my_axis.toml run.toml",
)
@click.argument("name", required=False)
@click.option("--newton/--lagrange", default=True, help="By forces or by energies.  [newton]")
@click.option("--toml/--python", default=True, help="As data, or as a program.  [toml]")
@click.option(
    "--record",
    metavar="LOG",
    shell_complete=complete_file,
    help="In place of a declaration start a run.toml (or NAME.toml) beside a log: what is said of "
    "it, with what was found in it. It stands in the place of the log in every command.",
)
def new(name: str | None, newton: bool, toml: bool, record: str | None) -> None:
    """Start a declaration, NAME.toml or NAME.py in this folder, with comments.

    It is complete: a linear stage (a pendulum with --lagrange) with its control law, and an
    experiment whose twin can be identified at once.
    """
    if record is not None:
        for option in ("--newton", "--toml"):
            check_idle(
                option, "or its opposite is of a declaration, and --record starts a run.toml"
            )
        log, name = Path(record), name or "run"
        if Path(name).name != name:
            raise UsageError(
                f"{name!r} is no name of a file beside {log}; give one without a folder."
            )
        file = log.parent / f"{name.removesuffix('.toml')}.toml"
        _check_free(file)
        write_output(str(file), stages.started_run(log))
        click.echo(f"wrote {file}; take the # away from what is wanted in it, then:")
        click.echo(f"  axisid identify AXIS {file}")
        return
    if name is None:
        raise click.UsageError("name the axis, or a log by --record LOG.")
    file = Path(f"{name}.toml" if toml else f"{name}.py")
    try:
        stages.check_name(name, "the axis")
    except ModelError as error:
        raise UsageError(str(error)) from error
    _check_free(file)
    refuse(
        UsageError,
        (name in stages.LIBRARY, f"{name!r} is an axis of the library; choose another name"),
        (
            not toml and find_spec(name),
            f"{name}.py would hide the Python module {name}; choose another name",
        ),
    )
    write_output(str(file), scaffold(name, newton=newton, toml=toml))
    click.echo(f"wrote {file}; edit it, then (the last line is of its twin; add your log to it):")
    click.echo(f"  axisid show {file}")
    click.echo(f"  axisid identify {file}")


@click.command(cls=Command, epilog="Example: axisid show emps --format latex > emps.tex")
@click.argument("axis", shell_complete=complete_axis)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "latex", "markdown"]),
    default="text",
    show_default=True,
    help="A page for the terminal, a LaTeX document, or Markdown with formulas.",
)
def show(axis: str, form: str) -> None:
    """Print what AXIS declares and what follows from it.

    The equation of motion, the inverse and the direct model with their regressors, the map between
    their parameters, what is identifiable, and the drive, control law and columns.
    """
    with ProgressLine(f"deriving {axis}"):
        model = stages.derive(stages.load_axis(axis))
        page = stages.axis_document(model) if form == "text" else stages.axis_page(model, form)
    if isinstance(page, str):
        click.echo(page, nl=False)
    else:
        print_document(page)


def scaffold(name: str, *, newton: bool, toml: bool) -> str:
    """The text of a declaration: one of `scaffolds`, in which the axis is called NAME."""
    file = f"{'newton' if newton else 'lagrange'}.{'toml' if toml else 'py.txt'}"
    template = resources.files("axisid.commands") / "scaffolds" / file
    return template.read_text(encoding="utf-8").replace("NAME", name)


def _check_free(file: Path) -> None:
    if os.path.lexists(file):
        raise UsageError(f"{file} is there already; choose another name or move it.")
