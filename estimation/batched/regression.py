"""Instrumental variables and least squares of lanes, by normal equations that are refined.

Columns are scaled to unit norm; the equations of the residuals are solved once more, which leaves
the digits that a factorisation has as long as the columns are not nearly dependent. Lanes of which
that is not so are told, and solved elsewhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array

_MOST_CONDITION = 1e6  # of the scaled products: digits are lost beyond
_ROUNDS = 2


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


def products(one: Array, other: Array) -> Array:
    """``sum a_t b_t'`` of columns (n, p, L) and (n, q, L), (L, p, q)."""
    found = np.array([[np.einsum("nl,nl->l", a, b) for b in _each(other)] for a in _each(one)])
    return np.asarray(found.transpose(2, 0, 1))


def _each(columns: Array) -> list[Array]:
    return [columns[:, i] for i in range(columns.shape[1])]


def norms(columns: Array) -> Array:
    """Of columns (n, p, L), (L, p)."""
    return np.asarray(np.sqrt(np.einsum("npl,npl->lp", columns, columns)))


def fitted(regressor: Array, theta: Array) -> Array:
    """``X theta`` of lanes, (n, L), for parameters (L, p)."""
    return np.asarray(np.einsum("npl,lp->nl", regressor, theta))


def solved(left: Array, regressor: Array, instruments: Array) -> LaneSolutions:
    """``(Z'X)^-1 Z'y`` of lanes; least squares where the instruments are the regressor.

    Parameters
    ----------
    left : (n, L) array
    regressor, instruments : (n, p, L) array
    """
    by, scale = norms(instruments), norms(regressor)
    with np.errstate(all="ignore"):
        scaled = products(instruments, regressor) / by[:, :, None] / scale[:, None, :]
    finite = np.isfinite(scaled).all(axis=(1, 2)) & np.isfinite(left).all(axis=0)
    scaled[~finite] = np.eye(scaled.shape[1])
    sound = finite & (np.linalg.cond(scaled) < _MOST_CONDITION)
    scaled[~sound] = np.eye(scaled.shape[1])
    inverse = np.linalg.inv(scaled)
    mixing = inverse / scale[:, :, None] / by[:, None, :]
    theta = np.zeros_like(scale)
    residuals = left
    for _ in range(1 + _ROUNDS):
        step = products(instruments, residuals[:, None])[:, :, 0]
        theta = theta + np.einsum("lpq,lq->lp", mixing, step)
        residuals = left - fitted(regressor, theta)
    return LaneSolutions(
        theta=theta,
        residuals=residuals,
        mixing=mixing,
        power=np.einsum("nl,nl->l", residuals, residuals),
        sound=sound,
    )


def inverse_products(columns: Array) -> Array:
    """``(Z'Z)^-1`` of columns (n, p, L), (L, p, p); those of the identity where there is none."""
    scale = norms(columns)
    with np.errstate(all="ignore"):
        scaled = products(columns, columns) / scale[:, :, None] / scale[:, None, :]
    bad = ~np.isfinite(scaled).all(axis=(1, 2))
    scaled[bad] = np.eye(scaled.shape[1])
    return np.asarray(np.linalg.inv(scaled) / scale[:, :, None] / scale[:, None, :])
