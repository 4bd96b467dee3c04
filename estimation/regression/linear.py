"""The linear solutions: least squares and instrumental variables, by squares or as a loss counts.

Columns are scaled to unit norm and factored by QR; X'X is never formed, so that neither the units
nor the square of the condition number enter. Least squares runs in the widest floats of the
machine: what a BLAS rounds one way or another would else cost an ill-conditioned fit its last
digits.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.signals import RowTimes
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, refuse

from .covariance_note import CovarianceNote

# of unit columns, smallest by largest: measured, filtering leaves rounding of up to 1e-12 in
# columns that are dependent
_MIN_SINGULAR_VALUE_RATIO = 1e-11
# of the largest in a change that the fit does not notice; far above rounding, and below any trade
# that matters
_MIN_TRADE_WEIGHT = 1e-6

_UNNAMED = CovarianceNote(kind="other")

Wide = NDArray[np.longdouble]


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Columns that are finite and none of which is zero.

    Attributes
    ----------
    columns : (n, k) array
        As they were given.
    scale : (k,) array
        Their norms.
    names : tuple of str
        Of the columns' parameters, for messages.
    neighbours : RowTimes
        Which of the rows follow each other in time.
    """

    columns: Array
    scale: Array
    names: tuple[str, ...]
    neighbours: RowTimes


@dataclass(frozen=True, slots=True, kw_only=True)
class QrFactors(Columns):
    """Full-rank columns as ``Q R``, scaled to unit norm before.

    Attributes
    ----------
    basis : (n, k) wide array
        Orthonormal, Q.
    inverse : (k, k) wide array
        G with ``G G' = (W'W)^-1`` for the columns W.
    """

    basis: Wide
    inverse: Wide


@dataclass(frozen=True, slots=True, kw_only=True)
class LossWeights:
    """What each row counts under a loss that is not of squares.

    Attributes
    ----------
    weights, slopes : (n,) array
        How much each residual counted, and how much more it would with its size.
    """

    weights: Array
    slopes: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """An estimate with what its covariance needs.

    Attributes
    ----------
    theta : (k,) array
    residuals : (n,) array
        ``y - X theta``.
    inverse_factor : (k, k) array
        G with ``G G' = A'A`` for the influence A; of instruments Z ``(Z'Z)^-1``, which is the same
        where they are the regressor's part that is free of noise.
    influence : (n, k) array
        A with ``theta_hat - theta = A' e``: ``X (X'X)^-1`` (LS), ``W X (X'WX)^-1`` with weights W,
        or ``Z (X'Z)^-1`` (IV).
    neighbours : RowTimes
        Which of the rows follow each other in time.
    counts : LossWeights or None
        Under a loss that is not of squares; `influence` is then of residuals as they counted. None
        where all count alike.
    """

    theta: Array
    residuals: Array
    inverse_factor: Array
    influence: Array
    neighbours: RowTimes
    counts: LossWeights | None = None

    @property
    def counted(self) -> Array:
        """Residuals as they counted, (n,)."""
        return self.residuals if self.counts is None else self.counts.weights * self.residuals

    @property
    def response(self) -> Array:
        """Slope of the estimate by each row's left side, (n, k)."""
        if self.counts is None:
            return self.influence
        return self.counts.slopes[:, None] * self.influence


@dataclass(frozen=True, slots=True, kw_only=True)
class CovarianceEstimate:
    """A covariance of a solution.

    Attributes
    ----------
    matrix : (k, k) array
    freedom : (k,) array
        Degrees of freedom of the chi-squared with each variance's relative error.
    note : CovarianceNote
        What it is, with lags and small-sample correction.
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
    """A regressor, checked column by column.

    Parameters
    ----------
    columns : (n, k) array
    names : sequence of str
        Of the k columns' parameters.
    what : str
        Where the columns come from.
    neighbours : RowTimes, optional
        Which of the rows follow each other in time; by default all do.

    Raises
    ------
    EstimationError
        The columns are not finite, or one of them is zero, which is named; or there are too few
        rows.
    """
    n, k = columns.shape
    refuse(
        EstimationError,
        (
            n <= k,
            f"{n} rows are left for {k} parameters; fit the simulated loop (axisid fit, in Python "
            "fit(axis, record)), which has no filter and takes all samples, or record longer, or "
            "decimate or drop less",
            "too-short",
        ),
        (
            not np.all(np.isfinite(columns)),
            f"the regressor of {what} is not finite; check the signals' size",
            "not-finite",
        ),
    )
    with np.errstate(over="ignore"):
        scale = np.linalg.norm(columns, axis=0)
    if not np.all(np.isfinite(scale)):
        listed = ", ".join(n for n, size in zip(names, scale, strict=True) if not np.isfinite(size))
        raise EstimationError(
            f"the regressor of {what} reaches {np.abs(columns).max():.3g} in the columns of "
            f"{listed}, whose squares no number holds. Check those terms of the equation of motion "
            "over the positions and speeds of the record, and their units.",
            code="not-finite",
        )
    zero = [name for name, size in zip(names, scale, strict=True) if size == 0]
    if zero:
        raise EstimationError(
            f"{what} cannot show {', '.join(zero)}: the regressor's column is zero in every row. "
            "Record a motion that excites it, or leave the parameter out.",
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
    """Factor a regressor or instruments; parameters as of `checked_columns`.

    Raises
    ------
    EstimationError
        As there; or the columns have not full rank, the combination is named.
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
    """``Q R`` by Gram and Schmidt, twice over, which leaves Q orthogonal to rounding."""
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
    """Inverse of an upper triangle, by back substitution."""
    k = len(r)
    inverse = np.eye(k, dtype=np.longdouble)
    for i in reversed(range(k)):
        inverse[i] = (inverse[i] - r[i, i + 1 :] @ inverse[i + 1 :]) / r[i, i]
    return inverse


def least_squares(y: Array, X: QrFactors) -> Solution:
    """``argmin ||y - X theta||``, y of shape (n,)."""
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
    """``(Z'X)^-1 Z'y``, just identified, y of shape (n,).

    Least squares where the instruments are the regressor itself and all rows count alike. With
    weights W that a loss gave it is ``(Z'WX)^-1 Z'Wy``, Z being X of least squares, and the
    influence is that of the loss, ``Z (X'DZ)^-1`` with its slopes D.

    Raises
    ------
    EstimationError
        Z'X has not full rank: the instruments do not see what the regressor sees, or the rows that
        count do not tell the parameters apart.

    References
    ----------
    Equation (16) of [Brunot2015]_.
    """
    if X is Z and counts is None:
        return least_squares(y, Z)
    basis, scaled = Z.basis.astype(float), X.columns / X.scale
    weighted = bent = basis.T @ scaled
    counted, what = y, "the instruments together with the record"
    if counts is not None:
        rows = (each[:, None] * scaled for each in (counts.weights, counts.slopes))
        weighted, bent = (basis.T @ each for each in rows)
        counted, what = counts.weights * y, "what counts of the rows"
    for matrix in (weighted,) if counts is None else (weighted, bent):
        _check_rank(matrix, len(y), X.scale, X.names, what)
    theta = np.linalg.solve(weighted, basis.T @ counted) / X.scale
    influence = np.linalg.solve(bent, basis.T).T / X.scale
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
    """Largest over smallest singular value, of the columns as they are; infinite without rows."""
    return float(np.linalg.cond(X)) if len(X) else np.inf


def _check_rank(matrix: Array, rows: int, scale: Array, names: Sequence[str], what: str) -> None:
    """Refuse a rank-deficient matrix of scaled columns, naming what cannot be told apart."""
    _, sizes, right = np.linalg.svd(matrix)
    # Unit columns have a largest singular value of 1 or more, unless instruments miss them all.
    # Filtering leaves rounding of up to 1e-12 in columns that are dependent.
    least = max(rows * np.finfo(float).eps, _MIN_SINGULAR_VALUE_RATIO)
    if sizes[-1] > max(sizes[0], 1.0) * least:
        return
    direction = right[-1] / scale
    direction = direction / direction[np.argmax(np.abs(direction))]
    trade = ", ".join(
        f"{name} {weight:+.4g}"
        for name, weight in zip(names, direction, strict=True)
        if abs(weight) > _MIN_TRADE_WEIGHT
    )
    raise EstimationError(
        f"{what} cannot tell these parameters apart: the fit does not notice a change of {trade}. "
        "Record a motion that separates them (reversals, several speeds, acceleration), or declare "
        "their combination as one parameter.",
        code="not-shown",
    )
