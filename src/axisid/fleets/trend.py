"""Trends of parameters: results collected by axis and machine, as a table and as plain data."""

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
from msgspec import structs
from scipy.special import ndtri

from axisid.estimation.choices import FIT
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.estimation.verdict_checks import Check, Checked
from axisid.presentation.documents import Document
from axisid.presentation.result_files import SavedIdentification, SavedOutputFit, load_result
from axisid.support.errors import DataError, UsageError
from axisid.support.files import csv_text, json_text, kinds_of, write_by_ending
from axisid.support.mappings import grouped
from axisid.support.missing import Missing
from axisid.support.presentable import Shown
from axisid.support.wording import first_of, quoted

from .ledger import LEDGER, FleetRow, Ledger, fleet_value, read_ledger
from .robust_statistics import LARGEST
from .series import Chart, Series, chart_of
from .trend_document import trend_document, trend_page

#: Function that returns the ledger of a folder, which is the table of its logs and results.
Ledgers: TypeAlias = Callable[[Path], Ledger]
#: Results that can form a trend.
Saved: TypeAlias = SavedIdentification | SavedOutputFit

_DAY = 86_400.0  # s


def _point_of(saved: Saved, row: FleetRow | None, method: str | None) -> FleetRow:
    """Return a result as a row of a fleet, with log, serial number and conditions of the ledger.

    For a fit the method is ``fit:`` plus the fitted outputs, and the parameters are those that were
    fitted and have a standard error.

    Parameters
    ----------
    saved : SavedIdentification or SavedOutputFit
    row : FleetRow or None
        Row of the result in the ledger of its folder; None if there is none.
    method : str or None
        Method whose estimates are used; None for the method that the verdict judges.
    """
    if isinstance(saved, SavedOutputFit):
        own = f"{FIT}{saved.output.replace(' and ', ',')}"
        if method not in (None, own):
            raise UsageError(
                f"{saved.file} is the result of a fit, whose method is {own}, not "
                f"{quoted(method)}. Omit this file.",
                code="trend",
            )
        parameters = {}
        for name, saved_value in saved.document.parameters.items():
            value = fleet_value(saved.parameters[name])
            if saved_value.at_bound:  # the 95 % interval is one-sided and gives the standard error
                low, high = value.interval_95
                value = structs.replace(value, sd=float((high - low) / ndtri(INTERVAL_LEVEL.value)))
            if not saved_value.fixed and math.isfinite(value.sd):
                parameters[name] = value
    else:
        estimate = saved.preferred if method is None else saved[method]
        own = estimate.method
        parameters = {n: fleet_value(value) for n, value in estimate.parameters.items()}
    return FleetRow(
        name=Path(saved.file).stem,
        log="" if row is None else row.log,
        axis=saved.name,
        status="ok",
        serial="" if row is None else row.serial,
        conditions={} if row is None else row.conditions,
        method=own,
        parameters=parameters,
        failing=tuple(check.name for check in saved.document.verdict if check.status == "fail"),
        unchecked=tuple(check.name for check in saved.document.verdict if check.leaves_open),
        signature=saved.document.signature,
    )


def place_of(point: FleetRow, by: str) -> float:
    """Return the condition `by` of a result as a number; a date as days since 1970-01-01.

    Raises
    ------
    UsageError
        The result does not have the condition, or the condition is too large, or neither a number
        nor a date.
    """
    if by not in point.conditions:
        known = ", ".join(point.conditions) or "none"
        raise UsageError(
            f"the condition {quoted(by)} of {point.name} is not known. Known conditions of this "
            f"result: {known}. Conditions are columns of a fleet's manifest and are stored in "
            "fleet.jsonl next to the results. Copy fleet.jsonl together with the results.",
            code="trend",
        )
    condition = point.conditions[by]
    if isinstance(condition, str):
        try:
            date = datetime.fromisoformat(condition)
            # A date without a zone is UTC, so that the number does not depend on the machine.
            return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp() / _DAY
        except ValueError:
            condition = None
    if condition is None or not abs(condition) < LARGEST:
        raise UsageError(
            f"the {by} of {point.name} is {quoted(point.conditions[by])}. Give numbers below "
            f"{LARGEST:g}, or dates such as 2026-03-01.",
            code="trend",
        )
    return float(condition)


def points_of(results: object, method: str | None) -> tuple[list[FleetRow], list[str]]:
    """Return results as rows of a fleet, in the given order, and notes on omitted results.

    Parameters
    ----------
    results : object
        Files, folders or loaded results.
    method : str or None
        Method whose estimates are used; None for the method that the verdict judges.

    Raises
    ------
    UsageError
        There is no result, an argument is not a result, or a result does not have the method.
    DataError
        A file cannot be read, or is not a result.
    """
    several = [results] if isinstance(results, (str, Path, Saved)) else results
    if not isinstance(several, Iterable):
        raise UsageError(f"the results are {quoted(results)}. Give files, or folders of files.")
    given = list(several)
    ledgers: Ledgers = cache(read_ledger)  # the ledger of a folder is read once
    every = [saved for each in given for saved in _saved(each, ledgers)]
    files = Counter(Path(saved.file).resolve() for saved in every)
    if twice := [file for file, times in files.items() if times > 1]:
        raise UsageError(  # a repeated result would change limits and hide steps
            f"{quoted(str(twice[0]))} is given {files[twice[0]]} times. Give each result once.",
            code="trend",
        )
    found = [
        _point_of(saved, ledgers(file.parent).results.get(file.stem), method)
        for saved in every
        for file in [Path(saved.file)]
    ]
    folders = [
        Path(each) for each in given if isinstance(each, (str, Path)) and os.path.isdir(each)
    ]
    notes = [note for each in folders for note in _notes_on(each, ledgers(each), {*files})]
    if not found:
        raise UsageError(
            " ".join(
                (
                    f"no result was found in {quoted(results)}. Give files that identify --json, "
                    "fit --json or a fleet wrote.",
                    *notes,
                )
            ),
            code="trend",
        )
    return found, notes


def _saved(given: object, ledgers: Ledgers) -> Iterator[Saved]:
    """Yield the results of an argument: a loaded result, a result file, or a folder of files."""
    if isinstance(given, Saved):
        yield given
        return
    if not isinstance(given, (str, Path)):
        raise UsageError(f"a result is {quoted(given)}. Give a file, a folder or load_result(...).")
    files = [given]
    if os.path.isdir(given):
        ledger = ledgers(Path(given))
        kept = last_results(ledger.results.values())
        # In the folder of a fleet, only results in its ledger are read.
        files = [f for f in sorted(Path(given).glob("*.json")) if not ledger.last or f.stem in kept]
    for file in files:
        found = load_result(file)
        if not isinstance(found, Saved):
            raise DataError(
                f"{file} is the result of a study, but a trend needs results of identify or fit. "
                "Omit this file.",
                code="trend",
            )
        yield found


def _notes_on(folder: Path, ledger: Ledger, named: set[Path]) -> Iterator[str]:
    """Yield sentences on results of a folder that are omitted, or whose log failed later.

    Parameters
    ----------
    folder : Path
    ledger : Ledger
        Ledger of the folder.
    named : set of Path
        Files of the results in use.
    """
    if not ledger.last and ledger.broken:
        yield f"{ledger.broken}, so serial numbers and conditions of the results are not known."
    kept = last_results(ledger.results.values())
    failed = [row.name for row in ledger.last.values() if not row.has_result]
    if earlier := [name for name in failed if name in kept]:
        of = "1 log" if len(earlier) == 1 else f"{len(earlier)} logs"
        yield (
            f"The last identification of {of} failed: {first_of(earlier)}. The trend shows the "
            "earlier results of these logs."
        )
    omitted = []
    for file in sorted(folder.glob("*.json")) if ledger.last else ():
        with suppress(OSError):
            is_unknown = file.stem not in ledger.results and file.resolve() not in named
            if is_unknown and kinds_of(file) & {"identify", "fit"}:
                omitted.append(file.stem)
    if omitted:
        of, them = "1 result is", "it"
        if len(omitted) > 1:
            of, them = f"{len(omitted)} results are", "them"
        why = f" {ledger.broken}." if ledger.broken else ""
        yield (
            f"{of} omitted, because {folder / LEDGER} has no line for {them}: {first_of(omitted)}."
            f"{why} Give the files by name, or identify the logs again with axisid fleet --resume."
        )


def last_results(rows: Iterable[FleetRow]) -> set[str]:
    """Return the names of the last results of each combination of log, axis and columns.

    A later identification that failed does not replace a result.
    """
    last = {
        (row.log, row.axis, *sorted(row.columns.items())): row for row in rows if row.has_result
    }
    return {row.name for row in last.values()}


_COLUMNS = (
    *("axis", "serial", "result", "place", "method", "parameter", "unit", "value", "sd", "low"),
    *("high", "centre", "lower_limit", "upper_limit", "beyond", "step", "drift"),
)


def _csv(series: Sequence[Series]) -> str:
    """Return series as CSV text, with one row for each parameter of each result."""
    rows: list[Iterable[object]] = [_COLUMNS]
    for each in series:
        for chart in each.charts:
            steps = {step.place: step.difference for step in chart.steps}
            drift = "" if chart.drift is None else chart.drift.slope
            # Columns of numbers; cells of missing limits are empty.
            columns = [chart.values, chart.deviations, chart.low, chart.high]
            no_limits = [""] * 3
            if not isinstance(chart.limits, Missing):
                columns += [chart.limits.centre, chart.limits.lower, chart.limits.upper]
                no_limits = []
            numbers = np.column_stack(columns).tolist()
            name = (chart.parameter, chart.unit)
            rows += (
                (
                    *(each.axis, each.serial, point.name, place, point.method, *name),
                    *(*cells, *no_limits, int(i in chart.beyond), steps.get(i, ""), drift),
                )
                for i, (point, place, cells) in enumerate(
                    zip(each.points, each.places, numbers, strict=True)
                )
            )
    return csv_text(rows)


def _chart_dict(chart: Chart) -> dict[str, object]:
    """Return the control chart of a parameter as plain data."""
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
    """Series of results over time, each of one axis and one machine.

    Attributes
    ----------
    series : tuple of Series
    by : str
        Condition that orders the results; empty for the order in which they were given.
    notes : tuple of str
        Sentences on omitted results.
    """

    series: tuple[Series, ...]
    by: str = ""
    notes: tuple[str, ...] = ()

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the checks of all series."""
        return tuple(check for each in self.series for check in each.checks)

    @property
    def changed(self) -> tuple[Series, ...]:
        """Return the series in which a step or a drift is reported."""
        return tuple(each for each in self.series if each.has_changed)

    @property
    def beyond(self) -> tuple[Series, ...]:
        """Return the series in which a result is beyond its limits."""
        return tuple(each for each in self.series if each.has_beyond)

    def document(self) -> Document:
        """Return the document of the trend, in blocks."""
        return trend_document(self.series, self.by, self.notes)

    def to_dict(self) -> dict[str, object]:
        """Return the trend as plain data."""
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
        """Write the trend to a file, completely or not at all, and return the file.

        Parameters
        ----------
        file : str or Path
            The ending of its name decides the format: ``.csv`` has a row for each parameter of each
            result, ``.html`` is a page with figures, ``.json`` is plain data.

        Returns
        -------
        Path

        Raises
        ------
        UsageError
            The ending is another one, or the file cannot be written.
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
    """Return the trend of the parameters of axes over their results.

    Results with the same axis, serial number and parameters form a series. Control limits follow
    from the standard errors of the results and the scatter between the results. Results beyond the
    limits, and a level that steps or drifts, are reported. The significance level of each test
    holds for the whole series.

    Parameters
    ----------
    results : path, result of `load_result` or iterable of them
        Files, and folders of files, that ``axisid identify --json``, ``fit --json`` or `fleet`
        wrote. The files of a folder are ordered by name. For a folder of a fleet the serial numbers
        and conditions of its manifest are known.
    by : str, optional
        Condition that orders the results, a number or a date; by default they keep the given order.
    method : str, optional
        Method whose estimates are used; by default the method that the verdict of each result
        judges. The method of a fit is ``fit:`` plus the fitted outputs, such as ``fit:control``.
    count_failing : bool
        True if results with a failed check are used for limits and changes too.

    Returns
    -------
    Trend

    Raises
    ------
    UsageError
        There is no result, or a result does not have the condition or the method.
    DataError
        A file is not a result, or a parameter has different units in the results of a series.
    """
    points, notes = points_of(results, method)
    found = grouped(((each.axis, each.serial, tuple(each.parameters)), each) for each in points)
    return Trend(
        series=tuple(_series(each, by, count_failing=count_failing) for each in found.values()),
        by=by or "",
        notes=tuple(notes),
    )


def _series(points: list[FleetRow], by: str | None, *, count_failing: bool) -> Series:
    """Return the results of one axis and machine in order, with limits and changes.

    Raises
    ------
    DataError
        A parameter has different units in the results.
    """
    first = points[0]
    for point in points:
        for name, value in point.parameters.items():
            if value.unit != first.parameters[name].unit:
                raise DataError(
                    f"{name} of {first.axis} has the unit {quoted(first.parameters[name].unit)} in "
                    f"{first.name} and {quoted(value.unit)} in {point.name}. Give results with the "
                    "same unit, or make a separate trend for each unit.",
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
