"""Steps in a series: where its level is another one from then on."""

from dataclasses import dataclass

import numpy as np

from axisid.support.arrays import Array

_ORDERS = 1999  # orders in which the values might have come as well
_SEED = 0  # the same series gives the same numbers
_SHORTEST = 3  # values of a level


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


def steps_in(values: Array, variances: Array, level: float) -> tuple[Step, ...]:
    """Find the steps of a series, in their order.

    The largest step is held against those of the same values in other orders, which needs no
    distribution; then each side of it by itself.

    Parameters
    ----------
    values, variances : array, (n,)
        Estimates in their order, and the variance of each.
    level : float
        Probability that a step is told where there is none.
    """
    places = sorted(_places(values, variances, level, 0))
    bounds = [0, *(place for place, _ in places), len(values)]
    return tuple(
        _step(values, variances, first, place, last, p_value)
        for first, (place, p_value), last in zip(bounds, places, bounds[2:], strict=False)
    )


def _places(values: Array, variances: Array, level: float, first: int) -> list[tuple[int, float]]:
    """Where the level changes, with the probability of each by itself."""
    if len(values) < 2 * _SHORTEST:
        return []
    weights = 1 / _total(values, variances)
    sizes = _sizes(values[None], weights[None])[0]
    rng = np.random.default_rng(_SEED)
    orders = rng.permuted(np.tile(np.arange(len(values)), (_ORDERS, 1)), axis=1)
    others = _sizes(values[orders], weights[orders]).max(axis=1)
    p_value = (1 + np.count_nonzero(others >= sizes.max())) / (1 + _ORDERS)
    if p_value > level:
        return []
    place = int(np.argmax(sizes)) + _SHORTEST
    before = _places(values[:place], variances[:place], level, first)
    after = _places(values[place:], variances[place:], level, first + place)
    return [*before, (first + place, float(p_value)), *after]


def _total(values: Array, variances: Array) -> Array:
    """Variance of each value about one level: its own and what is between them."""
    between = max(float(np.var(values, ddof=1) - np.mean(variances)), 0.0)
    return variances + between


def _sizes(values: Array, weights: Array) -> Array:
    """Squared step in deviations, (s, n - 2 _SHORTEST + 1), at each place of series (s, n)."""
    sums = np.cumsum(weights * values, axis=1)
    weight = np.cumsum(weights, axis=1)
    inner = slice(_SHORTEST - 1, values.shape[1] - _SHORTEST)
    before, of_before = sums[:, inner], weight[:, inner]
    after, of_after = sums[:, -1:] - before, weight[:, -1:] - of_before
    difference = after / of_after - before / of_before
    return np.asarray(difference**2 / (1 / of_before + 1 / of_after))


def _step(
    values: Array, variances: Array, first: int, place: int, last: int, p_value: float
) -> Step:
    """The step between two levels."""
    means, spreads = [], []
    for part in (slice(first, place), slice(place, last)):
        weights = 1 / _total(values[part], variances[part])
        means.append(float(np.average(values[part], weights=weights)))
        spreads.append(1 / float(np.sum(weights)))
    return Step(
        place=place,
        difference=means[1] - means[0],
        deviation=float(np.sqrt(sum(spreads))),
        p_value=p_value,
    )
