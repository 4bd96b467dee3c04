"""The two forms of least squares against each other: one correlation parts them.

The inverse model regresses the force on the acceleration, the direct one the acceleration on the
force, and on the same other columns. By the theorem of Frisch, Waugh and Lovell the inertia of the
one times the factor of the force of the other is then the squared partial correlation of force and
acceleration, whatever the noise: on one set of rows the direct inertia is never the smaller.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from axisid.estimation.estimates import Estimate, alike_corrected
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array
from axisid.support.missing import Missing

_SAME = 1e-9  # of a column
_OTHER_LOSS = Missing("the two forms weigh rows by residuals of their own, by their loss")
NO_ATTENUATION = Missing("idm-ls and ddm-ls are not there both, of a linear model")
_OTHER_COLUMNS = Missing(
    "force and acceleration are no columns of the two forms, beside others that are the same"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Attenuation:
    """How much noise, or what the model lacks, parts the inertias of the two forms.

    Attributes
    ----------
    parameter : str
        The inertia.
    inverse, direct : float
        As least squares of the inverse and of the direct model have it.
    r_squared : float
        Squared partial correlation of force and acceleration, the other columns given; what is
        left of it is the share by which noise parts the two.
    identity_error : float
        Relative distance of `inverse` over `direct` from it: rounding.
    shift : float
        Distance of the two in deviations of the inverse model's, both less what filter and noise
        move them by where that is known.
    """

    parameter: str
    inverse: float
    direct: float
    r_squared: float
    identity_error: float
    shift: float

    @property
    def parted(self) -> float:
        """Share by which the inverse inertia is below the direct one."""
        return 1 - self.r_squared


def attenuation(data: FilteredRecord, estimates: Mapping[str, Estimate]) -> Attenuation | Missing:
    """Compare the two forms of least squares.

    Parameters
    ----------
    data : FilteredRecord
        Whose rows both are of.
    estimates : mapping of str to Estimate
        By method.

    References
    ----------
    [FrischWaugh1933]_, [Lovell1963]_; that the truth lies between the two where the noises of
    force and acceleration are independent is due to [Frisch1934]_.
    """
    inverse, direct = estimates.get("idm-ls"), estimates.get("ddm-ls")
    if inverse is None or direct is None or not data.axis.is_linear:
        return NO_ATTENUATION
    if inverse.counts is not None or direct.counts is not None:
        return _OTHER_LOSS
    acceleration = np.ravel(data.reduce(data.signals.acceleration))
    force = inverse.residuals + inverse.X @ inverse.theta  # without what no parameter scales
    own, other = _alone(inverse.X, acceleration), _alone(direct.X, force)
    left = direct.residuals + direct.X @ direct.theta
    if own is None or other is None or not _is_along(left, acceleration):
        return _OTHER_COLUMNS
    beside, beside_direct = np.delete(inverse.X, own[0], 1), np.delete(direct.X, other[0], 1)
    if not np.allclose(_less(beside_direct, beside), 0.0, atol=_SAME):
        return _OTHER_COLUMNS
    f, a = _less(force[:, None], beside)[:, 0], _less(acceleration[:, None], beside)[:, 0]
    r_squared = float((f @ a) ** 2 / ((f @ f) * (a @ a)))
    mass = float(inverse.theta[own[0]]) * own[1]
    mobility = float(direct.theta[other[0]]) * other[1]
    value = inverse.parameters[inverse.quantities[own[0]].name]
    parted = abs(np.subtract(*alike_corrected(inverse, direct))[own[0]])
    return Attenuation(
        parameter=inverse.quantities[own[0]].name,
        inverse=mass / own[1],
        direct=1 / mobility / own[1],
        r_squared=r_squared,
        identity_error=abs(mass * mobility / r_squared - 1),
        shift=float(parted / value.deviation) if value.deviation > 0 else 0.0,
    )


def _alone(columns: Array, wanted: Array) -> tuple[int, float] | None:
    """Which of the columns is a multiple of another, and of how much of it."""
    for j, column in enumerate(columns.T):
        if _is_along(column, wanted):
            return j, float(column @ wanted / (wanted @ wanted))
    return None


def _is_along(column: Array, wanted: Array) -> bool:
    left = _less(column[:, None], wanted[:, None])
    return bool(np.all(np.abs(left) <= _SAME))


def _less(columns: Array, others: Array) -> Array:
    """Unit columns without what others explain of them."""
    unit = columns / np.linalg.norm(columns, axis=0)
    if not others.shape[1]:
        return np.asarray(unit, dtype=float)
    basis = np.linalg.qr(others / np.linalg.norm(others, axis=0))[0]
    once = unit - basis @ (basis.T @ unit)
    return np.asarray(once - basis @ (basis.T @ once), dtype=float)
