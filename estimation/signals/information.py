"""Information that the samples of a motion contain on the parameters of an axis.

Near reversals and rests the low-pass rounds the friction, so these samples are left out. But if an
axis accelerates only at reversals, the other samples have little information on its inertia. The
criterion is the information on a parameter: the inverse of its variance for noise of a fixed
variance. Samples at rest are not counted as a loss, as sticking friction can have any force. The
parameters of friction that depends on speed, such as a peak near rest, are not considered, as the
low-pass rounds this friction near reversals. Coulomb friction is considered: if it loses much
information, it is hardly separable from other terms.

For a partially linear axis the columns are those of the Jacobian at the nominal values. The
criterion does not apply to an axis with nonlinear parameters of speed-dependent friction: the
rounded peak near rest would bias their estimates, however much information on the inertia is lost.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.support.arrays import Array

from .signals import Signals

_SIGNALS = ("position", "velocity", "acceleration", "direction")  # in the regressor's order
_SMALLEST = 1e-100  # smaller column norms have inexact squares
_RIDGE = 1e-12  # added to the diagonal of the scaled X'X, which dependent columns make singular


def remaining_information(counts: NDArray[np.bool_], moving: Array, remaining: Array) -> float:
    """Return the smallest ratio of remaining to whole information over the parameters, 0 to 1.

    The information on parameter j is ``1 / [(X'X)^-1]_jj``. The ratio is 1 if no parameter is
    considered, or if the matrices are not finite.

    Parameters
    ----------
    counts : (P,) array of bool
        True for parameters that are considered: all except those of friction that depends on
        speed, see `is_speed_friction`.
    moving, remaining : (P, P) array
        ``X'X`` of all samples in motion, and of the remaining samples.
    """
    both = moving + remaining
    if not np.all(np.isfinite(both)):
        return 1.0  # the regression refuses such a record with a reason
    # Scale the columns to norm 1; columns of 0 are not scaled.
    norms = np.sqrt(np.diag(both))
    norms = np.where(norms > _SMALLEST, norms, 1.0)
    counted = counts & (np.diag(moving) > 0)
    scale = np.outer(norms, norms)
    ridge = _RIDGE * np.eye(len(both))
    # Information on each parameter with all others unknown.
    before, after = (
        1 / np.diag(np.linalg.inv(each / scale + ridge)) for each in (moving, remaining)
    )
    return float(np.min(after[counted] / before[counted], initial=1.0))


def is_speed_friction(axis: GeneratedAxis) -> NDArray[np.bool_]:
    """Return True for the parameters of friction that depends on speed, such as a peak, (p,).

    The column of such a parameter in the inverse model depends both on the friction direction and
    on the velocity. A loss of information on these parameters is not considered.
    """
    depends = columns_by_signal(axis)
    return depends["direction"] & depends["velocity"]


def columns_of(axis: GeneratedAxis, signals: Signals) -> Array:
    """Return the regressor of the inverse model, (N, p).

    For an axis with nonlinear parameters it is the Jacobian at the nominal values.
    """
    motion = (signals.position, signals.velocity, signals.acceleration, signals.direction)
    # Linear parameters of 0 are set to 1, as 0 would hide the terms that they scale.
    hidden = (axis.nominal == 0) & ~np.array(axis.nonlinear)
    about = () if axis.is_linear else (np.where(hidden, 1.0, axis.nominal),)
    columns, _ = axis.evaluate("idm_regressor", *motion, *signals.recorded, *about)
    return columns


def has_nonlinear_speed_friction(axis: GeneratedAxis) -> bool:
    """Return True if friction that depends on speed has a nonlinear parameter.

    For such an axis, samples near reversals are left out without regard to the lost information.
    """
    return bool(np.any(np.array(axis.nonlinear) & is_speed_friction(axis)))


@lru_cache(maxsize=32)  # needed several times in every identification
def columns_by_signal(axis: GeneratedAxis) -> dict[str, NDArray[np.bool_]]:
    """Return by signal the columns of the inverse model that depend on it, (p,) of bool each.

    The signals are position, velocity, acceleration, direction, and ``recorded`` for all recorded
    signals together.
    """
    depends = dict.fromkeys((*_SIGNALS, "recorded"), np.zeros(len(axis.parameters), dtype=bool))
    names = (*_SIGNALS, *("recorded" for _ in axis.signals))
    for k, name in enumerate(names):
        rows, _ = axis.functions["idm_regressor"].jac_sparsity(0, k).get_triplet()
        depends[name] = depends[name] | np.isin(np.arange(len(axis.parameters)), rows)
    return depends
