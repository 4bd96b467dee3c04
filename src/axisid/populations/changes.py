"""What a series does over time: nothing, steps, or a drift."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from axisid.support.arrays import Array, Exact

from .alike import LARGEST
from .steps import (
    Step,
    largest_step,
    other_orders,
    share_as_large,
    steps_beside,
    total_variances,
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drift(Exact):
    """A level that goes on changing.

    Attributes
    ----------
    slope, deviation : float
        In the values' unit for each unit of their places.
    p_value : float
        Of a slope as steep, if the order of the values told nothing.
    line : array, (n,)
        The level at each place.
    """

    slope: float
    deviation: float
    p_value: float
    line: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """What a series does; neither where nothing is told.

    Attributes
    ----------
    steps : tuple of Step
        In their order.
    drift : Drift or None
    """

    steps: tuple[Step, ...] = ()
    drift: Drift | None = None


def change_in(values: Array, variances: Array, places: Array, level: float) -> Change:
    """Tell whether a series changes, and whether by steps or by a drift.

    The largest step and the slope are held against those of the same values in other orders, which
    needs no distribution. Where one of the two is seldom as large, the information criterion tells
    which of nothing, a line and steps describes the values best [Schwarz1978]_; what it tells has
    the probability of both looks where its own is larger.

    Parameters
    ----------
    values, variances, places : array, (n,)
        Estimates in their order, the variance of each, and where each stands.
    level : float
        Probability that a change is told where there is none.
    """
    largest = largest_step(values, variances)
    if largest is None:
        return Change()
    drift = _drift(values, variances, places)
    looks = [largest.p_value, *([] if drift is None else [drift.p_value])]
    chance = len(looks) * min(looks)
    if chance > level:
        return Change()
    largest = replace(largest, p_value=min(largest.p_value, chance))
    steps = steps_beside(values, variances, level, largest)
    # A step's place is chosen as well as its size.
    by_steps = _criterion(values, variances, _levels(len(values), steps), len(steps))
    found = [
        (_criterion(values, variances, np.ones((len(values), 1)), 0), Change()),
        (by_steps, Change(steps=steps)),
    ]
    if drift is not None:
        drift = replace(drift, p_value=min(drift.p_value, chance))
        found.append((_criterion(values, variances, _straight(places), 0), Change(drift=drift)))
    return min(found, key=itemgetter(0))[1]


def _straight(places: Array) -> Array:
    """Columns of a line, (n, 2)."""
    away = places - places.mean()
    return np.column_stack([np.ones(len(places)), away / np.ptp(away)])


def _levels(count: int, steps: Sequence[Step]) -> Array:
    """A column for each level, (n, s + 1)."""
    number = np.searchsorted([step.place for step in steps], np.arange(count), side="right")
    return np.asarray(np.eye(len(steps) + 1)[number])


def _drift(values: Array, variances: Array, places: Array) -> Drift | None:
    """The line through the values, its slope held against that of other orders; none of a point."""
    reach = float(np.ptp(places))
    if reach * LARGEST < 1:
        return None
    # So that no unit of the places decides whether their squares are numbers.
    places = (places - places.mean()) / reach
    weights = 1 / total_variances(values, variances)
    orders = other_orders(len(values))
    own = float(_slopes(values[None], weights[None], places)[0])
    others = _slopes(values[orders], weights[orders], places)
    columns = _straight(places)
    # The likeliest scatter about a line is less than that about the true one.
    rest = len(values) / (len(values) - columns.shape[1])
    each = variances + _between(values, variances, columns) * rest
    coefficients, covariance = _fitted(values, each, columns)
    return Drift(
        slope=float(coefficients[1] / reach),
        deviation=float(np.sqrt(covariance[1, 1]) / reach),
        p_value=share_as_large(others, own),
        line=columns @ coefficients,
    )


def _slopes(values: Array, weights: Array, places: Array) -> Array:
    """Squared slopes in deviations of several series, (s, n)."""
    total = weights.sum(axis=1, keepdims=True)
    away = places - (weights * places).sum(axis=1, keepdims=True) / total
    along = (weights * away * values).sum(axis=1)
    return np.asarray(along**2 / (weights * away**2).sum(axis=1))


def _fitted(values: Array, variances: Array, columns: Array) -> tuple[Array, Array]:
    """Weighted least squares: coefficients and their covariance."""
    weighted = columns / variances[:, None]
    covariance = np.asarray(np.linalg.inv(columns.T @ weighted), dtype=float)
    return covariance @ (weighted.T @ values), covariance


def _criterion(values: Array, variances: Array, columns: Array, chosen: int) -> float:
    """Schwarz's criterion of a level by columns, the scatter between values as likely as can be."""
    between = _between(values, variances, columns)
    parameters = columns.shape[1] + chosen + 1
    penalty: float = parameters * np.log(len(values))
    return _misfit(between, values, variances, columns) + penalty


def _between(values: Array, variances: Array, columns: Array) -> float:
    """The scatter between true values that is the most likely, as a variance."""
    from scipy.optimize import minimize_scalar

    most = float(np.var(values)) or 1.0
    found = minimize_scalar(
        lambda share: _misfit(share * most, values, variances, columns),
        bounds=(0.0, 1.0),
        method="bounded",
    )
    return float(found.x) * most


def _misfit(between: float, values: Array, variances: Array, columns: Array) -> float:
    """Twice the negative logarithm of the likelihood, but for what is the same for all."""
    each = variances + between
    coefficients, _ = _fitted(values, each, columns)
    return float(np.sum(np.log(each) + (values - columns @ coefficients) ** 2 / each))
