"""Figures as files. Matplotlib is imported here, and this module only where a figure is drawn."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from axisid.estimation.estimates import Estimate
from axisid.estimation.studies import Sweep
from axisid.presentation.plots import Panel, Plot, Series, force_plot, row_times, sweep_plot
from axisid.support.files import replace_file

from .matplotlib import Drawing, draw, rendered

FORMATS = ("pdf", "svg", "png")
#: Every figure that a result can have.
NAMES = (
    *("force", "acceleration", "friction", "convergence", "tracking", "autocorrelation"),
    *("spectrum", "repeats", "sweep", "record"),
)


def force_figure(estimate: Estimate, title: str, path: Path, *, seconds: float = 3.0) -> None:
    """Draw measured and reconstructed force and their difference, like the paper's figures 3 and 4.

    Parameters
    ----------
    estimate : Estimate
        Of an inverse model, whose left side is the force.
    title : str
        Of the figure.
    path : Path
        Written whole or not at all; the suffix chooses the format.
    seconds : float
        How much of the record is shown, from its first row.
    """
    plot = _until(force_plot(estimate), float(row_times(estimate)[0]) + seconds)
    error = estimate.equation_error_percent
    _save(draw(plot, f"{title}: equation error {error:.1f} %"), path)


def sweep_figure(result: Sweep, path: Path) -> None:
    """Draw every parameter over the cut-off.

    Parameters
    ----------
    result : Sweep
    path : Path
        Written whole or not at all; the suffix chooses the format.
    """
    chosen = result.recommended
    title = (
        "no cut-off recommended"
        if chosen is None
        else f"recommended cut-off {chosen:g} Hz (dashed)"
    )
    _save(draw(sweep_plot(result), title), path)


def write_figures(plots: Iterable[Plot], folder: Path, form: str) -> list[Path]:
    """Write each plot into its own file, made for a page with a caption.

    Parameters
    ----------
    plots : iterable of Plot
    folder : Path
        Made if it is not there.
    form : {"pdf", "svg", "png"}

    Returns
    -------
    list of Path
        The files.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for plot in plots:
        path = folder / f"{plot.name}.{form}"
        _save(draw(plot), path)
        written.append(path)
    return written


def _until(plot: Plot, end: float) -> Plot:
    """The plot up to a value of x."""

    def cut(series: Series) -> Series:
        count = int((series.x <= end).sum())
        return replace(series, x=series.x[:count], y=series.y[:count])

    def cut_panel(panel: Panel) -> Panel:
        return replace(panel, series=tuple(map(cut, panel.series)))

    return replace(plot, panels=tuple(map(cut_panel, plot.panels)))


def _save(figure: Drawing, path: Path) -> None:
    replace_file(path, rendered(figure, path.suffix.removeprefix(".").lower() or "png"))
