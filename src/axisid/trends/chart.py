"""One parameter over the results of a series: limits, what is beyond them, steps, a drift."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.thresholds.studies import MIN_SERIES, TREND_LEVEL
from axisid.populations import Change, Drift, Step, alike_points, change_in, limit_of_a_new_point
from axisid.support.arrays import Array, Exact
from axisid.support.missing import Missing

from .point import Point

_ROUNDING = 1e-12  # of the values: what they scatter by arithmetic alone


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Limits(Exact):
    """Between which a parameter stays that does not change.

    Attributes
    ----------
    centre : array, (n,)
        Of each result; the same for all, unless the parameter drifts.
    between : float
        Deviation between the true values of results that are alike.
    lower, upper : array, (n,)
        Of each result: its own deviation, the scatter and how well that is known.
    """

    centre: Array
    between: float
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chart(Exact):
    """A parameter over the results of a series.

    Attributes
    ----------
    parameter, unit : str
    values, deviations : array, (n,)
    low, high : array, (n,)
        95 % intervals.
    limits : Limits or Missing
    beyond : tuple of int
        Places of the results beyond their limits, from 0.
    steps : tuple of Step
    drift : Drift or None
        In place of steps, where a line describes the results better.
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
        """Whether a result is beyond its limits, or a step or a drift is told."""
        return bool(self.beyond or self.steps or self.drift is not None)


def chart_of(
    parameter: str, points: Sequence[Point], places: Sequence[float], parameters: int
) -> Chart:
    """The chart of a parameter.

    Parameters
    ----------
    parameter : str
    points : sequence of Point
        In their order.
    places : sequence of float
        Where each stands.
    parameters : int
        How many the series has, which share its level.
    """
    own = [point.parameters[parameter] for point in points]
    values, deviations = (np.array([getattr(v, n) for v in own]) for n in ("value", "deviation"))
    level = TREND_LEVEL.value / parameters
    change = change_in(values, deviations**2, np.array(places), level)
    limits, beyond = _limits(values, deviations, change, level)
    return Chart(
        parameter=parameter,
        unit=own[0].unit,
        values=values,
        deviations=deviations,
        low=np.array([v.interval[0] for v in own]),
        high=np.array([v.interval[1] for v in own]),
        limits=limits,
        beyond=beyond,
        steps=change.steps,
        drift=change.drift,
    )


def _limits(
    values: Array, deviations: Array, change: Change, level: float
) -> tuple[Limits | Missing, tuple[int, ...]]:
    """Limits for all from the results before the first step, about the line of a drift."""
    first = change.steps[0].place if change.steps else len(values)
    least = int(MIN_SERIES.value)
    if first < least:
        few = "1 result tells" if first == 1 else f"{first} results tell"
        return Missing(f"{few} no limits; {least} or more do"), ()
    before = slice(0, first)
    variances = deviations**2
    line = np.zeros(len(values)) if change.drift is None else change.drift.line
    apart = (values - line)[before]
    if np.ptp(apart) <= _ROUNDING * np.max(np.abs(values)):
        return Missing("the values do not scatter"), ()
    found = alike_points(apart[:, None], variances[before, None, None], level)
    usual = found.usual
    each = limit_of_a_new_point(level / len(values), usual.count, 1)
    spread = np.sqrt(each * (usual.between[0, 0] + variances))
    centre = usual.centre[0] + line
    lower, upper = centre - spread, centre + spread
    after = np.arange(len(values)) >= first
    outside = after & ((values < lower) | (values > upper))
    limits = Limits(
        centre=centre,
        between=float(np.sqrt(usual.between[0, 0])),
        lower=lower,
        upper=upper,
    )
    return limits, tuple(sorted({*found.far, *map(int, np.flatnonzero(outside))}))
