"""Information that the samples of a motion contain on the parameters of an axis.

Without the samples near reversals and rests the low-pass does not round the friction, which is a
large gain; but an axis that accelerates only where it reverses then hardly shows its inertia. The
criterion is the information on a parameter, the inverse of its variance for noise of a fixed
variance. Samples at rest are no loss, as sticking friction takes any force; nor are those of
friction that depends on speed, such as a peak about rest, as the low-pass rounds it near reversals.
Coulomb friction counts: where it loses much information, it is hardly separable from other terms.

For a partially linear axis the columns are those of the Jacobian at the nominal values. The
criterion does not apply to an axis with nonlinear parameters of speed-dependent friction: the
rounded peak about rest would mislead the search, whatever information on the inertia is lost.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.support.arrays import Array

from .signals import Signals

_SIGNALS = ("position", "velocity", "acceleration", "direction")  # as the regressor takes them
_SMALLEST = 1e-100  # smaller values have inexact squares
_RIDGE = 1e-12  # relative to a column: added so that dependent columns can be inverted


def remaining_information(counts: NDArray[np.bool_], moving: Array, remaining: Array) -> float:
    """Return the smallest ratio over the parameters of the remaining to the whole information.

    The information on parameter j is ``1 / [(X'X)^-1]_jj``.

    Parameters
    ----------
    counts : (P,) array of bool
        True for parameters that are considered, see `loss_counts_for`.
    moving, remaining : (P, P) array
        ``X'X`` of all samples in motion, and of the remaining samples.
    """
    both = moving + remaining
    if not np.all(np.isfinite(both)):
        return 1.0  # the regression refuses such a record with a reason
    size = np.sqrt(np.diag(both))
    counted = counts & (np.diag(moving) > 0)
    scale = np.outer(*(np.where(size > _SMALLEST, size, 1.0),) * 2)
    ridge = _RIDGE * np.eye(len(both))
    # Information on each parameter with all others unknown.
    before, after = (
        1 / np.diag(np.linalg.inv(each / scale + ridge)) for each in (moving, remaining)
    )
    return float(np.min(after[counted] / before[counted], initial=1.0))


def loss_counts_for(axis: GeneratedAxis) -> NDArray[np.bool_]:
    """Return True for parameters whose loss of information matters, (p,).

    It is False for parameters of friction that depends on speed.
    """
    depends = columns_by_signal(axis)
    return ~(depends["direction"] & depends["velocity"])


def columns_of(axis: GeneratedAxis, signals: Signals) -> Array:
    """Return the columns of the inverse model, or of its Jacobian, for each parameter, (N, p)."""
    motion = (signals.position, signals.velocity, signals.acceleration, signals.direction)
    # Factors of 0 are set to 1, as a factor of 0 would hide the terms that it scales.
    hidden = (axis.nominal == 0) & ~np.array(axis.nonlinear)
    about = () if axis.is_linear else (np.where(hidden, 1.0, axis.nominal),)
    columns, _ = axis.evaluate("idm_regressor", *motion, *signals.recorded, *about)
    return columns


def searches_friction(axis: GeneratedAxis) -> bool:
    """Return True if a nonlinear parameter belongs to friction that depends on speed."""
    return bool(np.any(np.array(axis.nonlinear) & ~loss_counts_for(axis)))


@lru_cache(maxsize=32)  # asked of an axis in every identification
def columns_by_signal(axis: GeneratedAxis) -> dict[str, NDArray[np.bool_]]:
    """Return for each signal True for the columns of the inverse model that depend on it, (p,)."""
    depends = dict.fromkeys((*_SIGNALS, "recorded"), np.zeros(len(axis.parameters), dtype=bool))
    names = (*_SIGNALS, *("recorded" for _ in axis.signals))
    for place, name in enumerate(names):
        rows, _ = axis.functions["idm_regressor"].jac_sparsity(0, place).get_triplet()
        depends[name] = depends[name] | np.isin(np.arange(len(axis.parameters)), rows)
    return depends
