"""The two linear solutions: least squares and instrumental variables.

Columns are scaled to unit norm and factored by QR; X'X is never formed, so that neither the units
nor the square of the condition number enter.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .arrays import Array
from .errors import EstimationError

_SMALLEST_RATIO = 1e-11


@dataclass(frozen=True, slots=True, kw_only=True)
class Factored:
    """Full-rank columns as ``Q R``, scaled to unit norm before.

    Attributes
    ----------
    columns : (n, k) array
        As they were given.
    scale : (k,) array
        Their norms.
    basis : (n, k) array
        Orthonormal, Q.
    inverse : (k, k) array
        G with ``G G' = (W'W)^-1`` for the columns W.
    names : tuple of str
        Of the columns' parameters, for messages.
    """

    columns: Array
    scale: Array
    basis: Array
    inverse: Array
    names: tuple[str, ...]


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
    influence : (n, k) array
        A with ``theta_hat - theta = A' e``: ``X (X'X)^-1`` (LS) or ``Z (X'Z)^-1`` (IV).
    """

    theta: Array
    residuals: Array
    inverse_factor: Array
    influence: Array


def factor(columns: Array, names: Sequence[str], what: str = "the record") -> Factored:
    """Factor a regressor or instruments.

    Parameters
    ----------
    columns : (n, k) array
    names : sequence of str
        Of the k columns' parameters.
    what : str
        Where the columns come from.

    Raises
    ------
    EstimationError
        The columns are not finite or have not full rank; the combination is named.
    """
    n, k = columns.shape
    if n <= k:
        raise EstimationError(
            f"{n} rows are left for {k} parameters; record longer, or decimate or drop less."
        )
    if not np.all(np.isfinite(columns)):
        raise EstimationError(f"the regressor of {what} is not finite; check the signals' size.")
    scale = np.linalg.norm(columns, axis=0)
    silent = [name for name, size in zip(names, scale, strict=True) if size == 0]
    if silent:
        raise EstimationError(
            f"{what} cannot show {', '.join(silent)}: the regressor's column is zero in every row. "
            "Record a motion that excites it, or leave the parameter out."
        )
    q, r = np.linalg.qr(columns / scale)
    _check_rank(r, n, scale, names, what)
    return Factored(
        columns=columns,
        scale=scale,
        basis=q,
        inverse=np.linalg.solve(r, np.eye(k)) / scale[:, None],
        names=tuple(names),
    )


def least_squares(y: Array, X: Factored) -> Solution:
    """``argmin ||y - X theta||``, y of shape (n,)."""
    theta = X.inverse @ (X.basis.T @ y)
    return Solution(
        theta=theta,
        residuals=y - X.columns @ theta,
        inverse_factor=X.inverse,
        influence=X.basis @ X.inverse.T,
    )


def instrumental_variables(y: Array, X: Factored, Z: Factored) -> Solution:
    """``(Z'X)^-1 Z'y``, just identified, y of shape (n,).

    Raises
    ------
    EstimationError
        Z'X has not full rank: the instruments do not see what the regressor sees.

    References
    ----------
    Equation (16) of [Brunot2015]_.
    """
    projected = Z.basis.T @ (X.columns / X.scale)
    _check_rank(projected, len(y), X.scale, X.names, "the instruments together with the record")
    theta = np.linalg.solve(projected, Z.basis.T @ y) / X.scale
    return Solution(
        theta=theta,
        residuals=y - X.columns @ theta,
        inverse_factor=Z.inverse,
        influence=np.linalg.solve(projected, Z.basis.T).T / X.scale,
    )


def condition_number(X: Array) -> float:
    """Largest over smallest singular value, of the columns as they are."""
    return float(np.linalg.cond(X))


def _check_rank(matrix: Array, rows: int, scale: Array, names: Sequence[str], what: str) -> None:
    """Refuse a rank-deficient matrix of scaled columns, naming what cannot be told apart."""
    _, sizes, right = np.linalg.svd(matrix)
    # Unit columns have a largest singular value of 1 or more, unless instruments miss them all.
    # Filtering leaves rounding of up to 1e-12 in columns that are dependent.
    if sizes[-1] > max(sizes[0], 1.0) * max(rows * np.finfo(float).eps, _SMALLEST_RATIO):
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
