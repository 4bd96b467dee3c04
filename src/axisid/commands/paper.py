"""``axisid paper``."""

from pathlib import Path

import click

from axisid.commands.options.option_checks import Command
from axisid.commands.options.outputs import check_folder, force_option
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
@force_option
def paper(output: Path | None, force: bool) -> None:
    """Identify the twin of the paper's axis by all four methods under both filters.

    Prints the tables of Brunot et al. (SYSID 2015) beside the twin's, and draws figures 3 and 4.
    """
    from axisid.paper import STUDY_FILES, run_study, study_document, write_study

    if output is not None:
        import axisid.presentation.drawing  # noqa: F401 - refused before anything is computed

    check_folder(output, "--output", STUDY_FILES, deep=True, force=force)
    with ProgressLine("the paper's study") as line:
        study = run_study(line)
    print_document(study_document(study))
    if output is not None:
        with ProgressLine("drawing figures"):
            written = write_study(study, output)
        for path in written:
            click.echo(f"wrote {path}")
