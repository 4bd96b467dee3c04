"""``axisid generate``: write the generated code of axes, or check it."""

import sys
from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    check_folder,
    check_replaced,
    complete_axis,
    force_option,
    is_earlier,
    progress_line,
    stages,
)
from axisid.support.errors import UsageError


@click.command(
    cls=Command,
    short_help="Write the generated code of axes.",
    epilog="Example: axisid generate --check",
)
@click.argument("axes", nargs=-1, shell_complete=complete_axis)
@click.option(
    "--check",
    is_flag=True,
    help="Write nothing. The exit code is 1 if a file is stale, missing or belongs to no axis.",
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
    """Write the generated code of AXES. Without AXES: of all axes of the library.

    AXES are axes of the library, or TOML or Python files that declare an axis. Each axis gets a
    folder with its CasADi functions, its equations and a manifest. The manifest lists the
    parameters with their units, the functions, and digests of the files.
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
        # A folder with a manifest was generated, even if its other files have changed since.
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
            f"{len(findings)} of {len(files)} files differ from the generated code. Run: "
            + " ".join(["axisid generate", *axes, *place])
            + ". Remove the orphans, or name their axes." * orphans,
            err=True,
        )
        sys.exit(1)
    click.echo(f"{len(files)} files are up to date.")
