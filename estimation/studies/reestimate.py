"""Parameters estimated anew from the record that frozen ones are held against.

An equation error tells little of a parameter that scales a small part of the force: a mass a tenth
larger leaves 6 % of the force where noise may leave as much. What the record itself says of the
parameters, by the same method and with twins of its own, tells it: as of two records of one
regression, the difference is tested, and has to matter.
"""

import numpy as np

from axisid.estimation.checks import Levels
from axisid.estimation.diagnostics import Difference, OwnColumns
from axisid.estimation.estimates import Distribution, Estimate
from axisid.estimation.regression import Hac, factor, least_squares
from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError


def reestimated(frozen: Distribution, own: Estimate, levels: Levels) -> Difference | None:
    """What a second record has more than frozen parameters, by its own estimate of one method.

    Parameters
    ----------
    frozen : Distribution
    own : Estimate
        Of the second record.
    levels : Levels
        From when on the difference tells something.

    Returns
    -------
    Difference or None
        Less their bias where that is known of both; None where the second record's own tell
        nothing.
    """
    anew = own.distribution
    biased = frozen.bias is None or anew.bias is None
    before, after = (each.theta if biased else each.corrected for each in (frozen, anew))
    covariances = [each.covariances[frozen.chosen] for each in (frozen, anew)]
    if not np.all(np.isfinite([after, *covariances[0], *covariances[1]])):
        return None
    variances = np.array([np.diag(each) for each in covariances])
    freedoms = np.array([each.freedom[frozen.chosen] for each in (frozen, anew)])
    # Welch and Satterthwaite's degrees of freedom of a difference.
    with np.errstate(invalid="ignore"):
        freedom = variances.sum(axis=0) ** 2 / (variances**2 / freedoms).sum(axis=0)
    by_physical = own.X @ np.linalg.inv(own.jacobian)
    record = OwnColumns(
        names=tuple(q.name for q in own.quantities),
        units=tuple(q.unit for q in own.quantities),
        values=before,
        slopes=np.zeros_like(own.jacobian),
        span=slice(0, len(own.y)),
        columns=by_physical,
        instruments=by_physical,
        size=float(np.linalg.norm(own.y)),
    )
    return Difference(
        number=0,
        of=record,
        difference=after - before,
        covariances=(covariances[0] + covariances[1], covariances[1], covariances[0]),
        freedom=float(np.nanmin(freedom)),
        untold=(),
        levels=levels,
    )


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
