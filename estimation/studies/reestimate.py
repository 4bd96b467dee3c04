"""Parameters estimated anew from the record that frozen ones are held against.

An equation error tells little of a parameter that scales a small part of the force: a mass a tenth
larger leaves 6 % of the force where noise may leave as much. What the record itself says of the
parameters, by the same method, tells it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, ndtri_exp, stdtr

from axisid.estimation.regression import (
    Equations,
    Form,
    Hac,
    factor,
    instrumental_variables,
    least_squares,
)
from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError

# % of force otherwise: measured, a mass a tenth larger makes 2 to 6, right records of 15 s at
# most 1.3
MAX_REESTIMATE_SHARE = 1.0
# deviations: measured, at most 4 on right records, 5.4 on one of 2 s whose noise lasts 0.5 s; 6.1
# and more with a mass a tenth larger
_MIN_REESTIMATE_DISTANCE = 5.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Reestimate:
    """A frozen estimate beside one that the second record itself gives, by the same method.

    Attributes
    ----------
    names, units : tuple of str
        Of the p physical parameters.
    frozen, physical : (p,) array
        As they were, and as the second record has them.
    distances : (p,) array
        Between them, in deviations (HAC) of their difference; as of a normal variable with the
        chance that Student's t has of what is farther, since deviations of short records are vague.
    share_percent : float
        Force that the difference makes on the second record, percent of all of it.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    frozen: Array
    physical: Array
    distances: Array
    share_percent: float

    @property
    def changed(self) -> tuple[str, ...]:
        """Parameters that are others on the second record; none where it makes no difference."""
        if not self.share_percent > MAX_REESTIMATE_SHARE:
            return ()
        far = np.abs(self.distances) > _MIN_REESTIMATE_DISTANCE
        return tuple(name for name, is_far in zip(self.names, far, strict=True) if is_far)

    def text(self) -> str:
        """The parameters that are others, in words."""
        rows = zip(self.names, self.units, self.frozen, self.physical, strict=True)
        return ", ".join(
            f"{name} {there:.4g} {unit} in place of {own:.4g}"
            for name, unit, own, there in rows
            if name in self.changed
        )


def reestimate(
    form: Form,
    rows: Equations,
    instruments: Array | None,
    neighbours: Neighbours,
    frozen: Array,
    covariance: Array,
    freedom: Array,
) -> Reestimate | None:
    """Estimate from rows of the second record; None where they cannot tell the parameters.

    Parameters
    ----------
    form : Form
        About the frozen parameters.
    rows : Equations
        Of the second record, filtered; for DIDIM its force and the rows of the loop that it leads
        to, or of the one that is simulated with the frozen parameters where it leads to none.
    instruments : (n, k) array or None
        From its loop, simulated with the frozen parameters; None for least squares.
    neighbours : Neighbours
        Of the rows.
    frozen : (p,) array
        Physical parameters.
    covariance : (p, p) array
        Theirs.
    freedom : (p,) array
        Degrees of freedom of its variances.
    """
    names = [q.label for q in form.quantities]
    left = rows.left - rows.intercept
    try:
        regressor = factor(rows.regressor, names, neighbours=neighbours)
        solution = (
            least_squares(left, regressor)
            if instruments is None
            else instrumental_variables(left, regressor, factor(instruments, names))
        )
        physical, jacobian = form.physical(solution.theta)
        applied = Hac().applied(solution)  # of few scores too, as an estimate's own
        here = np.diag(jacobian @ applied.matrix @ jacobian.T)
        least = float(applied.freedom.min())
    except EstimationError:
        return None
    own = np.diag(covariance)
    # Welch and Satterthwaite's degrees of freedom of a difference.
    freedoms = (here + own) ** 2 / (here**2 / least + own**2 / freedom)
    change = rows.regressor @ (solution.theta - form.regressed(frozen))
    found = Reestimate(
        names=tuple(p.name for p in form.axis.parameters),
        units=tuple(p.unit for p in form.axis.parameters),
        frozen=frozen,
        physical=physical,
        distances=as_normal((physical - frozen) / np.sqrt(here + own), freedoms),
        share_percent=relative_error_percent(change, rows.left),
    )
    return found if np.all(np.isfinite([*physical, *found.distances])) else None


def as_normal(distances: Array, freedom: Array | float) -> Array:
    """Distances in vague deviations as those of a normal variable that chance exceeds as often."""
    chance = stdtr(freedom, -np.abs(distances))
    # Of chances that no number holds the distance itself, where the freedom is large.
    with np.errstate(divide="ignore"):
        logs = np.where(chance > 0, np.log(chance), log_ndtr(-np.abs(distances)))
    return np.asarray(-np.sign(distances) * ndtri_exp(logs))


def least_mean_square(residuals: Array, neighbours: Neighbours) -> float:
    """The least mean square that residuals (n,) stand for, where a few slow waves are all of it."""
    squares = residuals**2
    mean = float(squares.mean())
    try:
        ones = factor(np.ones((len(squares), 1)), ["mean"], neighbours=neighbours)
        solution = least_squares(squares, ones)
        # Squares are no errors that a fit has taken the slow part of: the kernel's is enough.
        deviation = float(np.sqrt(Hac(widened=False).matrix(solution)[0, 0]))
    except EstimationError:
        return mean
    return max(mean - MIN_DISTANCE_FROM_NOISE.value * deviation, 0.0)
