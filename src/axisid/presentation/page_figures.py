"""The figures of a page, as data inside it, and nothing from outside.

The data are small, and harmless whatever the names in them are: each array is stored once, as
32-bit floats in base64; one with even steps as start, step, count.
"""

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from html import escape
from typing import Any

import msgspec
import numpy as np

from axisid.presentation.documents import prose_html
from axisid.presentation.plots import SHADED, TITLES, Plot, PlotSeries
from axisid.support.arrays import Array
from axisid.support.errors import Missing

_MOST_POINTS = 30_000  # of a curve; more become the least and the largest of each stretch


_EVEN = 1e-6  # of a step


_HARMLESS = str.maketrans({sign: f"\\u{ord(sign):04x}" for sign in "<>&\u2028\u2029"})


_PAIRS = (("friction", "convergence"), ("autocorrelation", "spectrum"))  # beside one another


def script_json(value: Any) -> str:
    """JSON for the inside of a script element, which nothing in it can end."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).translate(_HARMLESS)


def figures_data(plots: Iterable[Plot]) -> dict[str, Any]:
    """What the page's script draws: ``arrays`` in base64, and ``plots`` that refer to them."""
    numbers: dict[str, int] = {}  # of arrays, by content

    def put(values: Any) -> Any:
        if not np.ndim(values):
            return float(values)
        step = float(values[-1] - values[0]) / max(len(values) - 1, 1)
        if len(values) > 2 and step and np.allclose(np.diff(values), step, _EVEN, 0.0):
            return {"start": float(values[0]), "step": step, "count": len(values)}
        content = base64.b64encode(values.astype("<f4").tobytes()).decode("ascii")
        return numbers.setdefault(content, len(numbers))

    listed = []
    for plot in plots:
        panels = (replace(p, series=tuple(map(_thinned_series, p.series))) for p in plot.panels)
        listed.append(msgspec.to_builtins(replace(plot, panels=tuple(panels)), enc_hook=put))
    return {"arrays": list(numbers), "plots": [{**plot, "shade": SHADED} for plot in listed]}


def _thinned_series(series: PlotSeries) -> PlotSeries:
    """No more points than a page can show."""
    if len(series.x) <= _MOST_POINTS or series.low is not None:
        return series
    every = -(-len(series.x) // _MOST_POINTS)
    x, y = (
        thinned(series.x, series.y, _MOST_POINTS)
        if series.kind == "line"
        else (series.x[::every], series.y[::every])
    )
    return replace(series, x=x, y=y)


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
    places = [
        sorted((start + part.argmin(), start + part.argmax()))
        for start in starts
        for part in [y[start : start + length]]
    ]
    halves = (starts[:, None] + np.array([0.25, 0.75]) * length).ravel()
    step = (x[-1] - x[0]) / (len(x) - 1)
    return x[0] + step * halves, y[np.array(places).ravel()]


def figures_html(plots: Mapping[int, Mapping[str, Plot | Missing]], names: Sequence[str]) -> str:
    """The figures of all records, and those of each, of which the reader chooses one."""
    if len(plots) == 1:
        return _figures(plots[0])
    options = "".join(
        f'<option value="{i}">{i}: {escape(name)}</option>' for i, name in enumerate(names, 1)
    )
    picker = (
        '<p class="note record-picker" hidden><label>Figures of record '
        f'<select id="record-picker">{options}</select></label></p>'
    )
    of_each = "".join(_figures(of_one, record=i) for i, of_one in plots.items() if i)
    return f"{picker}{of_each}{_figures(plots[0])}"


def _figures(plots: Mapping[str, Plot | Missing], record: int = 0) -> str:
    """Figures; those of a record by itself have its number in their names."""
    of, suffix = (f' data-record="{record}"', f"-{record}") if record else ("", "")
    plots = {name.removesuffix(suffix): plot for name, plot in plots.items()}
    kinds = {name: type(plot) for name, plot in plots.items()}
    # Where one of a pair cannot be drawn, the other takes the whole width.
    halves = {name for pair in _PAIRS if len({kinds.get(n) for n in pair}) == 1 for name in pair}
    return "".join(_figure(name, plot, of, half=name in halves) for name, plot in plots.items())


def _figure(name: str, plot: Plot | Missing, of: str, *, half: bool) -> str:
    wide = (' class="half"' if half else "") + of
    heading = TITLES[name] if isinstance(plot, Missing) else plot.title
    title = f'<div class="figure-head"><h3>{escape(heading)}</h3></div>'
    if isinstance(plot, Missing):
        return f'<figure{wide}>{title}<p class="none">{prose_html(f"None: {plot}")}</p></figure>'
    return (
        f'<figure{wide} id="figure-{plot.name}">{title}'
        f'<div class="plot" id="plot-{plot.name}" aria-label="{escape(plot.title)}"></div>'
        f"<figcaption>{prose_html(plot.caption)}</figcaption></figure>"
    )
