"""Deviations of lanes under every covariance, and their degrees of freedom."""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.batched.rows import (
    Block,
    combined,
    inverse_products,
    lagged_products,
)
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.regression import Covariance, Hac, Solution, most_lags
from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import FEW_SCORES
from axisid.support.arrays import Array

from .iteration import LaneFits


@dataclass(frozen=True, slots=True)
class LaneDeviations:
    """By name of the covariance: deviations and degrees of freedom, (L, p) each."""

    deviations: dict[str, Array]
    freedom: dict[str, Array]


def lane_deviations(block: Block, fits: LaneFits, lags: int | None) -> LaneDeviations:
    """Deviations of lanes that ended well; not a number for the others."""
    names, shape = tuple(COVARIANCES), fits.theta.shape
    found = LaneDeviations(*({name: np.full(shape, np.nan) for name in names} for _ in range(2)))
    inverse = inverse_products(block.library, fits.instruments)
    scores = combined(fits.instruments, fits.mixing) * fits.residuals[:, None]
    lagged = _lagged(block, scores, lags)
    models = {name: COVARIANCES[name].covariance(lags) for name in names}
    for lane in map(int, np.flatnonzero(fits.well)):
        n, k = fits.counts[lane], shape[1]
        by_name = {
            "iid": (fits.power[lane] / (n - 1) * np.diagonal(inverse[lane]), n - k),
            "robust": (n / (n - k) * lagged[0, :, lane], n - k),
            "hac": _hac(models["hac"], lagged[:, :, lane], int(n)),
        }
        for name, (variances, freedom) in by_name.items():
            found.freedom[name][lane] = freedom
            if name == "hac" and lags is None and np.min(freedom) < FEW_SCORES.value:
                applied = models[name].applied(lane_solution(block, fits, lane, inverse[lane]))
                of_few, found.freedom[name][lane] = np.diag(applied.matrix), applied.freedom
            else:
                of_few = variances
            found.deviations[name][lane] = np.sqrt(np.maximum(of_few, 0.0))
    return found


def _lagged(block: Block, scores: Array, lags: int | None) -> Array:
    """Products of scores (n, p, L) at as many lags as a covariance may look at."""
    most = (most_lags(len(scores)) if lags is None else lags) + 2
    return lagged_products(block.library, scores, min(most, len(scores) - 1))


def _hac(model: Covariance, lagged: Array, rows: int) -> tuple[Array, Array]:
    """Variances and degrees of freedom by a lane's scores, products (lags + 1, p) of each alone."""
    assert isinstance(model, Hac)  # noqa: S101
    k = lagged.shape[1]
    alone = lagged[:, :, None] * np.eye(k)
    found = model.long_run(lambda lags: alone[: lags + 1], rows)
    variances = rows / (rows - k) * np.diag(found.covariance)
    return variances, np.minimum(found.freedom, rows - k)


def lane_solution(
    block: Block, fits: LaneFits, lane: int, inverse: Array | None = None
) -> Solution:
    """A lane's solution as if it were alone; `inverse` are ``(Z'Z)^-1`` where they are known."""
    own = slice(None) if fits.rows is None else fits.rows[:, lane]
    places = block.template.row_numbers.astype(np.int64)[own]
    instruments = fits.instruments[own, :, lane]
    if inverse is None:
        inverse = np.asarray(np.linalg.inv(instruments.T @ instruments))
    return Solution(
        theta=fits.theta[lane],
        residuals=np.ascontiguousarray(fits.residuals[own, lane]),
        inverse_factor=np.asarray(np.linalg.cholesky(inverse), dtype=np.float64),
        influence=instruments @ fits.mixing[lane].T,
        neighbours=Neighbours.of(places, block.template.prefilter.decimate),
    )
