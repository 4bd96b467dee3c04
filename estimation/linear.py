"""The two linear solutions: least squares and instrumental variables.

Columns are scaled to unit norm and factored by QR; X'X is never formed, so that neither the units
nor the square of the condition number enter.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular, svd

from .arrays import Array
from .errors import EstimationError


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """An estimate with what its covariance needs.

    Attributes
    ----------
    theta : (k,) array
    residuals : (n,) array
        ``y - X theta``.
    inverse_factor : (k, k) array
        G with ``G G' = (W'W)^-1``, W the regressor (LS) or the instruments (IV).
    """

    theta: Array
    residuals: Array
    inverse_factor: Array


def least_squares(y: Array, X: Array, names: Sequence[str]) -> Solution:
    """``argmin ||y - X theta||``.

    Parameters
    ----------
    y : (n,) array
    X : (n, k) array
    names : sequence of str
        Of the k columns' parameters, for the message.

    Raises
    ------
    EstimationError
        X has not full column rank; the combination is named.
    """
    q, factor = _factor(X, names, "the record")
    theta = factor @ (q.T @ y)
    return Solution(theta=theta, residuals=y - X @ theta, inverse_factor=factor)


def instrumental_variables(y: Array, X: Array, Z: Array, names: Sequence[str]) -> Solution:
    """``(Z'X)^-1 Z'y``, just identified.

    Parameters
    ----------
    y : (n,) array
    X, Z : (n, k) arrays
        Regressor and instruments.
    names : sequence of str
        Of the k columns' parameters, for the message.

    Raises
    ------
    EstimationError
        X, Z or Z'X has not full rank.

    References
    ----------
    Equation (16) of [Brunot2015]_.
    """
    _factor(X, names, "the record")
    q, factor = _factor(Z, names, "the simulated instruments")
    scale = np.linalg.norm(X, axis=0)
    projected = q.T @ (X / scale)
    _check_rank(projected, len(y), scale, names, "the instruments together with the record")
    theta = np.linalg.solve(projected, q.T @ y) / scale
    return Solution(theta=theta, residuals=y - X @ theta, inverse_factor=factor)


def condition_number(X: Array) -> float:
    """Largest over smallest singular value, of the columns as they are."""
    return float(np.linalg.cond(X))


def _factor(X: Array, names: Sequence[str], what: str) -> tuple[Array, Array]:
    """Orthonormal basis of X's columns, and the inverse of its triangular factor."""
    n, k = X.shape
    if n <= k:
        raise EstimationError(
            f"{n} rows are left for {k} parameters; record longer, or decimate or drop less."
        )
    if not np.all(np.isfinite(X)):
        raise EstimationError(f"the regressor of {what} is not finite; check the signals' size.")
    scale = np.linalg.norm(X, axis=0)
    silent = [name for name, size in zip(names, scale, strict=True) if size == 0]
    if silent:
        raise EstimationError(
            f"{what} cannot show {', '.join(silent)}: the regressor's column is zero in every row. "
            "Record a motion that excites it, or leave the parameter out."
        )
    q, r = qr(X / scale, mode="economic")
    _check_rank(r, n, scale, names, what)
    inverse = solve_triangular(r, np.eye(k)) / scale[:, None]
    return q, inverse


def _check_rank(matrix: Array, rows: int, scale: Array, names: Sequence[str], what: str) -> None:
    """Refuse a rank-deficient matrix of scaled columns, naming what cannot be told apart."""
    _, sizes, right = svd(matrix)
    # Unit columns have a largest singular value of 1 or more, unless instruments miss them all.
    if sizes[-1] > max(sizes[0], 1.0) * rows * np.finfo(float).eps:
        return
    direction = right[-1] / scale
    direction = direction / direction[np.argmax(np.abs(direction))]
    trade = ", ".join(
        f"{name} {weight:+.4g}"
        for name, weight in zip(names, direction, strict=True)
        if abs(weight) > 1e-6
    )
    raise EstimationError(
        f"{what} cannot tell these parameters apart: the fit does not notice a change of {trade}. "
        "Record a motion that separates them (reversals, several speeds, acceleration), or declare "
        "their combination as one parameter."
    )
