"""Base class of the methods of estimation, and the fit that they make of a problem."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field

from axisid.estimation.choices import INSTRUMENT_STARTS, ROW_LOSSES
from axisid.estimation.estimates import Iterate, NotSimulated
from axisid.estimation.estimation_problem import Problem, Solver
from axisid.estimation.regression import Equations, Form, Solution
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds import MAX_SIMULATION_ERROR
from axisid.support.arrays import Array, relative_error_percent

_NO_LOOP = NotSimulated("the method simulates no loop")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A solution of measured rows, with the loops simulated from it.

    Attributes
    ----------
    form : Form
        Form of the regression; that of a nonlinear model is linearised about its least-squares
        estimate.
    measured : Equations
        Measured rows that were solved.
    solution : Solution
        Solution of the measured rows.
    solver : Solver
        Solver of the measured rows, which solves other rows in the same way.
    iterates : tuple of Iterate
        The start and every iterate; empty without an iteration.
    started : str
        Start of the iteration, of `INSTRUMENT_STARTS`; empty without an iteration.
    loops : tuple of Simulation
        Loops that were simulated with the solution, one for each segment of each record; empty
        where no loop could be, or had to be, simulated.
    right : Equations or None
        Rows of `loops`; None where the method did not compute these rows.
    simulated : (n,) array or NotSimulated
        Left side of the model along the simulated loops, or the reason why no loop was simulated.
    remarks : tuple of str
        Remarks for the user.
    """

    form: Form
    measured: Equations
    solution: Solution
    solver: Solver = field(default_factory=Solver)
    iterates: tuple[Iterate, ...] = ()
    started: str = ""
    loops: tuple[Simulation, ...] = ()
    right: Equations | None = None
    simulated: Array | NotSimulated = _NO_LOOP
    remarks: tuple[str, ...] = ()

    @property
    def physical(self) -> Array:
        """Physical parameters of the solution, (p,)."""
        return self.form.physical(self.solution.theta)[0]

    @property
    def simulation_error_percent(self) -> float:
        """Difference of measured and simulated left side, percent of the measured one (rms).

        Infinite where no loop was simulated.
        """
        left = self.measured.left
        if isinstance(self.simulated, NotSimulated):
            return math.inf
        return relative_error_percent(left - self.simulated, left)

    @property
    def follows(self) -> bool:
        """True if the simulated loops follow the records, so that they can represent the records.

        Their simulation error must be below `MAX_SIMULATION_ERROR`. False without loops.
        """
        return self.simulation_error_percent < MAX_SIMULATION_ERROR.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Method(ABC):
    """A method of estimation from the rows of a problem.

    Attributes
    ----------
    name : str
        Name that users give, such as ``idm-ls``.
    form : type of Form
        Form of the regression.
    start : str
        Start of an iteration, of `INSTRUMENT_STARTS`; least squares only if its loop follows the
        records.
    loss : str
        Loss of the rows, of `ROW_LOSSES`.
    """

    name: str
    form: type[Form]
    start: str = INSTRUMENT_STARTS[0]
    loss: str = ROW_LOSSES[0]

    def fitted(self, problem: Problem) -> Fit:
        """Return the fit of a problem by this method, computed once for each problem; see `fit`."""
        if self not in problem.made:
            problem.made[self] = self.fit(problem)
        found: Fit = problem.made[self]
        return found

    @abstractmethod
    def fit(self, problem: Problem) -> Fit:
        """Solve the rows of a problem, and return the solution with the loops simulated from it.

        Raises
        ------
        ModelError
            The axis has no such form.
        EstimationError
            The rows cannot be solved; what is missing is named.
        """
