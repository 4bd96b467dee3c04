"""Two estimates of the same records, held against each other and against chance.

Either is linear in the residuals of its rows, so that their difference has the scores
``A_1 e_1 - A_2 e_2``, row by row; its covariance is theirs, consistent with autocorrelation. Unlike
Hausman's own, which subtracts two covariances, it is never negative and supposes neither estimator
to be efficient. Two estimates of one equation have one error, which is taken from the regression
with the columns of both, as in Durbin, Wu and Hausman's: else what parts the two would hide itself.
Twins would not do: they know of noise, and not of a loop that starts elsewhere than the record.
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
from axisid.support.errors import EstimationError, Missing

NOTICEABLE_SHIFT = 0.5  # deviations: up to there a 95 % interval holds the truth in 92 % of cases


@dataclass(frozen=True, slots=True, kw_only=True)
class HausmanTest:
    """How far a parameter of one estimate is from that of another.

    Attributes
    ----------
    difference : float
        In the parameter's unit; both less the bias of filter and noise where it is known.
    deviation : float
        HAC, of the difference.
    p_value : float
        Hausman, of this parameter: of a difference of none, by Student's distribution.
    joint_p_value : float
        The same of all parameters at once, Hotelling's.
    shift : float
        Size of the difference, in deviations of the other estimate.
    """

    difference: float
    deviation: float
    p_value: MaybeNan
    joint_p_value: MaybeNan
    shift: float


def hausman(one: Estimate, other: Estimate) -> dict[str, HausmanTest] | Missing:
    """One estimate less another by physical parameter, or why that cannot be tested.

    Parameters
    ----------
    one, other : Estimate
        Of the same rows.

    References
    ----------
    [Hausman1978]_.
    """
    if (one.filter_bias is None) != (other.filter_bias is None):
        return Missing("what filter and noise move is known of one of the two alone")
    if one.X.shape != other.X.shape:
        return Missing("the two are not of the same rows")
    try:
        scores = np.subtract(*_scores(one, other))
    except EstimationError as error:
        return Missing(str(error))
    model = other.covariance_model if isinstance(other.covariance_model, Hac) else Hac()
    # What parts two fits of the same rows is a direction that neither took: the kernel alone.
    scatter = model.of_scores(scores, other.neighbours)
    covariance, freedom = scatter.matrix, scatter.freedom
    difference = one.corrected - other.corrected
    if not (np.isfinite(covariance).all() and np.isfinite(difference).all()):
        return Missing("the difference of the two is not finite")
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
    """Parameters that two estimates part in: those that do alone, or else together.

    What one gives to another, as friction's two parts do, neither of them need show by itself.
    What is less than half a deviation is none, however sure.

    Parameters
    ----------
    differences : mapping of str to HausmanTest
    level : float
        Of the tests.
    """
    far = {
        name: each
        for name, each in differences.items()
        if each.joint_p_value < level and each.shift > NOTICEABLE_SHIFT
    }
    return {name: each for name, each in far.items() if each.p_value < level} or far


def _scores(one: Estimate, other: Estimate) -> tuple[Array, Array]:
    """What each row moves the physical parameters of each by, (n, p)."""
    residuals = one.net_residuals, other.net_residuals
    if np.array_equal(one.X, other.X):
        weights = other.weights[:, None]
        columns = weights * np.column_stack([other.X, one.score_columns, other.score_columns])
        both = weights[:, 0] * (other.X @ other.theta + other.net_residuals)
        errors = both - columns @ np.linalg.lstsq(columns, both, rcond=None)[0]
        residuals = (errors / weights[:, 0],) * 2
    return _influence(one) * residuals[0][:, None], _influence(other) * residuals[1][:, None]


def _influence(estimate: Estimate) -> Array:
    """Of each row's residual on the physical parameters, (n, p).

    Raises
    ------
    EstimationError
        The simulated loop's columns cannot be told apart.
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
    if counts is not None:  # residuals are as they are
        influence = counts.weights[:, None] * influence
    return np.asarray(weights[:, None] * (influence @ estimate.jacobian.T), dtype=float)
