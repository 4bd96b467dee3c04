"""Hausman test of two estimators on the same records.

Each estimate is linear in the residuals of its rows, so that the difference has the scores
``A_1 e_1 - A_2 e_2``, row by row. The covariance of the difference is that of the scores,
consistent with autocorrelation. Hausman's original test subtracts two covariances instead. The
covariance here is never negative, and neither estimator is assumed to be efficient.

Two estimates of one equation have one error, which is taken from the regression with the columns of
both, as in the test of Durbin, Wu and Hausman. Otherwise a difference would increase its own
covariance. Simulated replicas would not suffice: they contain noise, but not a loop that starts at
another position than the record.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import (
    Hac,
    checked_columns,
    factor,
    hotelling_p_value,
    instrumental_variables,
    wald,
)
from axisid.estimation.thresholds import CHECK_LEVEL
from axisid.support.arrays import Array, MaybeNan
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing

# standard errors; with a shift up to this, a 95 % interval contains the true value in 92 % of cases
NOTICEABLE_SHIFT = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class HausmanTest:
    """Difference of a parameter between two estimates, with its tests.

    Attributes
    ----------
    difference : float
        First estimate minus second, in the unit of the parameter. Both are corrected for the bias
        by filter and noise where this bias is known.
    deviation : float
        Standard error of the difference, HAC.
    p_value : float
        P-value of the hypothesis that this parameter does not differ, by Student's distribution.
    joint_p_value : float
        P-value of the hypothesis that no parameter differs, by Hotelling's distribution.
    shift : float
        Size of the difference, in standard errors of the second estimate.
    """

    difference: float
    deviation: float
    p_value: MaybeNan
    joint_p_value: MaybeNan
    shift: float


def hausman(one: Estimate, other: Estimate) -> dict[str, HausmanTest] | Missing:
    """Return the difference of two estimates with its tests, by name of the physical parameter.

    Missing, with the reason, where the difference cannot be tested.

    Parameters
    ----------
    one, other : Estimate
        Two estimates from the same rows. The difference is `one` minus `other`; its `shift` is in
        standard errors of `other`.

    References
    ----------
    [Hausman1978]_.
    """
    if (one.filter_bias is None) != (other.filter_bias is None):
        return Missing("the bias by filter and noise is known for only one of the two estimates")
    if one.X.shape != other.X.shape:
        return Missing("the two estimates do not have the same rows")
    # The difference, and its covariance from its scores.
    try:
        scores = np.subtract(*_scores(one, other))
    except EstimationError as error:
        return Missing(str(error))
    model = other.covariance_model if isinstance(other.covariance_model, Hac) else Hac()
    # Two fits of the same rows differ in a direction that neither of them fitted, so that no
    # degrees of freedom are lost: the kernel alone.
    scatter = model.of_scores(scores, other.neighbours)
    covariance, freedom = scatter.matrix, scatter.freedom
    difference = one.corrected - other.corrected
    if not (np.isfinite(covariance).all() and np.isfinite(difference).all()):
        return Missing("the difference of the two estimates is not finite")
    # Test of all parameters at once, then of each parameter.
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    square, directions = wald(difference, covariance)
    together = hotelling_p_value(square, directions, float(freedom.min())) if directions else 1.0
    found = {}
    for j, (name, value) in enumerate(other.parameters.items()):
        distance = abs(difference[j]) / deviations[j] if deviations[j] > 0 else 0.0
        found[name] = HausmanTest(
            difference=float(difference[j]),
            deviation=float(deviations[j]),
            p_value=float(2 * stdtr(freedom[j], -distance)),
            joint_p_value=together,
            shift=float(abs(difference[j]) / value.deviation) if value.deviation > 0 else 0.0,
        )
    return found


def significant_differences(
    differences: Mapping[str, HausmanTest], level: float = CHECK_LEVEL.value
) -> dict[str, HausmanTest]:
    """Return the parameters that differ significantly, with their tests, by name.

    Empty unless all parameters together differ significantly. A difference of up to
    `NOTICEABLE_SHIFT` standard errors does not count. Of the others, the parameters are returned
    that are significant alone; if none is, all of them: where parameters compensate each other,
    such as two parts of friction, neither needs to be significant alone.

    Parameters
    ----------
    differences : mapping of str to HausmanTest
    level : float
        Significance level of the tests.
    """
    noticeable = {
        name: each
        for name, each in differences.items()
        if each.joint_p_value < level and each.shift > NOTICEABLE_SHIFT
    }
    significant = {name: each for name, each in noticeable.items() if each.p_value < level}
    return significant or noticeable


def _scores(one: Estimate, other: Estimate) -> tuple[Array, Array]:
    """Return the scores of the physical parameters of both estimates, row by row, (n, p) each.

    A score is the influence of a row times its residual. Two estimates of one equation, which have
    the same regressor, get the same residual: that of the regression with the columns of both.
    """
    residuals = one.net_residuals, other.net_residuals
    if np.array_equal(one.X, other.X):
        weights = other.weights[:, None]
        columns = weights * np.column_stack([other.X, one.score_columns, other.score_columns])
        both = weights[:, 0] * (other.X @ other.theta + other.net_residuals)
        errors = both - columns @ np.linalg.lstsq(columns, both, rcond=None)[0]
        residuals = (errors / weights[:, 0],) * 2
    return _influence(one) * residuals[0][:, None], _influence(other) * residuals[1][:, None]


def _influence(estimate: Estimate) -> Array:
    """Return the influence of each row's residual on the physical parameters, (n, p).

    The influence is the derivative of the estimate by the residual. The residual does not contain
    the weights of records and loss.

    Raises
    ------
    EstimationError
        The columns of the simulated loop are linearly dependent.
    """
    weights, names = estimate.weights, [q.label for q in estimate.form.quantities]
    regressor, instruments = (
        weights[:, None] * each
        for each in (estimate.X, estimate.X if estimate.Z is None else estimate.Z)
    )
    y, X = weights * estimate.y, checked_columns(regressor, names)
    Z = factor(instruments, names, "the simulated loop")
    counts = estimate.counts
    influence = instrumental_variables(y, X, Z, counts).influence
    if counts is not None:  # residuals have no weights
        influence = counts.weights[:, None] * influence
    return np.asarray(weights[:, None] * (influence @ estimate.jacobian.T), dtype=float)
