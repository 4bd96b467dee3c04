"""What was simulated with an estimate on the way to it, or why nothing was."""

from dataclasses import dataclass

from axisid.support.arrays import Array, Exact
from axisid.support.missing import Missing


@dataclass(frozen=True, slots=True)
class NotSimulated(Missing):
    """Why no loop was simulated with an estimate.

    Attributes
    ----------
    by_estimate : bool
        Whether its law and its reference are there and the estimate is at fault: too stiff, no
        inertia, diverging.
    """

    by_estimate: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Iterate(Exact):
    """One iterate of the instrumental-variable estimate.

    Attributes
    ----------
    physical : (p,) array
    theta : (k,) array
        In the regression's own parameters.
    simulation_error_percent : float
        Of the loop simulated with it.
    """

    physical: Array
    theta: Array
    simulation_error_percent: float
