"""One parameter over the results of a series: limits, what is beyond them, steps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.thresholds.studies import MIN_SERIES, TREND_LEVEL
from axisid.populations import Step, alike_points, limit_of_a_new_point, steps_in
from axisid.support.arrays import Array, frozen
from axisid.support.missing import Missing

from .point import Point


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Between which a parameter stays that does not change.

    Attributes
    ----------
    centre : float
    between : float
        Deviation between the true values of results that are alike.
    lower, upper : array, (n,)
        Of each result: its own deviation, the scatter and how well that is known.
    """

    centre: float
    between: float
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
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


def chart_of(parameter: str, points: Sequence[Point], parameters: int) -> Chart:
    """The chart of a parameter.

    Parameters
    ----------
    parameter : str
    points : sequence of Point
        In their order.
    parameters : int
        How many the series has, which share its level.
    """
    own = [point.parameters[parameter] for point in points]
    values, deviations = (np.array([getattr(v, n) for v in own]) for n in ("value", "deviation"))
    level = TREND_LEVEL.value / parameters
    steps = steps_in(values, deviations**2, level)
    limits, beyond = _limits(values, deviations, steps, level)
    return Chart(
        parameter=parameter,
        unit=own[0].unit,
        values=frozen(values),
        deviations=frozen(deviations),
        low=frozen([v.interval[0] for v in own]),
        high=frozen([v.interval[1] for v in own]),
        limits=limits,
        beyond=beyond,
        steps=steps,
    )


def _limits(
    values: Array, deviations: Array, steps: Sequence[Step], level: float
) -> tuple[Limits | Missing, tuple[int, ...]]:
    """Limits from the results before the first step that is long enough after, for all."""
    first = steps[0].place if steps else len(values)
    least = int(MIN_SERIES.value)
    if first < least:
        return Missing(f"{first} results tell no limits; {least} or more do"), ()
    before = slice(0, first)
    if not np.ptp(values[before]):
        return Missing("the values are all the same"), ()
    variances = deviations**2
    found = alike_points(values[before, None], variances[before, None, None], level)
    usual = found.usual
    each = limit_of_a_new_point(level / len(values), usual.count, 1)
    spread = np.sqrt(each * (usual.between[0, 0] + variances))
    centre = float(usual.centre[0])
    lower, upper = centre - spread, centre + spread
    after = np.arange(len(values)) >= first
    outside = after & ((values < lower) | (values > upper))
    limits = Limits(
        centre=centre,
        between=float(np.sqrt(usual.between[0, 0])),
        lower=frozen(lower),
        upper=frozen(upper),
    )
    return limits, tuple(sorted({*found.far, *map(int, np.flatnonzero(outside))}))
