"""What a series does over time: nothing, steps, or a drift."""

from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array, Exact

from .robust_centre import LARGEST

_ORDERS = 999  # orders in which the values might have come as well
_SEED = 0  # the same series gives the same numbers
_SHORTEST = 3  # values of a level
_SHORTER = np.sqrt(2.0)  # from a length of stretches to the next


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A step of a series' level.

    Attributes
    ----------
    place : int
        Of the first value on the new level, from 0.
    difference, deviation : float
        Of the new level and the one before.
    p_value : float
        Of a step as large somewhere in the series, if its order told nothing.
    """

    place: int
    difference: float
    deviation: float
    p_value: float


def _largest_step(values: Array, variances: Array) -> tuple[int, float] | None:
    """Place and probability of the largest step; too few values have none.

    It is held against those of the same values in other orders.
    """
    if len(values) < 2 * _SHORTEST:
        return None
    weights = 1 / _total_variances(values, variances)
    orders = _orders(len(values))
    sizes, places = _largest(values[orders], weights[orders])
    return int(places[0]), float(np.mean(sizes >= sizes[0]))


def _places(
    values: Array, variances: Array, level: float, first: int, largest: tuple[int, float]
) -> list[tuple[int, float]]:
    """Where the level changes, on either side of the largest step too, and the probability."""
    place, p_value = largest
    changes = [(first + place, p_value)]
    for begin, side in ((first, slice(None, place)), (first + place, slice(place, None))):
        inner = _largest_step(values[side], variances[side])
        if inner is not None and inner[1] <= level:
            changes += _places(values[side], variances[side], level, begin, inner)
    return changes


def _orders(count: int) -> NDArray[np.intp]:
    """The order of so many values, and others in which they might have come as well, (k, n)."""
    given = np.arange(count)
    rng = np.random.default_rng(_SEED)
    return np.vstack([given, rng.permuted(np.tile(given, (_ORDERS, 1)), axis=1)])


def _total_variances(values: Array, variances: Array) -> Array:
    """Variance of each value about one level: its own and what is between them."""
    between = max(float(np.var(values, ddof=1) - np.mean(variances)), 0.0)
    return variances + between


def _largest(values: Array, weights: Array) -> tuple[Array, NDArray[np.intp]]:
    """Of each of several series, (s, n), the largest squared step in deviations, and its place.

    It is looked for in stretches of many lengths, so that a step back does not hide it [1]_.

    .. [1] S. Kovacs, P. Buehlmann, H. Li, A. Munk, "Seeded binary segmentation: a general
       methodology for fast and optimal changepoint detection", Biometrika 110 (1), 2023.
    """
    sums = np.cumsum(np.pad(weights * values, ((0, 0), (1, 0))), axis=1)
    weight = np.cumsum(np.pad(weights, ((0, 0), (1, 0))), axis=1)
    best = np.full(len(values), -np.inf)
    places = np.zeros(len(values), dtype=np.intp)
    count = values.shape[1]
    # All of it, then ever shorter ones that overlap by half and more.
    stretches, length = [(0, count)], count / _SHORTER
    while length >= 2 * _SHORTEST:
        starts = np.linspace(0, count - length, 2 * int(np.ceil(count / length)) - 1)
        stretches += [(int(start), int(np.ceil(start + length))) for start in starts]
        length /= _SHORTER
    for start, stop in stretches:
        inner = slice(start + _SHORTEST, stop - _SHORTEST + 1)
        before, of_before = (x[:, inner] - x[:, [start]] for x in (sums, weight))
        after, of_after = (x[:, [stop]] - x[:, inner] for x in (sums, weight))
        sizes = (after / of_after - before / of_before) ** 2 / (1 / of_before + 1 / of_after)
        largest = sizes.max(axis=1)
        places = np.where(largest > best, sizes.argmax(axis=1) + inner.start, places)
        best = np.maximum(best, largest)
    return best, places


def _step(
    values: Array, variances: Array, first: int, place: int, last: int, p_value: float
) -> Step:
    """The step between two levels."""
    parts = (slice(first, place), slice(place, last))
    weights = [1 / _total_variances(values[part], variances[part]) for part in parts]
    before, after = (
        float(np.average(values[part], weights=each))
        for part, each in zip(parts, weights, strict=True)
    )
    deviation = float(np.sqrt(sum(1 / np.sum(each) for each in weights)))
    return Step(place=place, difference=after - before, deviation=deviation, p_value=p_value)


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
    largest = _largest_step(values, variances)
    if largest is None:
        return Change()
    drift = _drift(values, variances, places)
    looks = [largest[1], *([] if drift is None else [drift.p_value])]
    chance = len(looks) * min(looks)
    if chance > level:
        return Change()
    step = (largest[0], min(largest[1], chance))
    changes = sorted(_places(values, variances, level, 0, step))
    bounds = [0, *(place for place, _ in changes), len(values)]
    steps = tuple(
        _step(values, variances, first, place, last, p_value)
        for first, (place, p_value), last in zip(bounds, changes, bounds[2:], strict=False)
    )
    # A column for each level; a step's place is chosen as well as its size.
    number = np.searchsorted(bounds[1:-1], np.arange(len(values)), side="right")
    levels = np.asarray(np.eye(len(steps) + 1)[number])
    models = [
        (_criterion(values, variances, np.ones((len(values), 1)), 0), Change()),
        (_criterion(values, variances, levels, len(steps)), Change(steps=steps)),
    ]
    if drift is not None:
        drift = replace(drift, p_value=min(drift.p_value, chance))
        models.append((_criterion(values, variances, _straight(places), 0), Change(drift=drift)))
    return min(models, key=itemgetter(0))[1]


def _straight(places: Array) -> Array:
    """Columns of a line, (n, 2)."""
    centred = places - places.mean()
    return np.column_stack([np.ones(len(places)), centred / np.ptp(centred)])


def _drift(values: Array, variances: Array, places: Array) -> Drift | None:
    """The line through the values, its slope held against that of other orders; none of a point."""
    reach = float(np.ptp(places))
    if reach * LARGEST < 1:
        return None
    # So that no unit of the places decides whether their squares are numbers.
    places = (places - places.mean()) / reach
    orders = _orders(len(values))
    weights = (1 / _total_variances(values, variances))[orders]
    total = weights.sum(axis=1, keepdims=True)
    away = places - (weights * places).sum(axis=1, keepdims=True) / total
    along = (weights * away * values[orders]).sum(axis=1)
    squared = along**2 / (weights * away**2).sum(axis=1)  # slopes in deviations
    columns = _straight(places)
    # The likeliest scatter about a line is less than that about the true one.
    dof = len(values) - columns.shape[1]
    total_variances = variances + _between(values, variances, columns) * (len(values) / dof)
    coefficients, covariance = _fitted(values, total_variances, columns)
    return Drift(
        slope=float(coefficients[1] / reach),
        deviation=float(np.sqrt(covariance[1, 1]) / reach),
        p_value=float(np.mean(squared >= squared[0])),
        line=columns @ coefficients,
    )


def _fitted(values: Array, variances: Array, columns: Array) -> tuple[Array, Array]:
    """Weighted least squares: coefficients and their covariance."""
    weighted = columns / variances[:, None]
    covariance = np.asarray(np.linalg.inv(columns.T @ weighted), dtype=float)
    return covariance @ (weighted.T @ values), covariance


def _criterion(values: Array, variances: Array, columns: Array, chosen: int) -> float:
    """Schwarz's criterion of a level by columns, the scatter between values as likely as can be."""
    between = _between(values, variances, columns)
    penalty: float = (columns.shape[1] + chosen + 1) * np.log(len(values))
    return _misfit(between, values, variances, columns) + penalty


def _between(values: Array, variances: Array, columns: Array) -> float:
    """The scatter between true values that is the most likely, as a variance."""
    from scipy.optimize import minimize_scalar

    most = float(np.var(values)) or 1.0
    minimum = minimize_scalar(
        lambda share: _misfit(share * most, values, variances, columns),
        bounds=(0.0, 1.0),
        method="bounded",
    )
    return float(minimum.x) * most


def _misfit(between: float, values: Array, variances: Array, columns: Array) -> float:
    """Twice the negative logarithm of the likelihood, but for what is the same for all."""
    each = variances + between
    coefficients, _ = _fitted(values, each, columns)
    return float(np.sum(np.log(each) + (values - columns @ coefficients) ** 2 / each))
