"""A figure as data: series, labels and caption.

The same data are drawn by Matplotlib (`axisid.presentation.matplotlib`) and by the report page.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from axisid.presentation.documents import readable_unit
from axisid.support.arrays import Array

#: Role of a series; each renderer has a colour for it.
Tone: TypeAlias = Literal["measured", "model", "error", "other", "warm", "violet"]
TONES: tuple[Tone, ...] = ("model", "error", "other", "warm", "violet", "measured")

#: Name of the shaded stretches in a legend.
SHADED = "not used"
#: Titles of figures that some results lack; a page gives the reason under the title.
TITLES = MappingProxyType(
    {
        "bias": "Bias over the number of runs",
        "coverage": "Coverage of the intervals",
        "errors": "Errors in standard errors",
        "convergence": "Convergence of the IV iteration",
        "friction": "Friction over velocity",
        "repeats": "Residual that repeats with the motion",
        "spectrum": "Spectrum of the residuals",
        "tracking": "Tracking, recorded and simulated",
    }
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlotSeries:
    """One curve, or one set of points or stems.

    Attributes
    ----------
    label : str
        Name in the legend; empty for none.
    x, y : (n,) array
        Ascending in x, except for points; NaN in y breaks a line.
    kind : {"line", "points", "stems"}
    tone : Tone
    low, high : (n,) array or None
        Band around a line (bounds only for a dashed line), or error bars of points.
    broad : bool
        True if drawn broad and below the others, so that both are visible if they agree.
    dashed : bool
        True for a dashed line.
    aside : bool
        True if the series is shown on request only: it is not drawn in files, and is hidden at
        first on the page.
    """

    label: str
    x: Array
    y: Array
    kind: Literal["line", "points", "stems"] = "line"
    tone: Tone = "model"
    low: Array | None = None
    high: Array | None = None
    broad: bool = False
    dashed: bool = False
    aside: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One pair of axes.

    Attributes
    ----------
    label : str
        Quantity and unit of y: ``force [N]``.
    series : tuple of PlotSeries
        In the order of the legend. Later ones are drawn above earlier ones, broad ones lowest.
    levels : tuple of float
        Values of y with a dashed line, for example bounds.
    log : bool
        True for a logarithmic y axis.
    weight : float
        Height relative to the other panels.
    span : (float, float) or None
        Range of y shown at first; None for all.
    """

    label: str
    series: tuple[PlotSeries, ...]
    levels: tuple[float, ...] = ()
    log: bool = False
    weight: float = 1.0
    span: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Plot:
    """One figure: panels above one another with a common x axis.

    Attributes
    ----------
    name : str
        Name of the figure and of its file.
    title, caption : str
        Title, and a caption that explains the figure.
    x_label : str
        Quantity and unit of x.
    panels : tuple of Panel
    log : bool
        True for a logarithmic x axis.
    shaded : tuple of (float, float)
        Stretches of x that are not used.
    marks : tuple of (float, str)
        Values of x that are marked by a line with a name.
    whole : bool
        True if ticks of x are whole numbers.
    """

    name: str
    title: str
    caption: str
    x_label: str
    panels: tuple[Panel, ...]
    log: bool = False
    shaded: tuple[tuple[float, float], ...] = ()
    marks: tuple[tuple[float, str], ...] = ()
    whole: bool = False


def labelled(quantity: str, unit: str) -> str:
    """Return the label of an axis of a figure: ``quantity [unit]``; without a unit the quantity."""
    return f"{quantity} [{readable_unit(unit)}]" if unit else quantity


def with_series(plot: Plot, change: Callable[[PlotSeries], PlotSeries]) -> Plot:
    """Return the plot with `change` applied to every series."""
    return replace(
        plot,
        panels=tuple(
            replace(panel, series=tuple(map(change, panel.series))) for panel in plot.panels
        ),
    )


def broken(plot: Plot, places: Sequence[float]) -> Plot:
    """Return the plot with its lines interrupted at values of x where samples are missing.

    `places` are these values of x.
    """
    return with_series(plot, lambda series: _broken_line(series, places)) if places else plot


def _broken_line(series: PlotSeries, places: Sequence[float]) -> PlotSeries:
    """Return a line interrupted at values of x by NaN; points and stems are unchanged."""
    if series.kind != "line":
        return series
    inside = [place for place in places if series.x[0] < place < series.x[-1]]
    at = np.searchsorted(series.x, inside)

    def with_breaks(values: Array | None) -> Array | None:
        """Return values with NaN at the breaks; None stays None."""
        return None if values is None else np.insert(values, at, np.nan)

    return replace(
        series,
        x=np.insert(series.x, at, inside),
        y=np.insert(series.y, at, np.nan),
        low=with_breaks(series.low),
        high=with_breaks(series.high),
    )


def line(label: str, x: ArrayLike, y: ArrayLike, tone: Tone = "model") -> PlotSeries:
    """Return a series that is a plain line without a band."""
    return PlotSeries(label=label, x=np.asarray(x, float), y=np.asarray(y, float), tone=tone)


def paired(names: Sequence[str]) -> list[tuple[str, Tone]]:
    """Return names with tones (colours); the tones are repeated after the last one."""
    return [(name, TONES[i % len(TONES)]) for i, name in enumerate(names)]
