"""Results over time, by axis and machine, as a table and as plain data."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from axisid.estimation.diagnostic_checks import Check, Checked
from axisid.presentation.documents import Document
from axisid.support.errors import DataError, Missing, quoted
from axisid.support.files import csv_text, json_text, write_by_ending
from axisid.support.mappings import grouped
from axisid.support.presentable import Shown

from .gathering import Saved, place_of, points_of
from .ledger import FleetRow
from .series import Chart, Series, chart_of
from .trend_document import trend_document, trend_page

_COLUMNS = (
    *("axis", "serial", "result", "place", "method", "parameter", "unit", "value", "sd", "low"),
    *("high", "centre", "lower_limit", "upper_limit", "beyond", "step", "drift"),
)


def _csv(series: Sequence[Series]) -> str:
    """A row for each value of each result."""
    rows: list[Iterable[object]] = [_COLUMNS]
    for each in series:
        for chart in each.charts:
            steps = {step.place: step.difference for step in chart.steps}
            drift = "" if chart.drift is None else chart.drift.slope
            figures = [chart.values, chart.deviations, chart.low, chart.high]
            if not isinstance(chart.limits, Missing):
                figures += [chart.limits.centre, chart.limits.lower, chart.limits.upper]
            unknown = [""] * (3 * isinstance(chart.limits, Missing))
            name = (chart.parameter, chart.unit)
            rows += (
                (
                    *(each.axis, each.serial, point.name, place, point.method, *name),
                    *(*told, *unknown, int(i in chart.beyond), steps.get(i, ""), drift),
                )
                for i, (point, place, told) in enumerate(
                    zip(each.points, each.places, np.column_stack(figures).tolist(), strict=True)
                )
            )
    return csv_text(rows)


def _chart_dict(chart: Chart) -> dict[str, object]:
    limits, drift = chart.limits, chart.drift
    known = None if isinstance(limits, Missing) else limits
    return {
        "unit": chart.unit,
        "values": chart.values.tolist(),
        "sd": chart.deviations.tolist(),
        "interval_95": np.column_stack([chart.low, chart.high]).tolist(),
        "centre": None if known is None else known.centre.tolist(),
        "sd_between": None if known is None else known.between,
        "limits": known and np.column_stack([known.lower, known.upper]).tolist(),
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
        "drift": drift and {"slope": drift.slope, "sd": drift.deviation, "p_value": drift.p_value},
    }


@dataclass(frozen=True, kw_only=True)
class Trend(Checked, Shown):
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

    def to_dict(self) -> dict[str, object]:
        """The same as plain data."""
        return {
            "schema": "axisid.trend/1",
            "by": self.by,
            "notes": list(self.notes),
            "series": [
                {
                    "axis": each.axis,
                    "serial": each.serial,
                    "results": [point.name for point in each.points],
                    "failing": [list(point.failing) for point in each.points],
                    "places": list(each.places),
                    "parameters": {c.parameter: _chart_dict(c) for c in each.charts},
                }
                for each in self.series
            ],
        }

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
        writers = {
            ".csv": lambda: _csv(self.series),
            ".html": lambda: trend_page(self.series, self.by, self.document()),
            ".json": lambda: json_text(self.to_dict()),
        }
        refused = f"the trend cannot be written to {Path(file)}"
        return write_by_ending(Path(file), writers, refused, "trend")


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
    series = [_series(each, by, count_failing=count_failing) for each in found.values()]
    return Trend(series=tuple(series), by=by or "", notes=tuple(notes))


def _series(points: list[FleetRow], by: str | None, *, count_failing: bool) -> Series:
    """The results of one axis and machine in their order; in several units no chart holds them."""
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
    places = [float(i) for i in range(1, len(points) + 1)]
    if by is not None:
        found = sorted(((place_of(p, by), i) for i, p in enumerate(points)))
        points, places = [points[i] for _, i in found], [place for place, _ in found]
    set_aside = tuple(
        i
        for i, point in enumerate(points)
        if not point.is_comparable or (point.failing and not count_failing)
    )
    names = tuple(first.parameters)
    return Series(
        axis=first.axis,
        serial=first.serial,
        points=tuple(points),
        places=tuple(places),
        charts=tuple(chart_of(name, points, places, len(names), set_aside) for name in names),
        set_aside=set_aside,
    )
