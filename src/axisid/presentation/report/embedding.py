"""Figures as data inside a page: small, and harmless whatever the names in them are.

Each array is stored once, as 32-bit floats in base64; one with even steps as start, step, count.
"""

import base64
import json
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.presentation.plots import SHADED, Panel, Plot, Series

Array = NDArray[np.float64]

_MOST_POINTS = 30_000  # of a curve; more become the least and the largest of each stretch
_EVEN = 1e-6  # of a step


def script_json(value: Any) -> str:
    """JSON for the inside of a script element, which nothing in it can end."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def figures_data(plots: Iterable[Plot]) -> dict[str, Any]:
    """What the page's script draws: ``arrays`` in base64, and ``plots`` that refer to them."""
    pool = _Pool()
    listed = [_plot(plot, pool) for plot in plots]
    return {"arrays": list(pool.numbers), "plots": listed}


class _Pool:
    """Arrays by content; insertion order is their number."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def put(self, values: Array | None) -> Any:
        if values is None:
            return None
        if len(values) > 2 and _is_even(values):
            step = float(values[-1] - values[0]) / (len(values) - 1)
            return {"start": float(values[0]), "step": step, "count": len(values)}
        content = base64.b64encode(values.astype("<f4").tobytes()).decode("ascii")
        return self.numbers.setdefault(content, len(self.numbers))


def _is_even(values: Array) -> bool:
    steps = np.diff(values)
    return bool(steps[0] != 0 and np.all(np.abs(steps - steps.mean()) <= _EVEN * abs(steps[0])))


def _plot(plot: Plot, pool: _Pool) -> dict[str, Any]:
    return {
        "name": plot.name,
        "x_label": plot.x_label,
        "log": plot.log,
        "whole": plot.whole,
        "shaded": plot.shaded,
        "shade": SHADED,
        "marks": plot.marks,
        "panels": [_panel(panel, pool) for panel in plot.panels],
    }


def _panel(panel: Panel, pool: _Pool) -> dict[str, Any]:
    return {
        "label": panel.label,
        "log": panel.log,
        "weight": panel.weight,
        "span": panel.span,
        "levels": panel.levels,
        "series": [_series(series, pool) for series in panel.series],
    }


def _series(series: Series, pool: _Pool) -> dict[str, Any]:
    x, y = series.x, series.y
    if len(x) > _MOST_POINTS and series.low is None:
        if series.kind == "line":
            x, y = thinned(x, y, _MOST_POINTS)
        else:
            every = -(-len(x) // _MOST_POINTS)
            x, y = x[::every], y[::every]
    return {
        "label": series.label,
        "kind": series.kind,
        "tone": series.tone,
        "broad": series.broad,
        "dashed": series.dashed,
        "aside": series.aside,
        "x": pool.put(x),
        "y": pool.put(y),
        "low": pool.put(series.low),
        "high": pool.put(series.high),
    }


def thinned(x: Array, y: Array, most: int) -> tuple[Array, Array]:
    """The least and the largest value of each stretch, in their order, evenly in x.

    Parameters
    ----------
    x, y : (n,) array
        Even in x.
    most : int
        How many points may be left; extremes are kept whatever it is.
    """
    length = -(-len(x) // (most // 2))
    starts = np.arange(0, len(x), length)
    places: list[list[int]] = []
    for start in starts:
        part = y[start : start + length]
        least, largest = int(part.argmin()), int(part.argmax())
        places.append(sorted((int(start) + least, int(start) + largest)))
    halves = (starts[:, None] + np.array([0.25, 0.75]) * length).ravel()
    step = (x[-1] - x[0]) / (len(x) - 1)
    return x[0] + step * halves, y[np.array(places).ravel()]
