"""Results over time, by axis and machine, as a table and as plain data."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import Checked
from axisid.fleets import FleetRow
from axisid.populations import Drift
from axisid.presentation.blocks import Document, plain_text
from axisid.presentation.html import blocks_html
from axisid.support.errors import DataError, UsageError
from axisid.support.files.csv_text import csv_text
from axisid.support.files.json_text import json_text
from axisid.support.files.regular_file import write_file
from axisid.support.mappings import grouped
from axisid.support.missing import Missing
from axisid.support.quoting import quoted

from .document import trend_document, trend_page
from .gathering import Saved, place_of, points_of
from .series import Chart, Series, chart_of

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


@dataclass(frozen=True, kw_only=True)
class Trend(Checked):
    """Series of results, each of one axis.

    Attributes
    ----------
    series : tuple of Series
    by : str
        The condition that orders them; empty for the order in which they were given.
    notes : tuple of str
        What was left out.
    """

    series: tuple[Series, ...]
    by: str = ""
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.summary()

    @property
    def checks(self) -> tuple[Check, ...]:
        """Of all series, each of which has its own."""
        return tuple(check for each in self.series for check in each.checks)

    @property
    def changed(self) -> tuple[Series, ...]:
        """The series in which a step or a drift is told."""
        return tuple(each for each in self.series if each.has_changed)

    @property
    def beyond(self) -> tuple[Series, ...]:
        """The series in which a result is beyond its limits."""
        return tuple(each for each in self.series if each.has_beyond)

    def document(self) -> Document:
        """What there is to say, in blocks."""
        return trend_document(self.series, self.by, self.notes)

    def summary(self) -> str:
        """The same as text."""
        return plain_text(self.document())

    def _repr_html_(self) -> str:
        """For notebooks."""
        return blocks_html(self.document())

    def to_dict(self) -> dict[str, object]:
        """The same as plain data."""
        return trend_dict(self.series, self.by, self.notes)

    def write(self, file: str | Path) -> Path:
        """Write the trend, whole or not at all.

        Parameters
        ----------
        file : str or Path
            Ends in ``.csv`` for a row for each value, ``.html`` for a page with figures, ``.json``.

        Returns
        -------
        Path

        Raises
        ------
        UsageError
            The ending is another one, or the place cannot be written to.
        """
        path = Path(file)
        writers: dict[str, Callable[[], str]] = {
            ".csv": partial(trend_csv, self.series),
            ".html": partial(trend_page, self.series, self.by, self.document()),
            ".json": lambda: json_text(self.to_dict()),
        }
        if path.suffix not in writers:
            raise UsageError(
                f"the trend cannot be written to {path}; give a name that ends in "
                f"{', '.join(writers)}.",
                code="trend",
            )
        return write_file(path, writers[path.suffix]())


def trend(
    results: str | Path | Saved | Iterable[str | Path | Saved],
    *,
    by: str | None = None,
    method: str | None = None,
    count_failing: bool = False,
) -> Trend:
    """Follow the parameters of axes over their results.

    Results of one axis and one serial number are a series. Limits are from the results' own
    deviations and the scatter between them; a result beyond them, and a level that steps or drifts,
    are told, each at a level that holds for the whole series.

    Parameters
    ----------
    results : path, result of `load_result` or iterable of them
        Files, and folders of files, that ``axisid identify --json``, ``fit --json`` or `fleet`
        wrote, in the order of their names; in a folder of a fleet its manifest's serial numbers and
        conditions are known.
    by : str, optional
        Condition that orders them, a number or a date; by default they are in order.
    method : str, optional
        Whose estimates are taken; by default each result's judged one. Of a fit ``fit:control``,
        by what it fitted.
    count_failing : bool
        Whether results whose verdict fails set limits and tell changes like the others.

    Returns
    -------
    Trend

    Raises
    ------
    UsageError
        There is no result, or one has no such condition or method.
    DataError
        A file is no result, or results of a series have a parameter in several units.
    """
    points, notes = points_of(results, method)
    found = grouped(((each.axis, each.serial, tuple(each.parameters)), each) for each in points)
    for each in found.values():
        _check_units(each)
    series = [
        _series(axis, serial, each, by, count_failing=count_failing)
        for (axis, serial, _), each in found.items()
    ]
    return Trend(series=tuple(series), by=by or "", notes=tuple(notes))


def _check_units(points: list[FleetRow]) -> None:
    """Refuse values of one parameter in several units, which no chart can hold together."""
    first = points[0]
    for point in points:
        for name, value in point.parameters.items():
            if value.unit != first.parameters[name].unit:
                raise DataError(
                    f"{name} of {first.axis} is in {quoted(first.parameters[name].unit)} in "
                    f"{first.name} and in {quoted(value.unit)} in {point.name}; give results in "
                    "one unit, or follow each by itself.",
                    code="trend",
                )


def _series(
    axis: str, serial: str, points: list[FleetRow], by: str | None, *, count_failing: bool
) -> Series:
    places = [float(i) for i in range(1, len(points) + 1)]
    if by is not None:
        found = sorted(((place_of(p, by), i) for i, p in enumerate(points)))
        points, places = [points[i] for _, i in found], [place for place, _ in found]
    names = tuple(points[0].parameters)
    set_aside = tuple(
        i
        for i, point in enumerate(points)
        if not point.is_comparable or (point.failing and not count_failing)
    )
    return Series(
        axis=axis,
        serial=serial,
        points=tuple(points),
        places=tuple(places),
        charts=tuple(chart_of(name, points, places, len(names), set_aside) for name in names),
        set_aside=set_aside,
    )
