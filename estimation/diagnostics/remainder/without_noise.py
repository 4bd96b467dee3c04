"""Residuals of least squares without a reference, held against a motion that has no noise in it.

Noise of the position is in the residuals of least squares and in its columns, so that the two are
alike however right the model is. Loops that follow the record have next to none of it: their
columns stand for the motion, and residuals are those of the values that are free of what noise
moves.
"""

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import NoiseFree
from axisid.estimation.regression import ResidualTests, residual_tests


def loop_without_noise(estimate: Estimate) -> NoiseFree | None:
    """The loops that follow a record, where what noise moves an estimate by is known by them."""
    quiet = estimate.noise_free
    known = quiet is not None and quiet.has_noise and not quiet.doubt
    return quiet if known and estimate.loop_rows is None and not estimate.is_direct else None


def tests_of_residuals(estimate: Estimate) -> ResidualTests:
    """Tests of an estimate's residuals; see `Estimate.residual_tests`."""
    quiet = loop_without_noise(estimate)
    if quiet is None:
        return estimate.residual_tests
    theta = estimate.form.regressed(estimate.corrected)
    left = estimate.residuals + estimate.X @ (estimate.theta - theta)
    by_filter = quiet.residuals + quiet.regressor @ (quiet.theta - theta)
    return residual_tests(
        np.asarray(left - by_filter, dtype=float), quiet.regressor, neighbours=estimate.neighbours
    )
