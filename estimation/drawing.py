"""Matplotlib draws a `Plot`. Imported only where one is drawn."""

import io
from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .arrays import Array
from .plot import Panel, Plot, Series

# Okabe and Ito's colours, told apart whatever the eye; grey lies beneath.
_COLORS = {
    "measured": "#8a8f98",
    "model": "#0072b2",
    "error": "#d55e00",
    "other": "#009e73",
    "warm": "#c58600",
    "violet": "#b0578d",
}
_INK, _RULE, _SHADE = "#1f2328", "#e3e5e8", "#8a8f98"
_WIDTH, _PANEL, _AROUND = 6.3, 1.5, 0.7  # inches
_DENSE = 2000  # points from which they are drawn as an image inside a vector file
_STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Source Sans 3", "Helvetica", "Arial", "Liberation Sans", "DejaVu Sans"],
    "font.size": 9.0,
    "axes.edgecolor": _INK,
    "axes.labelcolor": _INK,
    "axes.linewidth": 0.6,
    "axes.labelsize": 9.0,
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
    # Text that can be selected and edited, and files that are the same every time.
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "axisid",
}


class Drawing(Figure):
    """A figure that notebooks show as it is, without pyplot."""

    def _repr_png_(self) -> bytes:
        return rendered(self, "png")


def drawn(plot: Plot, title: str = "") -> Drawing:
    """Draw a plot.

    Parameters
    ----------
    plot : Plot
    title : str
        Above it; none where a caption stands below.
    """
    weights = [panel.weight for panel in plot.panels]
    height = _AROUND + _PANEL * max(sum(weights), 1.6)
    with rc_context(_STYLE):
        figure = Drawing(figsize=(_WIDTH, height), layout="constrained")
        rows = figure.subplots(len(weights), 1, sharex=True, squeeze=False, height_ratios=weights)
        for axes, panel in zip(rows[:, 0], plot.panels, strict=True):
            _draw_panel(axes, panel, plot)
        last: Axes = rows[-1, 0]
        last.set_xlabel(_plain(plot.x_label))
        if plot.log:
            _decades(last)
        if plot.whole:
            last.xaxis.set_major_locator(MaxNLocator(integer=True))
        if title:
            figure.suptitle(title, x=0.01, horizontalalignment="left", fontsize=10)
        figure.align_ylabels(list(rows[:, 0]))
    return figure


def rendered(figure: Figure, form: str) -> bytes:
    """Return the file of a figure: ``pdf``, ``svg`` or ``png``, the same every time."""
    stamps: dict[str, dict[str, Any]] = {
        "pdf": {"Creator": "axisid", "CreationDate": None},
        "svg": {"Creator": "axisid", "Date": None},
        "png": {"Software": "axisid"},
    }
    out = io.BytesIO()
    with rc_context(_STYLE):
        figure.savefig(out, format=form, dpi=200, metadata=stamps.get(form))
    return out.getvalue()


def _draw_panel(axes: Axes, panel: Panel, plot: Plot) -> None:
    axes.set_ylabel(_plain(panel.label))
    if plot.log:
        axes.set_xscale("log")
    if panel.log:
        axes.set_yscale("log")
    axes.grid(visible=True, color=_RULE, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    for first, last in plot.shaded:
        axes.axvspan(first, last, color=_SHADE, alpha=0.18, linewidth=0)
    for level in panel.levels:
        axes.axhline(level, color=_INK, linewidth=0.7, linestyle=(0, (4, 3)))
    shown = [series for series in panel.series if not series.aside]
    for series in shown:
        _draw_series(axes, series)
    for place, name in plot.marks:
        axes.axvline(place, color=_INK, linewidth=0.7, linestyle=(0, (4, 3)))
        if panel is plot.panels[0]:
            axes.annotate(
                name,
                (place, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(3, -8),
                textcoords="offset points",
                fontsize=7.5,
                color=_INK,
                bbox={"facecolor": "white", "alpha": 0.8, "pad": 0.5, "linewidth": 0},
            )
    labels = [series.label for series in shown]
    before = plot.panels[max(plot.panels.index(panel) - 1, 0)]
    told = before is not panel and labels == [s.label for s in before.series if not s.aside]
    if sum(map(bool, labels)) > 1 and not told:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, columnspacing=1.2)


def _draw_series(axes: Axes, series: Series) -> None:
    color, label = _COLORS[series.tone], _plain(series.label) or "_none"
    if series.kind == "stems":
        axes.vlines(series.x, 0, series.y, color=color, linewidth=1.2, label=label)
        axes.axhline(0, color=_INK, linewidth=0.6)
        return
    if series.kind == "points":
        dense = len(series.x) > _DENSE
        size = 2.2 if series.broad else 3.4
        axes.plot(
            series.x,
            series.y,
            "o",
            color=color,
            markersize=size,
            markeredgewidth=0,
            alpha=0.35 if series.broad else 1.0,
            label=label,
            rasterized=dense,
            zorder=1.5 if series.broad else 3,
        )
        if series.low is not None and series.high is not None:
            axes.vlines(series.x, series.low, series.high, color=color, linewidth=0.9, zorder=3)
        return
    if series.low is not None and series.high is not None:
        axes.fill_between(series.x, series.low, series.high, color=color, alpha=0.16, linewidth=0)
    axes.plot(
        series.x,
        series.y,
        color=color,
        linewidth=2.2 if series.broad else 1.0,
        linestyle=(0, (4, 2)) if series.dashed else "-",
        marker="o" if len(series.x) <= 40 else None,
        markersize=3,
        label=label,
    )


def _plain(text: str) -> str:
    """Text that is not taken for a formula."""
    return text.replace("$", r"\$")


def _decades(axes: Axes) -> None:
    """Ticks at 1, 2 and 5, written as plain numbers."""
    first, last = axes.get_xlim()
    ticks = np.array(list(_one_two_five(first, last)))
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)


def _one_two_five(first: float, last: float) -> Iterable[float]:
    exponents: Array = np.arange(np.floor(np.log10(first)), np.ceil(np.log10(last)) + 1)
    for exponent in exponents:
        for multiple in (1, 2, 5):
            tick = float(multiple * 10.0**exponent)
            if first <= tick <= last:
                yield tick
