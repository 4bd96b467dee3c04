"""``axisid paper``."""

from pathlib import Path

import click

from axisid.commands.options import Command, check_folder, check_needed, force_option, stages
from axisid.presentation.console import ProgressLine, print_document


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
    "--runs",
    type=click.IntRange(min=2),
    help="Add how the estimates of so many twins are distributed under both filters.",
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
def paper(output: Path | None, runs: int | None, jobs: int, force: bool) -> None:
    """Identify the twin of the paper's axis by all four methods under both filters.

    Prints the tables of Brunot et al. (SYSID 2015) beside the twin's, and draws figures 3 and 4.
    """
    check_needed(("--jobs",), ("--runs",))
    if output is not None:
        import axisid.presentation.matplotlib_backend  # noqa: F401 - refused before anything is computed

    files = {**stages.STUDY_FILES, **(stages.DISTRIBUTION_FILES if runs else {})}
    check_folder(output, "--output", files, force=force)
    with ProgressLine("the paper's study") as line:
        study = stages.run_study(line)
    print_document(stages.study_document(study))
    made = [] if output is None else stages.write_study(study, output)
    if runs:
        with ProgressLine("twins of the paper's axis") as line:
            found = stages.run_distributions(runs, jobs=jobs, progress=line)
        click.echo()
        print_document(stages.distributions_document(found))
        made += [] if output is None else stages.write_distributions(found, output)
    for path in made:
        click.echo(f"wrote {path}")
