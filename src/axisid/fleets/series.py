"""Results of one axis and one machine, with the limits, steps and drift of each parameter."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.thresholds import TREND_LEVEL
from axisid.estimation.verdict_checks import Check, Checked
from axisid.support.arrays import Array, Exact
from axisid.support.mappings import grouped
from axisid.support.missing import Missing
from axisid.support.wording import first_of

from .ledger import FleetRow, unchecked_of
from .robust_statistics import Drift, Step, change_in, detect_outliers, prediction_limit

_MIN_SERIES = 5  # results; with fewer, limits would be about ten standard deviations wide

_ROUNDING = 1e-12  # relative to the values; smaller scatter is due to arithmetic alone


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Limits(Exact):
    """Control limits of a parameter, for a constant or a drifting level.

    Attributes
    ----------
    centre : array, (n,)
        Centre for each result; the same for all results, unless the parameter drifts.
    between : float
        Standard deviation between the true values of the results that give the limits.
    lower, upper : array, (n,)
        Limits of each result, from its standard error, the standard deviation between true values
        and the uncertainty of this standard deviation.
    """

    centre: Array
    between: float
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chart(Exact):
    """Control chart of one parameter over the n results of a series.

    Attributes
    ----------
    parameter, unit : str
    values, deviations : array, (n,)
        Values and their standard errors.
    low, high : array, (n,)
        95 % intervals.
    limits : Limits or Missing
        Control limits; Missing, with the reason, if there are too few results or all are equal.
    beyond : tuple of int
        Indices of the results beyond their limits.
    steps : tuple of Step
    drift : Drift or None
        Drift, if a line describes the results better than steps; otherwise None.
    """

    parameter: str
    unit: str
    values: Array
    deviations: Array
    low: Array
    high: Array
    limits: Limits | Missing
    beyond: tuple[int, ...]
    steps: tuple[Step, ...]
    drift: Drift | None

    @property
    def has_changed(self) -> bool:
        """Return True if a step or a drift is reported; results beyond limits do not count."""
        return bool(self.steps) or self.drift is not None


def chart_of(
    parameter: str,
    points: Sequence[FleetRow],
    places: Sequence[float],
    parameters: int,
    set_aside: Sequence[int] = (),
) -> Chart:
    """Return the control chart of a parameter.

    Steps and a drift are searched first. The limits follow from the results before the first step.

    Parameters
    ----------
    parameter : str
    points : sequence of FleetRow
        Results in their order.
    places : sequence of float
        Place of each result on the axis of the chart: its number, or the condition that orders the
        results.
    parameters : int
        Number of parameters of the series. The significance level is divided by it.
    set_aside : sequence of int
        Indices of results that are excluded from limits and changes.
    """
    estimates = [point.parameters[parameter] for point in points]
    values, deviations = (np.array([getattr(v, n) for v in estimates]) for n in ("value", "sd"))
    level = TREND_LEVEL.value / parameters
    counted = np.setdiff1d(np.arange(len(points)), np.array(set_aside, dtype=np.intp))
    steps, drift = change_in(
        values[counted], deviations[counted] ** 2, np.array(places)[counted], level
    )
    # Steps and drift of the counted results, converted to indices and places of all results.
    steps = tuple(replace(step, place=int(counted[step.place])) for step in steps)
    line = np.zeros(len(points))
    if drift is not None:
        line = drift.line[0] + drift.slope * (np.array(places) - places[counted[0]])
        drift = replace(drift, line=line)
    before = counted[counted < steps[0].place] if steps else counted
    limits, beyond = _limits(values, deviations, line, before, level)
    return Chart(
        parameter=parameter,
        unit=estimates[0].unit,
        values=values,
        deviations=deviations,
        low=np.array([v.interval_95[0] for v in estimates]),
        high=np.array([v.interval_95[1] for v in estimates]),
        limits=limits,
        beyond=beyond,
        steps=steps,
        drift=drift,
    )


def _limits(
    values: Array, deviations: Array, line: Array, before: NDArray[np.intp], level: float
) -> tuple[Limits | Missing, tuple[int, ...]]:
    """Return the control limits of all results, and the indices of the results beyond them.

    The limits are Missing if there are too few results, or all values are equal.

    Parameters
    ----------
    values, deviations : (n,) array
    line : (n,) array
        Change of the level by a drift at each result; 0 without a drift.
    before : array of int
        Indices of the results before the first step, which give the limits.
    level : float
        Significance level.
    """
    if len(before) < _MIN_SERIES:
        few = "1 result is" if len(before) == 1 else f"{len(before)} results are"
        reason = f"{few} too few for control limits; at least {_MIN_SERIES} are needed"
        return Missing(reason), ()
    variances, residuals = deviations**2, (values - line)[before]
    if np.ptp(residuals) <= _ROUNDING * np.max(np.abs(values[before])):
        return Missing("all values are equal"), ()
    detected = detect_outliers(residuals[:, None], variances[before, None, None], level)
    usual = detected.usual
    squared_distance = prediction_limit(level / len(values), usual.count, 1)
    spread = np.sqrt(squared_distance * (usual.between[0, 0] + variances))
    centre = usual.centre[0] + line
    lower, upper = centre - spread, centre + spread
    # Beyond the limits: outliers among the results before the first step, others by the limits.
    others = np.setdiff1d(np.arange(len(values)), before)
    outside = others[(values < lower)[others] | (values > upper)[others]]
    return (
        Limits(
            centre=centre,
            between=float(np.sqrt(usual.between[0, 0])),
            lower=lower,
            upper=upper,
        ),
        tuple(sorted({*before[list(detected.far)].tolist(), *outside.tolist()})),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Series(Checked):
    """Results of one axis and one machine, in order, with a control chart of each parameter.

    Attributes
    ----------
    axis, serial : str
        Name of the axis, and serial number of the machine, which is empty if it is not known.
    points : tuple of FleetRow
        The results.
    places : tuple of float
        Place of each result: the condition that orders the results (a date as days since
        1970-01-01), or its number from 1.
    charts : tuple of Chart
        The control chart of each parameter.
    set_aside : tuple of int
        Indices of results that are excluded from limits and changes.
    """

    axis: str
    serial: str
    points: tuple[FleetRow, ...]
    places: tuple[float, ...]
    charts: tuple[Chart, ...]
    set_aside: tuple[int, ...] = ()

    def origin(self, by: str) -> str:
        """Return the first date if the condition `by` is a date; otherwise an empty text."""
        first = self.points[0].conditions.get(by)
        return first if isinstance(first, str) else ""

    @property
    def title(self) -> str:
        """Return the name of the axis and the serial number."""
        return f"{self.axis} {self.serial}".strip()

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the checks of changes, of limits and of the verdicts of the results."""
        changed = ", ".join(chart.parameter for chart in self.charts if chart.has_changed)
        beyond = ", ".join(chart.parameter for chart in self.charts if chart.beyond)
        found = grouped((name, point.name) for point in self.points for name in point.failing)
        rows = (
            ("changes", changed and f"step or drift of {changed}", "no step and no drift"),
            ("limits", beyond and f"beyond the limits: {beyond}", "no result beyond the limits"),
        )
        of = f"{self.title}: "
        return (
            *(Check.unless(name, bad and of + bad, of + good) for name, bad, good in rows),
            *(
                Check.unless(name, f"{of}fails in {first_of(of_it)}")
                for name, of_it in found.items()
            ),
            *unchecked_of(self.points, of),
        )

    @property
    def has_changed(self) -> bool:
        """Return True if a step or a drift is reported for a parameter."""
        return any(chart.has_changed for chart in self.charts)

    @property
    def has_beyond(self) -> bool:
        """Return True if a result is beyond the limits of a parameter."""
        return any(chart.beyond for chart in self.charts)


def notable_first(series: Iterable[Series]) -> list[Series]:
    """Return series sorted: first with a change, then with results beyond limits, then others."""
    return sorted(series, key=lambda each: (not each.has_changed, not each.has_beyond))
