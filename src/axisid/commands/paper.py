"""``axisid paper``: reproduce the tables of the paper on a twin."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from axisid.commands.options import (
    Command,
    check_folder,
    check_needed,
    force_option,
    print_document,
    progress_line,
    put_out,
    stages,
)


@click.command(
    cls=Command,
    short_help="Reproduce the paper's tables on a twin.",
    epilog="Example: axisid paper --output results",
)
@click.option(
    "--output",
    metavar="DIR",
    help="Also write the tables, the figures and the results as JSON into this folder.",
)
@click.option(
    "--runs",
    type=click.IntRange(min=2),
    metavar="N",
    help="Also show the distribution of the estimates of N twins with both filters.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Number of processes for the twins of --runs. The results do not depend on this number.",
)
@force_option
def paper(output: str | None, runs: int | None, jobs: int, force: bool) -> None:
    """Identify a simulated record (twin) of the axis of a paper, Brunot et al. (SYSID 2015).

    The methods are those of the paper: IDM-LS, DDM-LS, IDM-IV and DDM-IV. The filters are those of
    the paper too: the appropriate filter has a cut-off of 60 Hz and a decimation by 10, the
    inappropriate filter has a cut-off of 180 Hz and a decimation by 3.

    The command prints the tables of the paper next to the tables of the twin. With --output, the
    command also draws figures 3 and 4 of the paper.
    """
    check_needed((("--jobs",), ("--runs",)))
    if output is not None:
        import axisid.presentation.matplotlib  # noqa: F401 - refused before anything is computed

    files = {**stages.STUDY_FILES, **(stages.DISTRIBUTION_FILES if runs else {})}
    check_folder(output, "--output", files, force=force)

    def put(made: Any, document: "stages.Document", write: Callable[[Any, Path], Any]) -> None:
        put_out(
            None,
            dict,
            lambda: print_document(document),
            (output, lambda folder: write(made, Path(folder))),
        )

    with progress_line("the paper's study") as line:
        study = stages.run_study(line)
    put(study, stages.study_document(study), stages.write_study)
    if runs:
        with progress_line("twins of the paper's axis") as line:
            found = stages.run_distributions(runs, jobs=jobs, progress=line)
        click.echo()
        put(found, stages.distributions_document(found), stages.write_distributions)
