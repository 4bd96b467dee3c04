"""Instrumental variables and least squares of lanes, by normal equations that are refined.

Columns are scaled to unit norm; the equations of the residuals are solved once more, which leaves
the digits that a factorisation has as long as the columns are not nearly dependent. Lanes of which
that is not so are told, and solved elsewhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.native import LaneLibrary
from axisid.support.arrays import Array

_MOST_CONDITION = 1e6  # of the scaled products: digits are lost beyond


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneSolutions:
    """Solutions of lanes.

    Attributes
    ----------
    theta : (L, p) array
    residuals : (n, L) array
    mixing : (L, p, p) array
        ``(Z'X)^-1``.
    power : (L,) array
        Of the residuals.
    sound : (L,) array of bool
        Where the products are well conditioned.
    """

    theta: Array
    residuals: Array
    mixing: Array
    power: Array
    sound: NDArray[np.bool_]


def products(library: LaneLibrary, one: Array, other: Array) -> Array:
    """``sum a_t b_t'`` of columns (n, p, L) and (n, q, L), (L, p, q), each lane by itself."""
    return library.products(one, other).transpose(2, 0, 1)


def row_counts(rows: NDArray[np.bool_] | None, shape: tuple[int, ...]) -> Array:
    """How many rows each lane has, (L,)."""
    return np.full(shape[1], float(shape[0])) if rows is None else rows.sum(axis=0).astype(float)


def combined(columns: Array, matrices: Array) -> Array:
    """Columns (n, p, L), each a sum of all by the matrices of the lanes (L, p, p), (n, p, L)."""
    every = range(columns.shape[1])
    made = [sum(columns[:, j] * matrices[:, i, j] for j in every) for i in every]
    return np.stack(made, axis=1)


def fitted(regressor: Array, theta: Array) -> Array:
    """``X theta`` of lanes, (n, L), for parameters (L, p)."""
    every = range(theta.shape[1])
    return np.asarray(sum(regressor[:, i] * theta[:, i] for i in every))


def solved(
    library: LaneLibrary, left: Array, regressor: Array, instruments: Array
) -> LaneSolutions:
    """``(Z'X)^-1 Z'y`` of lanes; least squares where the instruments are the regressor.

    Parameters
    ----------
    library : LaneLibrary
    left : (n, L) array
    regressor, instruments : (n, p, L) array
    """
    together = products(library, instruments, regressor)
    aside = products(library, instruments, left[:, None])[:, :, 0]
    by, scale = norms(library, instruments), norms(library, regressor)
    with np.errstate(all="ignore"):
        scaled = together / by[:, :, None] / scale[:, None, :]
    finite = np.isfinite(scaled).all(axis=(1, 2)) & np.isfinite(aside).all(axis=1)
    scaled[~finite] = np.eye(scaled.shape[1])
    sound = finite & (np.linalg.cond(scaled) < _MOST_CONDITION)
    scaled[~sound] = np.eye(scaled.shape[1])
    with np.errstate(all="ignore"):
        mixing = np.linalg.inv(scaled) / scale[:, :, None] / by[:, None, :]
    theta = _applied(mixing, aside)
    residuals = left - fitted(regressor, theta)
    step = products(library, instruments, residuals[:, None])[:, :, 0]
    theta = theta + _applied(mixing, step)
    residuals = left - fitted(regressor, theta)
    return LaneSolutions(
        theta=theta,
        residuals=residuals,
        mixing=mixing,
        power=products(library, residuals[:, None], residuals[:, None])[:, 0, 0],
        sound=sound,
    )


def inverse_products(library: LaneLibrary, columns: Array) -> Array:
    """``(Z'Z)^-1`` of columns (n, p, L), (L, p, p); of no meaning where there is none."""
    with np.errstate(all="ignore"):
        raw = products(library, columns, columns)
        scale = np.sqrt(np.diagonal(raw, axis1=1, axis2=2))
        scaled = raw / scale[:, :, None] / scale[:, None, :]
        scaled[~np.isfinite(scaled).all(axis=(1, 2))] = np.eye(scaled.shape[1])
        return np.asarray(np.linalg.pinv(scaled) / scale[:, :, None] / scale[:, None, :])


def _applied(matrices: Array, vectors: Array) -> Array:
    """``M v`` of lanes, (L, p)."""
    return np.asarray((matrices * vectors[:, None, :]).sum(axis=2))


def norms(library: LaneLibrary, columns: Array) -> Array:
    """Of columns (n, p, L), (L, p)."""
    return np.asarray(np.sqrt(library.lagged(columns, 0)[0].T))
