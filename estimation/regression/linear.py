"""Linear solutions: least squares and instrumental variables, with the weights of a loss if any.

Columns are scaled to unit norm and factored by QR; X'X is never formed, so that neither units nor
the square of the condition number matter. Least squares uses the widest floats of the processor:
otherwise the rounding of a BLAS would change the last digits of an ill-conditioned fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.signals import RowTimes
from axisid.support.arrays import Array
from axisid.support.checks import refuse
from axisid.support.errors import EstimationError

from .covariance_note import CovarianceNote

# least ratio of the smallest to the largest singular value of unit columns that are independent: in
# measured records, filtering causes rounding errors of up to 1e-12 in dependent columns
_MIN_SINGULAR_VALUE_RATIO = 1e-11
# weight of a parameter, relative to the largest, in a combination that does not change the fit;
# far above rounding, and far below any weight that matters
_MIN_TRADE_WEIGHT = 1e-6

_UNNAMED = CovarianceNote(kind="other")

Wide = NDArray[np.longdouble]


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Finite, nonzero columns of a regressor with their norms.

    Attributes
    ----------
    columns : (n, k) array
        The columns, not scaled.
    scale : (k,) array
        Norms of the columns.
    names : tuple of str
        Names of the parameters, for messages.
    neighbours : RowTimes
        Times of the rows.
    """

    columns: Array
    scale: Array
    names: tuple[str, ...]
    neighbours: RowTimes


@dataclass(frozen=True, slots=True, kw_only=True)
class QrFactors(Columns):
    """QR factors of full-rank columns scaled to unit norm.

    Attributes
    ----------
    basis : (n, k) wide array
        Orthonormal Q.
    inverse : (k, k) wide array
        G with ``G G' = (W'W)^-1`` for the columns W.
    """

    basis: Wide
    inverse: Wide


@dataclass(frozen=True, slots=True, kw_only=True)
class LossWeights:
    """Weights of the rows under a loss rho other than least squares.

    Attributes
    ----------
    weights, slopes : (n,) array
        ``psi(e)/e`` and ``psi'(e)`` of each residual e, with ``psi = rho'``.
    """

    weights: Array
    slopes: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """Estimate of a regression, with residuals and influence for its covariance.

    Attributes
    ----------
    theta : (k,) array
        Estimated parameters.
    residuals : (n,) array
        ``y - X theta``, without weights.
    inverse_factor : (k, k) array
        G with ``G G' = A'A`` for the influence A; for instruments Z, ``G G' = (Z'Z)^-1``, which is
        equal if Z is the noise-free part of the regressor.
    influence : (n, k) array
        A with ``theta_hat - theta = A' e``: ``X (X'X)^-1`` (LS), ``W X (X'WX)^-1`` with weights W,
        or ``Z (X'Z)^-1`` (IV).
    neighbours : RowTimes
        Times of the rows.
    counts : LossWeights or None
        Weights under a loss other than least squares; `influence` then applies to the weighted
        residuals. None for equal weights.
    """

    theta: Array
    residuals: Array
    inverse_factor: Array
    influence: Array
    neighbours: RowTimes
    counts: LossWeights | None = None

    @property
    def counted(self) -> Array:
        """Residuals times their weights, (n,)."""
        return self.residuals if self.counts is None else self.counts.weights * self.residuals

    @property
    def response(self) -> Array:
        """Derivative of the estimate by the left side of each row, (n, k).

        It is the influence; under a loss, multiplied by the slope of the loss in each row.
        """
        if self.counts is None:
            return self.influence
        return self.counts.slopes[:, None] * self.influence


@dataclass(frozen=True, slots=True, kw_only=True)
class CovarianceEstimate:
    """Covariance of a solution, with degrees of freedom.

    Attributes
    ----------
    matrix : (k, k) array
        Covariance of the parameters.
    freedom : (k,) array
        Degrees of freedom by parameter: those of the chi-squared distribution that has the relative
        uncertainty of the estimated variance.
    note : CovarianceNote
        Estimator, lags and small-sample correction.
    """

    matrix: Array
    freedom: Array
    note: CovarianceNote = _UNNAMED


def checked_columns(
    columns: Array,
    names: Sequence[str],
    what: str = "the record",
    neighbours: RowTimes | None = None,
) -> Columns:
    """Return a regressor with the norms of its columns, after a check of each column.

    Parameters
    ----------
    columns : (n, k) array
        The regressor, or instruments.
    names : sequence of str
        Names of the k parameters.
    what : str
        Source of the columns, for messages.
    neighbours : RowTimes, optional
        Times of the rows; by default no row is missing.

    Raises
    ------
    EstimationError
        The columns are not finite, a column is zero (the message names the parameter), or there are
        too few rows.
    """
    n, k = columns.shape
    refuse(
        EstimationError,
        (
            n <= k,
            f"{n} rows are too few for {k} parameters. Fit the simulated loop (axisid fit, in "
            "Python fit(axis, record)), which uses all samples without a filter; or record longer, "
            "decimate less, or leave out fewer samples",
            "too-short",
        ),
        (
            not np.all(np.isfinite(columns)),
            f"the regressor of {what} is not finite. Check the size of the signals",
            "not-finite",
        ),
    )
    with np.errstate(over="ignore"):
        scale = np.linalg.norm(columns, axis=0)
    if not np.all(np.isfinite(scale)):
        infinite = [name for name, size in zip(names, scale, strict=True) if not np.isfinite(size)]
        raise EstimationError(
            f"the regressor of {what} reaches {np.abs(columns).max():.3g} in the columns of "
            f"{', '.join(infinite)}, and their squares overflow. Check these terms of the equation "
            "of motion over the positions and speeds of the record, and their units.",
            code="not-finite",
        )
    zero = [name for name, size in zip(names, scale, strict=True) if size == 0]
    if zero:
        subject = "the parameter" if len(zero) == 1 else "these parameters"
        raise EstimationError(
            f"{what} cannot show {', '.join(zero)}: the regressor's column is zero in every row. "
            f"Record a motion that excites {subject}, or leave {subject} out.",
            code="not-shown",
        )
    return Columns(
        columns=columns,
        scale=scale,
        names=tuple(names),
        neighbours=neighbours or RowTimes.consecutive(n),
    )


def factor(
    columns: Array,
    names: Sequence[str],
    what: str = "the record",
    neighbours: RowTimes | None = None,
) -> QrFactors:
    """Return the QR factors of a regressor or of instruments; parameters as in `checked_columns`.

    Raises
    ------
    EstimationError
        As in `checked_columns`; or the columns do not have full rank. The message then has the
        combination of parameters that does not change the fit.
    """
    checked = checked_columns(columns, names, what, neighbours)
    q, r = _orthonormal(columns.astype(np.longdouble) / checked.scale)
    _check_rank(r.astype(float), len(columns), checked.scale, names, what)
    return QrFactors(
        columns=columns,
        scale=checked.scale,
        basis=q,
        inverse=_inverse(r) / checked.scale[:, None],
        names=checked.names,
        neighbours=checked.neighbours,
    )


def _orthonormal(columns: Wide) -> tuple[Wide, Wide]:
    """Return orthonormal Q, (n, k), and upper triangular R, (k, k), with ``Q R`` the columns.

    The Gram-Schmidt process is applied twice to each column, so that Q is orthogonal to rounding.
    """
    k = columns.shape[1]
    q, r = columns.copy(), np.zeros((k, k), dtype=np.longdouble)
    for j in range(k):
        for _ in range(2):
            shared = q[:, :j].T @ q[:, j]
            q[:, j] -= q[:, :j] @ shared
            r[:j, j] += shared
        r[j, j] = np.sqrt(q[:, j] @ q[:, j])
        q[:, j] /= r[j, j] or 1.0
    return q, r


def _inverse(r: Wide) -> Wide:
    """Return the inverse of an upper triangular matrix by back substitution."""
    k = len(r)
    inverse = np.eye(k, dtype=np.longdouble)
    for i in reversed(range(k)):
        inverse[i] = (inverse[i] - r[i, i + 1 :] @ inverse[i + 1 :]) / r[i, i]
    return inverse


def least_squares(y: Array, X: QrFactors) -> Solution:
    """Return the least-squares solution ``argmin ||y - X theta||`` for the left side y, (n,)."""
    theta = X.inverse @ (X.basis.T @ y)
    return Solution(
        theta=theta.astype(float),
        residuals=(y - X.columns @ theta).astype(float),
        inverse_factor=X.inverse.astype(float),
        influence=(X.basis @ X.inverse.T).astype(float),
        neighbours=X.neighbours,
    )


def instrumental_variables(
    y: Array, X: Columns, Z: QrFactors, counts: LossWeights | None = None
) -> Solution:
    """Return the instrumental-variables solution ``(Z'X)^-1 Z'y``, just identified.

    It is least squares if the instruments are the regressor itself and the weights are equal. With
    the weights W of a loss it is ``(Z'WX)^-1 Z'Wy``, and the influence is that of the loss,
    ``Z (X'DZ)^-1`` with the slopes D of the loss.

    Parameters
    ----------
    y : (n,) array
        Left side.
    X : Columns
        Regressor.
    Z : QrFactors
        Instruments; the same object as X for least squares.
    counts : LossWeights, optional
        Weights and slopes of a loss; equal weights by default.

    Raises
    ------
    EstimationError
        Z'X does not have full rank: the instruments are not correlated with a combination of the
        regressor's columns, or the weighted rows do not separate the parameters.

    References
    ----------
    Equation (16) of [Brunot2015]_.
    """
    if X is Z and counts is None:
        return least_squares(y, Z)
    # With the orthonormal basis Q of the instruments and unit columns: Q'WX, Q'DX and Wy, where the
    # weights W and slopes D are 1 without a loss.
    basis, scaled = Z.basis.astype(float), X.columns / X.scale
    by_weights = by_slopes = basis.T @ scaled
    weighted_y, what = y, "the instruments together with the record"
    if counts is not None:
        by_weights = basis.T @ (counts.weights[:, None] * scaled)
        by_slopes = basis.T @ (counts.slopes[:, None] * scaled)
        weighted_y, what = counts.weights * y, "the set of weighted rows"
    _check_rank(by_weights, len(y), X.scale, X.names, what)
    if counts is not None:
        _check_rank(by_slopes, len(y), X.scale, X.names, what)
    theta = np.linalg.solve(by_weights, basis.T @ weighted_y) / X.scale
    influence = np.linalg.solve(by_slopes, basis.T).T / X.scale
    # G with G G' = (Z'Z)^-1, or = A'A for the influence A under a loss.
    inverse = Z.inverse
    if counts is not None:
        inverse = _orthonormal(influence.astype(np.longdouble))[1].T
    return Solution(
        theta=theta,
        residuals=y - X.columns @ theta,
        inverse_factor=inverse.astype(float),
        influence=influence,
        neighbours=X.neighbours,
        counts=counts,
    )


def condition_number(X: Array) -> float:
    """Return the condition number of columns (n, k) that are not scaled; infinite without rows.

    It is the ratio of the largest to the smallest singular value.
    """
    return float(np.linalg.cond(X)) if len(X) else np.inf


def _check_rank(matrix: Array, rows: int, scale: Array, names: Sequence[str], what: str) -> None:
    """Refuse a rank-deficient matrix of scaled columns.

    The message has the combination of parameters that does not change the fit: the right singular
    vector of the smallest singular value.

    Parameters
    ----------
    matrix : (k, k) array
        R of the QR factors, or instruments times regressor.
    rows : int
        Number of rows, for the rounding error.
    scale : (k,) array
        Norms of the columns, which they were divided by.
    names : sequence of str
        Names of the k parameters.
    what : str
        Source of the columns, for the message.
    """
    _, sizes, right = np.linalg.svd(matrix)
    # Unit columns have a largest singular value of 1 or more, unless no instrument is correlated
    # with them. Filtering causes rounding errors of up to 1e-12 in dependent columns.
    least = max(rows * np.finfo(float).eps, _MIN_SINGULAR_VALUE_RATIO)
    if sizes[-1] > max(sizes[0], 1.0) * least:
        return
    direction = right[-1] / scale
    direction = direction / direction[np.argmax(np.abs(direction))]
    combination = ", ".join(
        f"{name} {weight:+.4g}"
        for name, weight in zip(names, direction, strict=True)
        if abs(weight) > _MIN_TRADE_WEIGHT
    )
    raise EstimationError(
        f"{what} cannot separate these parameters: the fit is the same for a change of "
        f"{combination}. "
        "Record a motion that separates them (reversals, several speeds, acceleration), or declare "
        "their combination as one parameter.",
        code="not-shown",
    )
