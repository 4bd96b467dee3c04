"""``axisid export`` and ``axisid generate``: an identified axis, and an axis's code, as text."""

import sys
from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    ProgressLine,
    Target,
    check_folder,
    check_replaced,
    check_targets,
    complete_axis,
    complete_file,
    force_option,
    is_earlier,
    stages,
    write_output,
)
from axisid.estimation.choices import method_names
from axisid.export_targets import TARGETS
from axisid.support.errors import UsageError

_NAMES = tuple(target.name for target in TARGETS)
_LANGUAGES = [target.language for target in TARGETS if target.language]


@click.command(
    cls=Command,
    epilog="Example: axisid identify emps2015 --json result.json && "
    "axisid export result.json --axis emps2015 --to c -o emps2015.c",
)
@click.argument("result", shell_complete=complete_file)
@click.option(
    "--axis",
    required=True,
    help="The axis that was identified: of the library, or its file.",
    shell_complete=complete_axis,
)
@click.option(
    "--to",
    type=click.Choice(_NAMES),
    required=True,
    help=f"Feed-forward functions in {', '.join(_LANGUAGES[:-1])} or {_LANGUAGES[-1]}; "
    "or the parameters.",
)
@click.option(
    "--method",
    type=click.Choice(method_names()),
    help="Estimator.  [default: the judged one]",
)
@click.option(
    "--record",
    "number",
    type=click.IntRange(min=1),
    metavar="N",
    help="One of several records, whose parameters (by --local and --known) are wanted.",
)
@click.option(
    "--dead-zone",
    type=float,
    default=0.0,
    metavar="SPEED",
    help="Speed up to which the friction direction is 0, in m/s or rad/s.  [default: 0]",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="In place of standard output.",
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
    """Write an identified axis for use elsewhere.

    RESULT is what `axisid identify --json` wrote. The functions NAME_feedforward and NAME_control
    take position, velocity and acceleration of the reference and give force and control; they need
    nothing but the language. JSON, CSV and LaTeX hold all methods unless one is named.
    """
    check_targets([Target("--output", output, "export")], (result, axis), force=force)

    write_output(
        output,
        stages.export(result, to, axis=axis, method=method, dead_zone=dead_zone, record=number),
    )


@click.command(
    cls=Command,
    short_help="Rewrite the generated code of axes.",
    epilog="Example: axisid generate --check",
)
@click.argument("axes", nargs=-1, shell_complete=complete_axis)
@click.option(
    "--check", is_flag=True, help="Write nothing; exit 1 if anything is stale, or of no axis."
)
@click.option(
    "--output",
    type=click.Path(file_okay=False),
    default="generated",
    show_default=True,
    help="Folder of the generated code.",
)
@force_option
def generate(axes: tuple[str, ...], check: bool, output: str, force: bool) -> None:
    """Rewrite the generated code of AXES, by default of the whole library.

    Each axis gets a folder with its CasADi functions, its equations and a manifest. AXES are names
    of the library or TOML or Python files that declare an axis.
    """
    declared = [stages.load_axis(name) for name in axes or stages.LIBRARY]
    for name, axis in zip(axes, declared, strict=False):
        if axis.name in stages.LIBRARY and name not in stages.LIBRARY:
            raise UsageError(
                f"{name} declares an axis named {axis.name!r}, whose folder belongs to the "
                "library; rename the axis."
            )
    with ProgressLine("generating") as line:
        files = stages.expected_files(declared, line)
    if not check:
        check_folder(output, "--output", {}, force=force)
        _write(files, Path(output), axes, force=force)
        return
    findings = stages.check_files(Path(output), files, others=stages.LIBRARY if axes else None)
    for finding in findings:
        click.echo(f"{finding.state}: {Path(output, finding.path)}")
        if finding.state == "stale":
            click.echo(finding.diff)
    missing = {finding.path for finding in findings if finding.state == "missing"}
    folders = {path for path in files if path.parent.name}  # but what all axes share
    if not axes and len(missing) == len(findings) and folders <= missing:
        raise UsageError(
            f"nothing of the library is generated in {output}; name the axes that are meant, as in "
            "axisid generate --check my_axis.toml."
        )
    if findings:
        place = [] if output == "generated" else [f"--output {output}"]
        orphans = any(finding.state == "orphan" for finding in findings)
        click.echo(
            f"not as generated: {len(findings)} of {len(files)}; run: "
            + " ".join(["axisid generate", *axes, *place])
            + "; remove the orphans, or name the axes that are meant" * orphans,
            err=True,
        )
        sys.exit(1)
    click.echo(f"{len(files)} files are current.")


def _write(files: dict[Path, str], output: Path, axes: tuple[str, ...], *, force: bool) -> None:
    # A folder with a manifest was generated, whatever has become of its other files.
    places = [output / path for path in files]
    own = {
        file.parent
        for file in places
        if file.name == stages.MANIFEST and file.is_file() and is_earlier(file, "generate")
    }
    for earlier in (True, False):
        chosen = {file: "generate" for file in places if (file.parent in own) == earlier}
        check_replaced(chosen, "--output", axes, force=force or earlier)
    written = stages.write_files(output, files)
    for path in written:
        click.echo(f"wrote {output / path}")
    click.echo(f"{len(written)} files written, {len(files) - len(written)} were current.")
