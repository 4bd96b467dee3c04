"""What a method makes of a problem, before it is mapped to physical parameters and judged."""

from dataclasses import dataclass

from axisid.estimation.regression import Equations, Factored, Form, Solution
from axisid.estimation.simulation import Simulation
from axisid.support.arrays import Array, relative_error_percent

from .estimate import FOLLOWING, Iterate


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A solution of measured rows, with the loops simulated from it.

    Attributes
    ----------
    form : Form
        At the point that the rows are linearised about.
    measured : Equations
    solution : Solution
    instruments : Factored or None
        None for least squares.
    iterates : tuple of Iterate
        The start and every iterate; empty for what is no iteration.
    loops : tuple of Simulation
        One for each segment of each record; empty where they could not be simulated.
    simulated : (n,) array or None
        Left side as the simulated loops have it.
    remarks : tuple of str
    not_simulated : str
        Why the loop cannot be simulated with the estimate, if it is the estimate's fault.
    """

    form: Form
    measured: Equations
    solution: Solution
    instruments: Factored | None = None
    iterates: tuple[Iterate, ...] = ()
    loops: tuple[Simulation, ...] = ()
    simulated: Array | None = None
    remarks: tuple[str, ...] = ()
    not_simulated: str = ""

    @property
    def follows(self) -> bool:
        """Whether the simulated loops move as the records do, so that they stand for them."""
        if self.simulated is None:
            return False
        left = self.measured.left
        return relative_error_percent(left - self.simulated, left) < FOLLOWING
