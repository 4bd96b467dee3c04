"""``axisid paper``."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import click

from axisid.commands.options import Command, check_folder, check_needed, force_option, stages
from axisid.presentation.console import ProgressLine, print_document

T = TypeVar("T")

_RUNS = 100


@click.command(
    cls=Command,
    short_help="Reproduce the paper's tables on a twin.",
    epilog="Example: axisid paper --output results",
)
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    help="Also write the tables, the figures and the results as JSON into this folder.",
)
@click.option(
    "--encoder",
    is_flag=True,
    help="In place of the tables: how coarse an encoder each method bears, 4000 to 20 counts a "
    "revolution.",
)
@click.option(
    "--runs",
    type=click.IntRange(min=2),
    help="Add how the estimates of so many twins are distributed under both filters; with "
    "--encoder, twins of each encoder (default 100, which takes minutes).",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Processes for those twins; the numbers are the same for any.",
)
@force_option
def paper(output: Path | None, encoder: bool, runs: int | None, jobs: int, force: bool) -> None:
    """Identify the twin of the paper's axis by all four methods under both filters.

    Prints the tables of Brunot et al. (SYSID 2015) beside the twin's, and draws figures 3 and 4.
    """
    check_needed(("--jobs",), ("--runs", "--encoder"))
    if output is not None:
        import axisid.presentation.drawing  # noqa: F401 - refused before anything is computed

    if encoder:
        made = _part(
            "the study of encoders",
            stages.ENCODER_FILES,
            lambda line: stages.run_encoder_study(runs or _RUNS, jobs=jobs, progress=line),
            stages.encoder_document,
            stages.write_encoder_study,
            output,
            force=force,
        )
    else:
        made = _part(
            "the paper's study",
            stages.STUDY_FILES,
            stages.run_study,
            stages.study_document,
            stages.write_study,
            output,
            force=force,
        )
    if runs and not encoder:
        click.echo()
        made += _part(
            "twins of the paper's axis",
            stages.DISTRIBUTION_FILES,
            lambda line: stages.run_distributions(runs, jobs=jobs, progress=line),
            stages.distributions_document,
            stages.write_distributions,
            output,
            force=force,
        )
    for path in made:
        click.echo(f"wrote {path}")


def _part(
    title: str,
    files: Mapping[str, str],
    run: Callable[[ProgressLine], T],
    document: "Callable[[T], stages.Document]",
    write: Callable[[T, Path], list[Path]],
    output: Path | None,
    *,
    force: bool,
) -> list[Path]:
    """Run a part of the study, print its document, and write its files; return these."""
    check_folder(output, "--output", files, deep=True, force=force)
    with ProgressLine(title) as line:
        found = run(line)
    print_document(document(found))
    if output is None:
        return []
    with ProgressLine("drawing figures"):
        return write(found, output)
