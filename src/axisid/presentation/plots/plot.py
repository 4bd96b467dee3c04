"""A figure as data: what is drawn and what it is called, before anything draws it.

One description serves matplotlib (`axisid.presentation.matplotlib`) and the report's page.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from axisid.presentation.documents import readable_unit
from axisid.support.arrays import Array

#: What a series stands for; each way of drawing has a colour for it.
Tone: TypeAlias = Literal["measured", "model", "error", "other", "warm", "violet"]
TONES: tuple[Tone, ...] = ("model", "error", "other", "warm", "violet", "measured")

#: What a legend calls the stretches that are shaded.
SHADED = "left out"
#: What figures are called that not every result has; a page says under it why there is none.
TITLES = MappingProxyType(
    {
        "bias": "Bias, as runs come in",
        "coverage": "Intervals that hold the truth",
        "errors": "Errors in stated deviations",
        "convergence": "Convergence of the instruments",
        "friction": "Friction against velocity",
        "repeats": "Residuals that repeat",
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
        For the legend; empty for none.
    x, y : (n,) array
        Ascending in x, unless points; a y of NaN breaks a line.
    kind : {"line", "points", "stems"}
    tone : Tone
    low, high : (n,) array or None
        A band about a line, only its bounds about a dashed one, or whiskers of points.
    broad : bool
        Beneath the others, so that both are seen where they agree.
    dashed : bool
    aside : bool
        Only on request: left out on paper, hidden at first on the page.
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
        As the legend lists them; the first lies lowest, under it the broad ones.
    levels : tuple of float
        Values of y with a dashed line, such as bounds.
    log : bool
        Whether y is logarithmic.
    weight : float
        Height, against the other panels'.
    span : (float, float) or None
        What of y is shown at first; None for everything.
    """

    label: str
    series: tuple[PlotSeries, ...]
    levels: tuple[float, ...] = ()
    log: bool = False
    weight: float = 1.0
    span: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Plot:
    """One figure: panels above one another with x in common.

    Attributes
    ----------
    name : str
        Of its file.
    title, caption : str
        What it shows; what to see in it.
    x_label : str
        Quantity and unit.
    panels : tuple of Panel
    log : bool
        Whether x is logarithmic.
    shaded : tuple of (float, float)
        Stretches of x that were left out, as the legend says.
    marks : tuple of (float, str)
        Values of x with a name.
    whole : bool
        Whether x counts, so that its ticks are whole numbers.
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
    """An axis's label: quantity and unit."""
    return f"{quantity} [{readable_unit(unit)}]" if unit else quantity


def with_series(plot: Plot, change: Callable[[PlotSeries], PlotSeries]) -> Plot:
    """The plot with every series as something makes it."""
    return replace(
        plot,
        panels=tuple(
            replace(panel, series=tuple(map(change, panel.series))) for panel in plot.panels
        ),
    )


def broken(plot: Plot, places: Sequence[float]) -> Plot:
    """The plot with its lines broken at places along x, where there is no sample."""
    return with_series(plot, lambda series: _broken_line(series, places)) if places else plot


def _broken_line(series: PlotSeries, places: Sequence[float]) -> PlotSeries:
    if series.kind != "line":
        return series
    inside = [p for p in places if series.x[0] < p < series.x[-1]]
    at = np.searchsorted(series.x, inside)

    def with_breaks(values: Array | None) -> Array | None:
        return None if values is None else np.insert(values, at, np.nan)

    return replace(
        series,
        x=np.insert(series.x, at, inside),
        y=np.insert(series.y, at, np.nan),
        low=with_breaks(series.low),
        high=with_breaks(series.high),
    )


def line(label: str, x: ArrayLike, y: ArrayLike, tone: Tone = "model") -> PlotSeries:
    """Make a plain line."""
    return PlotSeries(label=label, x=np.asarray(x, float), y=np.asarray(y, float), tone=tone)


def paired(names: Sequence[str]) -> list[tuple[str, Tone]]:
    """Names with a tone each, repeated after the last."""
    return [(name, TONES[i % len(TONES)]) for i, name in enumerate(names)]
