"""``axisid paper``."""

from pathlib import Path

import click

from axisid.commands.options.option_checks import Command, check_needed
from axisid.commands.options.outputs import check_folder, force_option
from axisid.presentation.console import ProgressLine, print_document

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
    help="Twins of each encoder, with --encoder (default 100, which takes minutes).",
)
@force_option
def paper(output: Path | None, encoder: bool, runs: int | None, force: bool) -> None:
    """Identify the twin of the paper's axis by all four methods under both filters.

    Prints the tables of Brunot et al. (SYSID 2015) beside the twin's, and draws figures 3 and 4.
    """
    check_needed(("--runs",), ("--encoder",))
    if output is not None:
        import axisid.presentation.drawing  # noqa: F401 - refused before anything is computed

    made = _encoder_study(runs or _RUNS, output, force) if encoder else _study(output, force)
    for path in made:
        click.echo(f"wrote {path}")


def _study(output: Path | None, force: bool) -> list[Path]:
    from axisid.paper import STUDY_FILES, run_study, study_document, write_study

    check_folder(output, "--output", STUDY_FILES, deep=True, force=force)
    with ProgressLine("the paper's study") as line:
        study = run_study(line)
    print_document(study_document(study))
    if output is None:
        return []
    with ProgressLine("drawing figures"):
        return write_study(study, output)


def _encoder_study(runs: int, output: Path | None, force: bool) -> list[Path]:
    from axisid.paper import (
        ENCODER_FILES,
        encoder_document,
        run_encoder_study,
        write_encoder_study,
    )

    check_folder(output, "--output", ENCODER_FILES, deep=True, force=force)
    with ProgressLine("the study of encoders") as line:
        study = run_encoder_study(runs, progress=line)
    print_document(encoder_document(study))
    if output is None:
        return []
    with ProgressLine("drawing figures"):
        return write_encoder_study(study, output)
