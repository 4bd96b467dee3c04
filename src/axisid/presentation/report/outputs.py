"""What `axisid identify` writes for people: the page and the figures."""

import time
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

from axisid.estimation.identification import Identification
from axisid.estimation.studies import Sweep, Validation
from axisid.presentation.plots import Plot, plots_by_record
from axisid.support.errors import EstimationError, UsageError
from axisid.support.files import replace_file

from .page import report_html, report_sweep

_PATIENCE = 1.0  # s

Say = Callable[[str], None]


def write_outputs(
    result: Identification,
    validations: Sequence[Validation],
    say: Say,
    *,
    report: str | None = None,
    figures: str | None = None,
    command: str = "",
) -> list[Path]:
    """Write what is asked for and return the files.

    Parameters
    ----------
    result : Identification
    validations : sequence of Validation
        On further records.
    say : callable
        Takes a line for the user.
    report : str, optional
        File of the page.
    figures : str, optional
        Folder of the figures.
    command : str
        What reproduces the result.

    Raises
    ------
    UsageError
        A place cannot be written to.
    """
    if report is None and figures is None:
        return []
    cutoffs = _swept(result, say)
    written = []
    try:
        if report is not None:
            page = report_html(
                result,
                cutoffs,
                validation=validations,
                command=command,
                made=datetime.now().astimezone(),
            )
            replace_file(Path(report), page)
            written.append(Path(report))
        if figures is not None:
            from axisid.presentation.drawing import write_figures

            found = plots_by_record(result, cutoffs).values()
            every = (plot for of_one in found for plot in of_one.values())
            plots = [plot for plot in every if isinstance(plot, Plot)]
            written += write_figures(plots, Path(figures), "pdf")
    except OSError as error:
        place = error.filename or report or figures
        raise UsageError(f"{place} cannot be written: {error.strerror}.") from error
    return written


def _swept(result: Identification, say: Say) -> Sweep | None:
    """The report's sweep, or none where no cut-off gives an estimate."""
    begin = time.monotonic()

    def progress(done: int, count: int, _: str) -> None:
        if time.monotonic() - begin > _PATIENCE:
            say(f"sweep for the report: {done} of {count} cut-offs")

    try:
        return report_sweep(result, progress)
    except EstimationError as error:
        say(f"without the sweep: {error}")
        return None
