"""Axes whose parameters are not those of the others, beyond what their deviations explain."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta, f

from axisid.estimation.thresholds.studies import FLEET_LEVEL, MIN_LOGS_PER_PARAMETER
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .robust_scatter import Scatter, robust_scatter, squared_distances
from .row import FleetRow


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
        Mean covariance of the estimates.
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
    if np.linalg.matrix_rank(values - np.median(values, axis=0)) < len(names):
        return Missing("the logs have values that are not independent of one another"), ()
    covariances = np.array([row.covariance for row in rows])
    found = robust_scatter(values)
    usual = _usual(found, covariances)
    distances = _distances(values, covariances, usual)
    p_values = tail_probabilities(distances, found.used, len(names))
    limit = -np.expm1(
        np.log1p(-FLEET_LEVEL.value) / len(rows)
    )  # of each, so that it is that of all
    outlying = [int(i) for i in np.argsort(p_values, kind="stable") if p_values[i] < limit]
    return usual, tuple(
        _outlier(names, rows[i], values[i], covariances[i], usual, distances[i], p_values[i])
        for i in outlying
    )


def _usual(found: Scatter, covariances: Array) -> Usual:
    """Scatter of the logs without that of their estimates; none where that explains it."""
    within = np.mean(covariances[found.used], axis=0)
    # Both in units of the scatter, so that no parameter's unit decides what is too small.
    root = np.linalg.cholesky(found.covariance)
    excess = np.linalg.solve(root, np.linalg.solve(root, found.covariance - within).T)
    sizes, axes = np.linalg.eigh((excess + excess.T) / 2)
    turned = root @ axes
    between = turned * np.maximum(sizes, 0.0) @ turned.T
    return Usual(centre=found.centre, between=between, within=within)


def _distances(values: Array, covariances: Array, usual: Usual) -> Array:
    """Squared distances, each by the scatter and the log's own covariance."""
    return np.array(
        [
            squared_distances(value[None], usual.centre, usual.between + covariance)[0]
            for value, covariance in zip(values, covariances, strict=True)
        ]
    )


def tail_probabilities(distances: Array, used: NDArray[np.bool_], size: int) -> Array:
    """Probability of squared distances as large, of points that are like the others.

    A point that the centre and the scatter are of is nearer to them than one that is not: scaled
    beta and F distributions [1]_.

    .. [1] A. Cerioli, "Multivariate outlier detection with high-breakdown estimators", Journal of
       the American Statistical Association 105 (489), 2010.
    """
    count = int(np.sum(used))
    inside = beta.sf(distances * count / (count - 1) ** 2, size / 2, (count - size - 1) / 2)
    scaled = distances * count * (count - size) / ((count + 1) * (count - 1) * size)
    return np.asarray(np.where(used, inside, f.sf(scaled, size, count - size)))


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
