"""Figures by Matplotlib: a `Plot` is drawn with suitable ticks, and written to files.

The module is imported only if a figure is drawn.
"""

import io
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.model_selection import Sweep
from axisid.presentation.plots import (
    SHADED,
    Panel,
    Plot,
    PlotSeries,
    force_plot,
    row_times,
    sweep_plot,
    with_series,
)
from axisid.support.errors import UsageError
from axisid.support.files import replace_file
from axisid.support.libraries import one_line
from axisid.support.missing import Missing

try:
    from matplotlib import rc_context
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.font_manager import fontManager
    from matplotlib.ticker import (
        LogFormatterMathtext,
        LogLocator,
        MaxNLocator,
        NullLocator,
        ScalarFormatter,
    )
except Exception as error:  # Matplotlib reads the user's variables and files on import
    raise UsageError(
        f"no figure can be drawn: matplotlib cannot be imported ({one_line(error)}). "
        "Correct the named setting, for example the variable MPLBACKEND, or omit the figures."
    ) from error


# Okabe and Ito's colours, distinguishable with colour blindness; grey for measurements.
_COLORS = {
    "measured": "#4a515b",
    "model": "#0072b2",
    "error": "#d55e00",
    "other": "#009e73",
    "warm": "#c58600",
    "violet": "#b0578d",
}


_INK, _RULE, _SHADE = "#1f2328", "#e3e5e8", "#8a8f98"  # text and axes, grid, shaded stretches
_WIDTH = 160.0 / 25.4  # inches, text width of a page
_PANEL, _AROUND = 1.5, 0.7  # inches, height of a panel with weight 1, and of labels around panels
_NAMED = 0.17  # inches, height of the names of marks
_DENSE = 2000  # points; more are drawn as an image inside a vector file

# By preference; DejaVu Sans, which Matplotlib includes, has the exponents that others lack.
_FONTS = ("Source Sans 3", "Helvetica", "Arial", "Liberation Sans")


_STYLE: Any = {
    "font.size": 9.0,
    "axes.edgecolor": _INK,
    "axes.labelcolor": _INK,
    "axes.linewidth": 0.6,
    "axes.labelsize": 9.0,
    "axes.formatter.use_mathtext": True,
    "mathtext.default": "regular",
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.color": _INK,
    "ytick.color": _INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.borderaxespad": 0.2,
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
    # Selectable and editable text, and reproducible files.
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "axisid",
}


# Smallest number of ticks; also the number of decades from which only powers of ten have ticks.
_FEWEST = 3
_WRITTEN_OUT = (-2, 5)  # powers of ten between which numbers are written out


class Drawing(Figure):
    """A figure that notebooks show without pyplot."""

    def _repr_png_(self) -> bytes:
        """Return the figure as a PNG file."""
        return rendered(self, "png")


def draw(plot: Plot, title: str = "") -> Drawing:
    """Return a new figure of a plot, with one pair of axes per panel.

    Parameters
    ----------
    plot : Plot
    title : str
        Title above the figure; empty for none, if there is a caption below the figure.
    """
    weights = [panel.weight for panel in plot.panels]
    height = _AROUND + _PANEL * max(sum(weights), 1.6)
    with rc_context(_style()):
        figure = Drawing(figsize=(_WIDTH, height), layout="constrained")
        rows = figure.subplots(len(weights), 1, sharex=True, squeeze=False, height_ratios=weights)
        axes = list(rows[:, 0])
        _draw_panels(axes, plot, 4)
        if title:
            figure.suptitle(title, x=0.01, horizontalalignment="left", fontsize=10)
        figure.align_ylabels(axes)
    return figure


def draw_on(plot: Plot, ax: object) -> Figure:
    """Draw a plot on existing axes of Matplotlib, and return their figure.

    Parameters
    ----------
    plot : Plot
    ax : Axes or sequence of Axes
        One per panel of the plot.

    Raises
    ------
    UsageError
        The arguments are not axes, or their number is wrong.
    """
    given = [ax] if isinstance(ax, Axes) else [*np.ravel(np.asarray(ax, dtype=object))]
    if not given or not all(isinstance(each, Axes) for each in given):
        raise UsageError(
            f"ax is of the type {type(ax).__name__}; expected are axes of Matplotlib. Give axes, "
            f"for example plt.subplots({len(plot.panels)}, sharex=True)[1].",
            code="figure",
        )
    if len(given) != len(plot.panels):
        raise UsageError(
            f"the figure {plot.name} has {len(plot.panels)} panels, but ax has {len(given)} axes. "
            "Give one pair of axes per panel, for example "
            f"plt.subplots({len(plot.panels)}, sharex=True)[1].",
            code="figure",
        )
    _draw_panels(given, plot, 2)
    return cast(Figure, given[0].get_figure(root=True))


def _draw_panels(axes: Sequence[Axes], plot: Plot, columns: int) -> None:
    """Draw the panels of a plot on axes, with `columns` legend entries side by side."""
    for each, panel in zip(axes, plot.panels, strict=True):
        _draw_panel(each, panel, plot, columns)
    axes[-1].set_xlabel(_plain(plot.x_label))
    _set_ticks(axes[-1].xaxis, log=plot.log, whole=plot.whole)


def rendered(figure: Figure, form: str) -> bytes:
    """Return a figure as the reproducible bytes of a file in a format: pdf, svg or png."""
    stamps: dict[str, dict[str, Any]] = {
        "pdf": {"Creator": "axisid", "CreationDate": None},
        "svg": {"Creator": "axisid", "Date": None},
        "png": {"Software": "axisid"},
    }
    out = io.BytesIO()
    with rc_context(_style()):
        figure.savefig(out, format=form, dpi=200, metadata=stamps.get(form))
    return out.getvalue()


def _style() -> Any:
    """Return Matplotlib's settings for all figures, with the fonts that are installed.

    With a list of families, a missing glyph is taken from the next font; with a generic family it
    is not.
    """
    installed = {font.name for font in fontManager.ttflist}
    return {**_STYLE, "font.family": [*(f for f in _FONTS if f in installed), "DejaVu Sans"]}


def _draw_panel(axes: Axes, panel: Panel, plot: Plot, columns: int) -> None:
    """Draw the series, levels, shaded stretches, marks and legend of one panel."""
    axes.set_ylabel(_plain(panel.label))
    if plot.log:
        axes.set_xscale("log")
    if panel.log:
        axes.set_yscale("log")
    axes.grid(visible=True, color=_RULE, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    for i, (first, last) in enumerate(plot.shaded):
        label = "_none" if i or panel is not plot.panels[0] else SHADED
        axes.axvspan(first, last, color=_SHADE, alpha=0.18, linewidth=0, label=label)
    for level in panel.levels:
        axes.axhline(level, color=_INK, linewidth=0.7, linestyle=(0, (4, 3)))
    for series in sorted(panel.series, key=lambda each: not each.broad):  # the broad ones lowest
        if not series.aside:
            _draw_series(axes, series)
    if panel.span is not None:
        axes.set_ylim(*panel.span)
    _set_ticks(axes.yaxis, log=panel.log)
    for place, _ in plot.marks:
        axes.axvline(place, color=_INK, linewidth=0.7, linestyle=(0, (4, 3)))
    if panel is plot.panels[0]:
        _name_marks(axes, plot)
    _draw_legend(axes, panel, plot, columns)


def _name_marks(axes: Axes, plot: Plot) -> None:
    """Write the names of marked x values above the axes.

    Of two names, one is written to the left and the other to the right of its mark.
    """
    places = sorted(place for place, _ in plot.marks)
    for place, name in plot.marks:
        side = "center"
        if len(places) == 2:
            side = "right" if place == places[0] else "left"
        axes.annotate(
            name,
            (place, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 2),
            textcoords="offset points",
            horizontalalignment=side,
            fontsize=7.5,
            color=_INK,
        )


def _draw_legend(axes: Axes, panel: Panel, plot: Plot, columns: int) -> None:
    """Draw the legend of a panel, in its order, unless the panel above has the same legend."""
    labels = [series.label for series in panel.series if not series.aside]
    is_first = panel is plot.panels[0]
    above = plot.panels[max(plot.panels.index(panel) - 1, 0)]
    is_named_above = not is_first and labels == [s.label for s in above.series if not s.aside]
    artists, names = axes.get_legend_handles_labels()
    handles = dict(zip(names, artists, strict=True))
    shown = [_plain(label) for label in labels if label]
    if is_first and plot.shaded:
        shown.append(SHADED)
    # A single series needs no legend, unless a stretch is shaded.
    fewest = 1 if plot.shaded else 2
    if len(shown) >= fewest and not is_named_above:
        # The legend of the first panel is above the names of the marks.
        lifted = _NAMED / (_PANEL * panel.weight) if is_first and plot.marks else 0.0
        axes.legend(
            [handles[label] for label in shown],
            shown,
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0 + lifted),
            ncols=columns,
            columnspacing=1.2,
        )


def _draw_series(axes: Axes, series: PlotSeries) -> None:
    """Draw one series as stems, as points with error bars, or as a line with its band."""
    color, label = _COLORS[series.tone], _plain(series.label) or "_none"
    if series.kind == "stems":
        axes.vlines(series.x, 0, series.y, color=color, linewidth=1.2, label=label)
        axes.axhline(0, color=_INK, linewidth=0.6)
        return
    if series.kind == "points":
        axes.plot(
            series.x,
            series.y,
            "o",
            color=color,
            markersize=2.2 if series.broad else 3.4,
            markeredgewidth=0,
            alpha=0.35 if series.broad else 1.0,
            label=label,
            rasterized=len(series.x) > _DENSE,
            zorder=1.5 if series.broad else 3,
        )
        if series.low is not None and series.high is not None:
            axes.vlines(series.x, series.low, series.high, color=color, linewidth=0.9, zorder=3)
        return
    if series.low is not None and series.high is not None:
        if series.dashed:
            for bound in (series.low, series.high):
                axes.plot(series.x, bound, color=color, linewidth=0.7, linestyle=(0, (1, 2)))
        else:
            axes.fill_between(
                series.x, series.low, series.high, color=color, alpha=0.16, linewidth=0
            )
    axes.plot(
        series.x,
        series.y,
        color=color,
        alpha=0.5 if series.broad else 1.0,
        linewidth=2.6 if series.broad else 0.8,
        linestyle=(0, (4, 2)) if series.dashed else "-",
        marker="o" if len(series.x) == 1 or (series.low is None and len(series.x) <= 40) else None,
        markersize=3,
        label=label,
    )


def _plain(text: str) -> str:
    """Return text escaped so that Matplotlib does not read it as a formula."""
    return text.replace("$", r"\$")


def _set_ticks(axis: Axis, *, log: bool = False, whole: bool = False) -> None:
    """Set the ticks of an axis, once its limits are final.

    Parameters
    ----------
    axis : Axis
    log : bool
        True for a logarithmic axis.
    whole : bool
        True if ticks are whole numbers.
    """
    axis.set_major_locator(
        MaxNLocator(
            "auto",
            steps=[1, 2, 2.5, 5, 10],
            integer=whole,
            min_n_ticks=1 if whole else _FEWEST,
        )
    )
    plain = ScalarFormatter(useOffset=False, useMathText=True)
    plain.set_powerlimits(_WRITTEN_OUT)
    axis.set_major_formatter(plain)
    if log:
        low, high = sorted(axis.get_view_interval())
        many = high > low * 10.0**_FEWEST
        axis.set_major_locator(LogLocator(subs=(1.0,) if many else (1.0, 2.0, 5.0)))
        axis.set_major_formatter(LogFormatterMathtext() if many else plain)
        axis.set_minor_locator(NullLocator())


#: Names of all figures of a result.
NAMES = (
    *("force", "acceleration", "friction", "convergence", "tracking", "autocorrelation"),
    *("spectrum", "repeats", "sweep", "record"),
)


def force_figure(estimate: Estimate, title: str, path: Path, *, seconds: float = 3.0) -> None:
    """Draw measured and reconstructed force and the residual, like figures 3 and 4 of the paper.

    Parameters
    ----------
    estimate : Estimate
        Estimate of an inverse model, which regresses the force.
    title : str
        Title of the figure.
    path : Path
        File; the suffix selects the format. An incomplete file is never left behind.
    seconds : float
        Length of the shown part of the record, from its first row.
    """
    plot, end = force_plot(estimate), float(row_times(estimate)[0]) + seconds
    shown = with_series(plot, lambda s: replace(s, x=s.x[s.x <= end], y=s.y[s.x <= end]))
    title = f"{title}: equation error {estimate.equation_error_percent:.1f} % of the force"
    _save(draw(shown, title), path)


def sweep_figure(result: Sweep, path: Path) -> None:
    """Draw every parameter over the cut-off frequency.

    Parameters
    ----------
    result : Sweep
    path : Path
        File; the suffix selects the format. An incomplete file is never left behind.
    """
    title = (
        "no cut-off recommended"
        if result.recommended is None
        else f"recommended cut-off {result.recommended:g} Hz (dashed)"
    )
    _save(draw(sweep_plot(result), title), path)


def write_figures(plots: Iterable[Plot | Missing], folder: Path, form: str) -> list[Path]:
    """Write each plot that is not Missing to its own file, without title, and return the files.

    Parameters
    ----------
    plots : iterable of Plot or Missing
        Missing plots are skipped.
    folder : Path
        Folder of the files; it is created if it does not exist.
    form : {"pdf", "svg", "png"}
        Format and suffix of the files.

    Returns
    -------
    list of Path
    """
    folder.mkdir(parents=True, exist_ok=True)
    found = {folder / f"{plot.name}.{form}": plot for plot in plots if isinstance(plot, Plot)}
    for path, plot in found.items():
        _save(draw(plot), path)
    return [*found]


def _save(figure: Drawing, path: Path) -> None:
    """Write a figure to a file in the format of its suffix; ``png`` without a suffix."""
    replace_file(path, rendered(figure, path.suffix.removeprefix(".").lower() or "png"))
