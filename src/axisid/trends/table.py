"""A trend as a table and as plain data."""

from collections.abc import Sequence

from axisid.populations import Drift
from axisid.support.files.csv_text import csv_text
from axisid.support.missing import Missing

from .chart import Chart
from .series import Series

_COLUMNS = (
    *("axis", "serial", "result", "place", "method", "parameter", "unit", "value", "sd", "low"),
    *("high", "centre", "lower_limit", "upper_limit", "beyond", "step", "drift"),
)


def trend_csv(series: Sequence[Series]) -> str:
    """A row for each value of each result."""
    charts = [(each, chart) for each in series for chart in each.charts]
    return csv_text([_COLUMNS, *(row for of_one in charts for row in _rows(*of_one))])


def _rows(series: Series, chart: Chart) -> list[list[object]]:
    steps = {step.place: step.difference for step in chart.steps}
    return [
        [
            series.axis,
            series.serial,
            point.name,
            series.places[i],
            point.method,
            chart.parameter,
            chart.unit,
            float(chart.values[i]),
            float(chart.deviations[i]),
            float(chart.low[i]),
            float(chart.high[i]),
            *_limits(chart, i),
            int(i in chart.beyond),
            steps.get(i, ""),
            "" if chart.drift is None else chart.drift.slope,
        ]
        for i, point in enumerate(series.points)
    ]


def _limits(chart: Chart, place: int) -> tuple[object, object, object]:
    limits = chart.limits
    if isinstance(limits, Missing):
        return "", "", ""
    return float(limits.centre[place]), float(limits.lower[place]), float(limits.upper[place])


def trend_dict(series: Sequence[Series], by: str, notes: Sequence[str] = ()) -> dict[str, object]:
    """The trend as plain data."""
    return {
        "schema": "axisid.trend/1",
        "by": by,
        "notes": list(notes),
        "series": [_series_dict(each) for each in series],
    }


def _series_dict(series: Series) -> dict[str, object]:
    return {
        "axis": series.axis,
        "serial": series.serial,
        "results": [point.name for point in series.points],
        "failing": [list(point.failing) for point in series.points],
        "places": list(series.places),
        "parameters": {chart.parameter: _chart_dict(chart) for chart in series.charts},
    }


def _chart_dict(chart: Chart) -> dict[str, object]:
    limits = chart.limits
    known = None if isinstance(limits, Missing) else limits
    return {
        "unit": chart.unit,
        "values": chart.values.tolist(),
        "sd": chart.deviations.tolist(),
        "interval_95": [list(pair) for pair in zip(chart.low, chart.high, strict=True)],
        "centre": None if known is None else known.centre.tolist(),
        "sd_between": None if known is None else known.between,
        "limits": None
        if known is None
        else [list(pair) for pair in zip(known.lower.tolist(), known.upper.tolist(), strict=True)],
        "no_limits": limits.reason if isinstance(limits, Missing) else "",
        "beyond": list(chart.beyond),
        "steps": [
            {
                "place": step.place,
                "difference": step.difference,
                "sd": step.deviation,
                "p_value": step.p_value,
            }
            for step in chart.steps
        ],
        "drift": None if chart.drift is None else _drift_dict(chart.drift),
    }


def _drift_dict(drift: Drift) -> dict[str, float]:
    return {"slope": drift.slope, "sd": drift.deviation, "p_value": drift.p_value}
