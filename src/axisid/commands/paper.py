"""``axisid paper``."""

from pathlib import Path

import click

from axisid.commands.options import Command, check_folder, check_needed, force_option, stages
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
        made = _encoder_study(runs or _RUNS, jobs, output, force)
    else:
        made = _study(output, force)
        made += _distributions(runs, jobs, output, force) if runs else []
    for path in made:
        click.echo(f"wrote {path}")


def _study(output: Path | None, force: bool) -> list[Path]:

    check_folder(output, "--output", stages.STUDY_FILES, deep=True, force=force)
    with ProgressLine("the paper's study") as line:
        study = stages.run_study(line)
    print_document(stages.study_document(study))
    if output is None:
        return []
    with ProgressLine("drawing figures"):
        return stages.write_study(study, output)


def _distributions(runs: int, jobs: int, output: Path | None, force: bool) -> list[Path]:

    check_folder(output, "--output", stages.DISTRIBUTION_FILES, deep=True, force=force)
    with ProgressLine("twins of the paper's axis") as line:
        found = stages.run_distributions(runs, jobs=jobs, progress=line)
    click.echo()
    print_document(stages.distributions_document(found))
    return [] if output is None else stages.write_distributions(found, output)


def _encoder_study(runs: int, jobs: int, output: Path | None, force: bool) -> list[Path]:

    check_folder(output, "--output", stages.ENCODER_FILES, deep=True, force=force)
    with ProgressLine("the study of encoders") as line:
        study = stages.run_encoder_study(runs, jobs=jobs, progress=line)
    print_document(stages.encoder_document(study))
    if output is None:
        return []
    with ProgressLine("drawing figures"):
        return stages.write_encoder_study(study, output)
