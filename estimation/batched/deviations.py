"""Deviations of lanes under a covariance, and their degrees of freedom."""

import numpy as np

from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.regression import Solution
from axisid.estimation.signals import Neighbours
from axisid.support.arrays import Array

from .block import Block
from .iteration import LaneFits
from .regression import inverse_products


def lane_deviations(
    block: Block, fits: LaneFits, covariance: str, lags: int | None
) -> tuple[Array, Array]:
    """Deviations and degrees of freedom of lanes that ended well, (L, p) each."""
    model = COVARIANCES[covariance].covariance(lags)
    deviations = np.full_like(fits.theta, np.nan)
    freedom = np.full_like(fits.theta, np.nan)
    places = block.template.row_numbers.astype(np.int64)
    inverse = inverse_products(fits.instruments)
    for lane in np.flatnonzero(fits.well):
        own = slice(None) if fits.rows is None else fits.rows[:, lane]
        solution = Solution(
            theta=fits.theta[lane],
            residuals=np.ascontiguousarray(fits.residuals[own, lane]),
            inverse_factor=np.linalg.cholesky(inverse[lane]),
            influence=fits.instruments[own, :, lane] @ fits.mixing[lane].T,
            neighbours=Neighbours.of(places[own], block.template.prefilter.decimate),
        )
        applied = model.applied(solution)
        deviations[lane] = np.sqrt(np.maximum(np.diag(applied.matrix), 0.0))
        freedom[lane] = applied.freedom
    return deviations, freedom
