"""``axisid new``, ``show``, ``generate`` and ``export``: declarations of axes, and code."""

import os
import sys
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    Target,
    check_folder,
    check_idle,
    check_replaced,
    check_targets,
    complete_axis,
    complete_file,
    force_option,
    is_earlier,
    print_document,
    progress_line,
    stages,
    write_output,
)
from axisid.estimation.choices import method_names
from axisid.export_targets import TARGETS
from axisid.support.errors import ModelError, UsageError, refuse

_NAMES = tuple(target.name for target in TARGETS)
_LANGUAGES = [target.language for target in TARGETS if target.language]


@click.command(
    cls=Command,
    short_help="Write a first declaration, or a run.toml of a log.",
    epilog="Examples: axisid new my_axis && axisid identify my_axis.toml, or "
    "axisid new --record log.csv && axisid identify my_axis.toml run.toml",
)
@click.argument("name", required=False)
@click.option(
    "--newton/--lagrange", default=True, help="Declare forces, or energies.  [default: newton]"
)
@click.option(
    "--toml/--python", default=True, help="Write a TOML file, or a Python file.  [default: toml]"
)
@click.option(
    "--record",
    metavar="LOG",
    shell_complete=complete_file,
    help="Write a run.toml (or NAME.toml) next to this log instead of a declaration. It describes "
    "the log, with the columns and units found in it. Every command takes it instead of the log.",
)
def new(name: str | None, newton: bool, toml: bool, record: str | None) -> None:
    """Write a first declaration with comments, NAME.toml or NAME.py in this folder.

    The declaration is complete: a linear stage (a pendulum with --lagrange) with its control law,
    and an experiment whose twin can be identified at once.
    """
    if record is not None:
        for option in ("--newton", "--toml"):
            check_idle(
                option, "or its opposite describes a declaration, but --record writes a run.toml"
            )
        log, name = Path(record), name or "run"
        if Path(name).name != name:
            raise UsageError(
                f"{name!r} is not a file name. The file is written next to {log}. Give a name "
                "without a folder."
            )
        file = log.parent / f"{name.removesuffix('.toml')}.toml"
        _check_free(file)
        write_output(str(file), stages.started_run(log))
        click.echo(f"wrote {file}. Remove the # from the lines that you need, then run:")
        click.echo(f"  axisid identify AXIS {file}")
        return
    if name is None:
        raise click.UsageError(
            "neither an axis nor a log is named. Give the NAME of an axis, or a log with --record "
            "LOG."
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
    click.echo(f"wrote {file}. Edit it, then run (identify uses its twin; add your log after it):")
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
    help="Plain text for the terminal, a LaTeX document, or Markdown with formulas.",
)
def show(axis: str, form: str) -> None:
    """Print the declaration of AXIS and the models derived from it.

    The page has the equation of motion, the inverse and the direct model with their regressors, the
    map between their parameters, the identifiable parameters, and the drive, control law and
    columns.
    """
    with progress_line(f"deriving {axis}"):
        model = stages.derive(stages.load_axis(axis))
        page = stages.axis_document(model) if form == "text" else stages.axis_page(model, form)
    if isinstance(page, str):
        click.echo(page, nl=False)
    else:
        print_document(page)


def scaffold(name: str, *, newton: bool, toml: bool) -> str:
    """Return the text of a first declaration: a file of `scaffolds` with its NAME replaced."""
    file = f"{'newton' if newton else 'lagrange'}.{'toml' if toml else 'py.txt'}"
    template = resources.files("axisid.commands") / "scaffolds" / file
    return template.read_text(encoding="utf-8").replace("NAME", name)


def _check_free(file: Path) -> None:
    if os.path.lexists(file):
        raise UsageError(f"{file} exists already. Choose another name, or move the file.")


@click.command(
    cls=Command,
    short_help="Write the generated code of axes.",
    epilog="Example: axisid generate --check",
)
@click.argument("axes", nargs=-1, shell_complete=complete_axis)
@click.option(
    "--check",
    is_flag=True,
    help="Write nothing. Exit with 1 if a file is stale or belongs to no axis.",
)
@click.option(
    "--output",
    type=click.Path(file_okay=False),
    default="generated",
    show_default=True,
    help="Folder for the generated code.",
)
@force_option
def generate(axes: tuple[str, ...], check: bool, output: str, force: bool) -> None:
    """Write the generated code of AXES, by default of the whole library.

    Each axis gets a folder with its CasADi functions, its equations and a manifest. AXES are axes
    of the library, or TOML or Python files that declare an axis.
    """
    declared = [stages.load_axis(name) for name in axes or stages.LIBRARY]
    for name, axis in zip(axes, declared, strict=False):
        if axis.name in stages.LIBRARY and name not in stages.LIBRARY:
            raise UsageError(
                f"{name} declares an axis named {axis.name!r}, but the folder of that name belongs "
                "to the library. Rename the axis."
            )
    with progress_line("generating") as line:
        files = stages.expected_files(declared, line)
    if not check:
        check_folder(output, "--output", {}, force=force)
        # A folder with a manifest was generated, whatever has become of its other files.
        places = [Path(output, path) for path in files]
        manifests = [p for p in places if p.name == stages.MANIFEST and p.is_file()]
        own = {place.parent for place in manifests if is_earlier(place, "generate")}
        for earlier in (True, False):
            chosen = {p: "generate" for p in places if (p.parent in own) == earlier}
            check_replaced(chosen, "--output", axes, force=force or earlier)
        written = stages.write_files(Path(output), files)
        for path in written:
            click.echo(f"wrote {Path(output, path)}")
        click.echo(f"{len(written)} files written, {len(files) - len(written)} up to date.")
        return
    findings = stages.check_files(Path(output), files, others=stages.LIBRARY if axes else None)
    for finding in findings:
        click.echo(f"{finding.state}: {Path(output, finding.path)}")
        if finding.state == "stale":
            click.echo(finding.diff)
    if findings:
        place = [] if output == "generated" else [f"--output {output}"]
        orphans = any(finding.state == "orphan" for finding in findings)
        click.echo(
            f"not as generated: {len(findings)} of {len(files)} files. Run: "
            + " ".join(["axisid generate", *axes, *place])
            + ". Remove the orphans, or name their axes." * orphans,
            err=True,
        )
        sys.exit(1)
    click.echo(f"{len(files)} files are up to date.")


@click.command(
    cls=Command,
    epilog="Example: axisid identify emps2015 --json result.json && "
    "axisid export result.json --axis emps2015 --to c -o emps2015.c",
)
@click.argument("result", shell_complete=complete_file)
@click.option(
    "--axis",
    required=True,
    help="The identified axis: its name in the library, or its file.",
    shell_complete=complete_axis,
)
@click.option(
    "--to",
    type=click.Choice(_NAMES),
    required=True,
    help=f"Feed-forward functions in {', '.join(_LANGUAGES[:-1])} or {_LANGUAGES[-1]}, "
    "or the parameters in another format.",
)
@click.option(
    "--method",
    type=click.Choice(method_names()),
    help="Method whose estimate is exported.  [default: the method that the verdict judges]",
)
@click.option(
    "--record",
    "number",
    type=click.IntRange(min=1),
    metavar="N",
    help="Export the --local parameters and --known values of the Nth of several records.",
)
@click.option(
    "--dead-zone",
    type=float,
    default=0.0,
    metavar="SPEED",
    help="The direction of friction is 0 up to this speed, m/s or rad/s.  [default: 0]",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="Write to this file instead of standard output.",
    shell_complete=complete_file,
)
@force_option
def export(
    result: str,
    axis: str,
    to: str,
    method: str | None,
    number: int | None,
    dead_zone: float,
    output: str | None,
    force: bool,
) -> None:
    """Export an identified axis as code or as a table of parameters.

    RESULT is a file that `axisid identify --json` wrote. The functions NAME_feedforward and
    NAME_control compute force and control from position, velocity and acceleration of the
    reference. They need no libraries beyond the language itself. JSON, CSV and LaTeX contain all
    methods unless --method names one.
    """
    check_targets([Target("--output", output, "export")], (result, axis), force=force)

    write_output(
        output,
        stages.export(result, to, axis=axis, method=method, dead_zone=dead_zone, record=number),
    )
