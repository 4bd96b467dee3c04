"""Axes whose parameters are not those of the others, beyond what their deviations explain."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2, f

from axisid.estimation.thresholds.studies import FLEET_LEVEL, MIN_LOGS_PER_PARAMETER
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .robust_scatter import robust_scatter, squared_distances
from .row import FleetRow

#: Quantile of the distances within which no log is looked at, and how many are beyond it of many.
_NEAR, _LOOKED_AT = 0.9, 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlier:
    """A log whose parameters are not those of the others.

    Attributes
    ----------
    name : str
        Of the row.
    distance : float
        Robust distance in deviations, all parameters together.
    p_value : float
        Of a distance as large or larger of a log like the others.
    parameter : str
        The one that is furthest from the centre by itself.
    apart : float
        How far, in deviations.
    """

    name: str
    distance: float
    p_value: float
    parameter: str
    apart: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Usual:
    """What is usual among logs of one axis.

    Attributes
    ----------
    centre : array, (p,)
    between : array, (p, p)
        Scatter between the logs' true values, less what the estimates' deviations explain.
    within : array, (p, p)
        Covariance of an estimate, the median over the logs.
    """

    centre: Array
    between: Array
    within: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisGroup:
    """Logs of one axis, with the same parameters.

    Attributes
    ----------
    axis : str
    names, units : tuple of str
        Of the parameters.
    rows : tuple of FleetRow
    usual : Usual or Missing
    outliers : tuple of Outlier
        The furthest first.
    """

    axis: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[FleetRow, ...]
    usual: Usual | Missing
    outliers: tuple[Outlier, ...]


def groups_of(rows: Iterable[FleetRow]) -> tuple[AxisGroup, ...]:
    """The rows with a result by axis and parameters."""
    grouped: dict[tuple[str, tuple[str, ...]], list[FleetRow]] = {}
    for row in rows:
        if row.has_result:
            grouped.setdefault((row.axis, tuple(row.parameters)), []).append(row)
    return tuple(_group(axis, names, each) for (axis, names), each in grouped.items())


def _group(axis: str, names: tuple[str, ...], rows: Sequence[FleetRow]) -> AxisGroup:
    usual, outliers = _judged(names, rows)
    return AxisGroup(
        axis=axis,
        names=names,
        units=tuple(value.unit for value in rows[0].parameters.values()),
        rows=tuple(rows),
        usual=usual,
        outliers=outliers,
    )


def _judged(
    names: Sequence[str], rows: Sequence[FleetRow]
) -> tuple[Usual | Missing, tuple[Outlier, ...]]:
    values = np.array([[value.value for value in row.parameters.values()] for row in rows])
    least = int(MIN_LOGS_PER_PARAMETER.value) * max(len(names), 1)
    if len(rows) < least:
        few = f"of {len(rows)} logs nothing is usual; {least} or more tell what is"
        return Missing(few), ()
    scale = np.std(values, axis=0)
    if not scale.all() or np.linalg.matrix_rank((values - values.mean(axis=0)) / scale) < len(
        names
    ):
        return Missing("the values of the logs lie in fewer dimensions than parameters"), ()
    covariances = np.array([row.covariance for row in rows])
    centre, scatter = robust_scatter(values)
    first = _usual(centre, scatter, covariances)
    robust = _distances(values, covariances, first)
    order = np.argsort(-robust, kind="stable")
    near = max(1 - _LOOKED_AT / len(rows), _NEAR)
    far = int(np.count_nonzero(robust > chi2.ppf(near, len(names))))
    count = _outlying(values[order], covariances[order], min(far, (len(rows) - len(names)) // 2))
    alike = order[count:]
    usual = _usual_of(values[alike], covariances[alike])
    distances = _distances(values, covariances, usual)
    p_values = of_a_new_point(distances, len(alike), len(names))
    return usual, tuple(
        _outlier(names, rows[i], values[i], covariances[i], usual, distances[i], p_values[i])
        for i in sorted(order[:count], key=lambda i: -distances[i])
    )


def _outlying(values: Array, covariances: Array, most: int) -> int:
    """How many of the first logs, the furthest first and `most` of them, are not like the others.

    Each is held against all that follow it. The last that is too far for the furthest of as many
    is an outlier with all before it, so that several that lie together do not hide one another
    [1]_.

    .. [1] C. Caroni, P. Prescott, "Sequential application of Wilks's multivariate outlier test",
       Applied Statistics 41 (2), 1992.
    """
    size = values.shape[1]
    found = 0
    for i in range(most):
        usual = _usual_of(values[i + 1 :], covariances[i + 1 :])
        (distance,) = _distances(values[i : i + 1], covariances[i : i + 1], usual)
        left = len(values) - i
        if of_a_new_point(distance, left - 1, size) * left < FLEET_LEVEL.value:
            found = i + 1
    return found


def _usual_of(values: Array, covariances: Array) -> Usual:
    """What is usual among logs that are alike."""
    scatter = np.atleast_2d(np.cov(values.T))
    return _usual(values.mean(axis=0), scatter, covariances)


def _usual(centre: Array, scatter: Array, covariances: Array) -> Usual:
    """Scatter of the logs without that of their estimates; none where that explains it."""
    within = np.median(covariances, axis=0)  # one log that knows little is none of the others
    # Both in units of the scatter, so that no parameter's unit decides what is too small.
    root = np.linalg.cholesky(scatter)
    excess = np.linalg.solve(root, np.linalg.solve(root, scatter - within).T)
    sizes, axes = np.linalg.eigh((excess + excess.T) / 2)
    turned = root @ axes
    between = turned * np.maximum(sizes, 0.0) @ turned.T
    return Usual(centre=centre, between=between, within=within)


def _distances(values: Array, covariances: Array, usual: Usual) -> Array:
    """Squared distances, each by the scatter and the log's own covariance."""
    points = values[:, None, :]
    centres = np.broadcast_to(usual.centre, values.shape)
    return squared_distances(points, centres, usual.between + covariances)[:, 0]


def of_a_new_point(distance: Any, count: int, size: int) -> Any:
    """Probability of a squared distance as large, from the mean and covariance of other points.

    Parameters
    ----------
    distance : float or array
    count, size : int
        How many other points there are, and in how many dimensions.
    """
    scaled = distance * count * (count - size) / ((count + 1) * (count - 1) * size)
    return f.sf(scaled, size, count - size)


def _outlier(
    names: Sequence[str],
    row: FleetRow,
    value: Array,
    covariance: Array,
    usual: Usual,
    distance: float,
    p_value: float,
) -> Outlier:
    apart = (value - usual.centre) / np.sqrt(np.diag(usual.between + covariance))
    furthest = int(np.argmax(np.abs(apart)))
    return Outlier(
        name=row.name,
        distance=float(np.sqrt(distance)),
        p_value=float(p_value),
        parameter=names[furthest],
        apart=float(apart[furthest]),
    )
