"""Parameters estimated anew from the record that frozen ones are held against.

An equation error tells little of a parameter that scales a small part of the force: a mass a tenth
larger leaves 6 % of the force where noise may leave as much. What the record itself says of the
parameters, by the same method and with twins of its own, tells it: as of two records of one
regression, the difference is tested, and has to matter.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.checks import Levels
from axisid.estimation.diagnostics import Difference, OwnColumns
from axisid.estimation.estimates import Distribution, Estimate
from axisid.estimation.regression import Hac, factor, least_squares
from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError


@dataclass(frozen=True, slots=True, kw_only=True)
class Reestimate:
    """A frozen estimate beside one that the second record itself gives, by the same method.

    Attributes
    ----------
    difference : Difference
        What the second record has more.
    levels : Levels
        From when on that tells something.
    """

    difference: Difference
    levels: Levels

    @classmethod
    def of(cls, frozen: Distribution, own: Estimate, levels: Levels) -> "Reestimate | None":
        """Of frozen parameters and the second record's own; None where these tell nothing."""
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
        difference = Difference(
            number=0,
            of=record,
            difference=after - before,
            covariances=(covariances[0] + covariances[1], covariances[1], covariances[0]),
            freedom=float(np.nanmin(freedom)),
            untold=(),
        )
        return cls(difference=difference, levels=levels)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the p physical parameters."""
        return self.difference.of.names

    @property
    def physical(self) -> Array:
        """As the second record has them, (p,), less their bias where that is known of both."""
        return self.difference.apart.own

    @property
    def distances(self) -> Array:
        """From the frozen ones, in deviations of the difference, (p,)."""
        return self.difference.difference / self.difference.apart.deviations

    @property
    def share_percent(self) -> float:
        """Force that the difference makes on the second record, percent of all of it."""
        return self.difference.apart.share_percent

    @property
    def changed(self) -> tuple[str, ...]:
        """Parameters that are others on the second record; none where it makes no difference."""
        if not self.difference.apart.matters(self.levels):
            return ()
        return self.difference.explained(self.levels).of.names

    def text(self) -> str:
        """The parameters that are others, in words."""
        explained = self.difference.explained(self.levels)
        return explained.told("this record", "the estimate's own")


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
