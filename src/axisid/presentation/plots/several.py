"""Figures of several records: those of each by itself, and those of all."""

from dataclasses import replace

from axisid.estimation.identification import Identification
from axisid.estimation.studies import Sweep
from axisid.support.missing import Missing

from .estimate import convergence_plot
from .plot import Plot
from .result import result_plots, sweep_plot

_OF_ALL = ("convergence", "sweep")  # which no record has by itself


def plots_by_record(
    result: Identification, sweep: Sweep | None = None
) -> dict[int, dict[str, Plot | Missing]]:
    """Figures by the number of the record, from 1, and those of all under 0, each by its name.

    A record's have its number in their names and titles. One record's are all under 0.

    Parameters
    ----------
    result : Identification
    sweep : Sweep, optional
        Of the same records over the cut-off.
    """
    if not result.of_records:
        return {0: result_plots(result, sweep)}
    of_all: dict[str, Plot | Missing] = {"convergence": convergence_plot(result.preferred)}
    if sweep is not None:
        of_all["sweep"] = sweep_plot(sweep, result.prefilter.cutoff)
    found = {0: of_all}
    for i, (part, name) in enumerate(zip(result.parts, result.record_names, strict=True), 1):
        found[i] = {
            f"{key}-{i}": _of_record(plot, i, name)
            for key, plot in result_plots(part).items()
            if key not in _OF_ALL
        }
    return found


def _of_record(plot: Plot | Missing, number: int, name: str) -> Plot | Missing:
    if isinstance(plot, Missing):
        return plot
    return replace(
        plot,
        name=f"{plot.name}-{number}",
        title=f"{plot.title}, record {number}",
        caption=f"Record {number}, {name}. {plot.caption}",
    )
