"""The figure of a series: every parameter with its limits."""

import numpy as np
from numpy.typing import NDArray

from axisid.populations import LARGEST
from axisid.presentation.plots import Panel, Plot, Series as Curve, Tone, labelled
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .chart import Chart
from .series import Series


def trend_plot(series: Series, by: str) -> Plot:
    """Values with their intervals over the results, the limits as a band, steps as marks."""
    steps = {step.place for chart in series.charts for step in chart.steps}
    origin = series.origin(by)
    places = np.array(series.places)
    if origin:
        places = places - places[0]
    whole = all(_drawn(chart).all() for chart in series.charts)
    caption = "Whiskers are 95 % intervals; a band is where results stay that are alike."
    left = " Values that are not finite, or too large to compare, are not drawn."
    return Plot(
        name="trend",
        title=series.title,
        caption=caption + ("" if whole else left),
        x_label=f"days from {origin}" if origin else by or "result",
        panels=tuple(_panel(chart, places) for chart in series.charts),
        marks=tuple((float(places[i]), series.points[i].name) for i in sorted(steps)),
        whole=not by,
    )


def _drawn(chart: Chart) -> NDArray[np.bool_]:
    """Which values an axis of a figure can hold."""
    ends = np.abs([chart.values, chart.low, chart.high])
    return np.asarray(np.all(ends < LARGEST, axis=0))


def _panel(chart: Chart, places: Array) -> Panel:
    beyond, drawn = np.isin(np.arange(len(places)), chart.beyond), _drawn(chart)
    curves = []
    if not isinstance(chart.limits, Missing):
        limits = chart.limits
        curves.append(
            Curve(
                label="centre and limits",
                x=places,
                y=limits.centre,
                low=limits.lower,
                high=limits.upper,
                tone="other",
            )
        )
    kinds: tuple[tuple[str, NDArray[np.bool_], Tone], ...] = (
        ("results", drawn & ~beyond, "model"),
        ("beyond the limits", drawn & beyond, "error"),
    )
    for label, kept, tone in kinds:
        if kept.any():
            curves.append(
                Curve(
                    label=label,
                    x=places[kept],
                    y=chart.values[kept],
                    low=chart.low[kept],
                    high=chart.high[kept],
                    kind="points",
                    tone=tone,
                )
            )
    return Panel(label=labelled(chart.parameter, chart.unit), series=tuple(curves))
