"""``axisid generate``."""

import sys
from itertools import pairwise
from pathlib import Path
from time import perf_counter

import click

from axisid.commands.options import (
    Command,
    check_replaced,
    complete_axis,
    force_option,
    is_earlier,
    stages,
)
from axisid.presentation.console import ProgressLine
from axisid.support.errors import UsageError


@click.command(
    cls=Command,
    short_help="Rewrite the generated code of axes.",
    epilog="Example: axisid generate --check",
)
@click.argument("axes", nargs=-1, shell_complete=complete_axis)
@click.option(
    "--check", is_flag=True, help="Write nothing; exit 1 if anything is stale, or of no axis."
)
@click.option("-v", "--verbose", is_flag=True, help="Say how long each axis takes.")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default="generated",
    show_default=True,
    help="Folder of the generated code.",
)
@force_option
def generate(axes: tuple[str, ...], check: bool, verbose: bool, output: Path, force: bool) -> None:
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
    files = _generated(declared, verbose=verbose)
    if not check:
        # A folder with a manifest was generated, whatever has become of its other files.
        places = [output / path for path in files]
        manifests = [file for file in places if file.name == stages.MANIFEST and file.is_file()]
        own = {file.parent for file in manifests if is_earlier(file, "generate")}
        for earlier in (True, False):
            chosen = {file: "generate" for file in places if (file.parent in own) == earlier}
            check_replaced(chosen, "--output", axes, force=force or earlier)
        written = stages.write_files(output, files)
        for path in written:
            click.echo(f"wrote {output / path}")
        click.echo(f"{len(written)} files written, {len(files) - len(written)} were current.")
        return
    findings = stages.check_files(output, files, others=stages.LIBRARY if axes else None)
    for finding in findings:
        click.echo(f"{finding.state}: {output / finding.path}")
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
        orphan = any(finding.state == "orphan" for finding in findings)
        place = [] if output == Path("generated") else [f"--output {output}"]
        command = " ".join(["axisid generate", *axes, *place])
        remove = "; remove the orphans, or name the axes that are meant" if orphan else ""
        click.echo(
            f"not as generated: {len(findings)} of {len(files)}; run: {command}{remove}", err=True
        )
        sys.exit(1)
    click.echo(f"{len(files)} files are current.")


def _generated(declared: "list[stages.Axis]", *, verbose: bool) -> dict[Path, str]:
    """The generated files of the axes; on request it is said how long each axis took."""
    begun: list[tuple[str, float]] = []
    with ProgressLine("generating") as line:

        def begin_axis(done: int, total: int, name: str) -> None:
            begun.append((name, perf_counter()))
            line(done, total, name)

        files = stages.expected_files(declared, begin_axis)
        begun.append(("", perf_counter()))
    if verbose:
        for (name, begin), (_, end) in pairwise(begun):
            click.echo(f"{name}: {1e3 * (end - begin):.0f} ms")
    return files
