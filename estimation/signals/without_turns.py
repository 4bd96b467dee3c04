"""What is left of each parameter without the samples near reversals and rests.

Without them friction is not rounded, which is worth much, but an axis that accelerates only where
it turns hardly shows its inertia. What tells is the information on a parameter, the inverse of its
variance for noise of one size. Rests are no loss, as sticking friction takes any force; nor is
friction that depends on the speed, such as a peak about rest, as the low-pass rounds that near
reversals. Coulomb friction counts: where it loses much, little else tells it from other terms.

Of an axis that is partially linear the columns are those of the Jacobian at the nominal values.
One whose nonlinear parameters are of such friction is not asked: what the low-pass makes of a peak
about rest leads its search astray, however much of the inertia is lost with it.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.support.arrays import Array

from .signals import Signals

_SIGNALS = ("position", "velocity", "acceleration", "direction")  # as the regressor takes them
_SMALLEST = 1e-100  # whose square is exact
_ALIKE = 1e-12  # of a column, in which it is not told from others


def remaining_information(counts: NDArray[np.bool_], moving: Array, left: Array) -> float:
    """The least part of the information on a parameter that is left.

    Parameters
    ----------
    counts : (P,) array of bool
        Of which parameters a loss counts, see `losses_count`.
    moving, left : (P, P) array
        Products of the regressor's columns of all samples in motion, and of those that are left.
    """
    both = moving + left
    if not np.all(np.isfinite(both)):
        return 1.0  # whatever is done, the regression will say what is wrong
    size = np.sqrt(np.diag(both))
    seen = counts & (np.diag(moving) > 0)
    scale = np.outer(*(np.where(size > _SMALLEST, size, 1.0),) * 2)
    before, after = (_information(each / scale) for each in (moving, left))
    return float(np.min(after[seen] / before[seen], initial=1.0))


def losses_count(axis: GeneratedAxis) -> NDArray[np.bool_]:
    """Of which parameters, (p,), a loss counts: none of friction that depends on the speed."""
    depends = dependence(axis)
    return ~(depends["direction"] & depends["velocity"])


def columns_of(axis: GeneratedAxis, signals: Signals) -> Array:
    """Of the inverse model, (N, p), for each of its parameters."""
    motion = (signals.position, signals.velocity, signals.acceleration, signals.direction)
    about = () if axis.is_linear else (_about(axis),)
    columns, _ = axis.evaluate("idm_regressor", *motion, *signals.recorded, *about)
    return columns


def searches_friction(axis: GeneratedAxis) -> bool:
    """Whether a nonlinear parameter is of friction that depends on the speed."""
    depends = dependence(axis)
    return bool(np.any(np.array(axis.nonlinear) & depends["direction"] & depends["velocity"]))


def _about(axis: GeneratedAxis) -> Array:
    """Where a partially linear model is linearised: an amount of 0 would hide what it scales."""
    hidden = (axis.nominal == 0) & ~np.array(axis.nonlinear)
    return np.where(hidden, 1.0, axis.nominal)


@lru_cache(maxsize=32)  # asked of an axis in every identification
def dependence(axis: GeneratedAxis) -> dict[str, NDArray[np.bool_]]:
    """Which columns of the inverse model, (p,), depend on which signal."""
    return {name: _depending(axis, place) for place, name in enumerate(_SIGNALS)}


def of_signals(axis: GeneratedAxis) -> NDArray[np.bool_]:
    """Which columns of the inverse model, (p,), depend on a recorded signal."""
    places = range(len(_SIGNALS), len(_SIGNALS) + len(axis.axis.signals))
    found = [_depending(axis, place) for place in places]
    none = np.zeros(len(axis.parameters), dtype=bool)
    return np.asarray(np.any([none, *found], axis=0))


def _depending(axis: GeneratedAxis, place: int) -> NDArray[np.bool_]:
    """Which columns of the inverse model, (p,), depend on what it takes at a place."""
    rows, _ = axis.functions["idm_regressor"].jac_sparsity(0, place).get_triplet()
    return np.isin(np.arange(len(axis.parameters)), rows)


def _information(gram: Array) -> Array:
    """Of each parameter beside the others, (p,), from products of columns of size 1 or less."""
    inverse = np.linalg.inv(gram + _ALIKE * np.eye(len(gram)))
    return np.asarray(1.0 / np.diag(inverse), dtype=float)
