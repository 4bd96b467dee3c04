"""What a method of estimation is, and what it makes of a problem."""

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
        At the point that the rows are linearised about.
    measured : Equations
    solution : Solution
    solver : Solver
        What solved the rows, and solves others as it did.
    iterates : tuple of Iterate
        The start and every iterate; empty for what is no iteration.
    started : str
        Where the iteration started, of `INSTRUMENT_STARTS`; empty for what is no iteration.
    loops : tuple of Simulation
        One for each segment of each record; empty where they could not be simulated.
    right : Equations or None
        Rows of the loops, where they were simulated with the solution.
    simulated : (n,) array or NotSimulated
        Left side as the simulated loops have it.
    remarks : tuple of str
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
        """Physical parameters, (p,)."""
        return self.form.physical(self.solution.theta)[0]

    @property
    def simulation_error_percent(self) -> float:
        """What the simulated loops leave of the left side; infinite where there are none."""
        left = self.measured.left
        if isinstance(self.simulated, NotSimulated):
            return math.inf
        return relative_error_percent(left - self.simulated, left)

    @property
    def follows(self) -> bool:
        """Whether the simulated loops move as the records do, so that they stand for them."""
        return self.simulation_error_percent < MAX_SIMULATION_ERROR.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Method(ABC):
    """A way from a problem's rows to an estimate.

    Attributes
    ----------
    name : str
        As users give it, ``idm-ls``.
    form : type of Form
        That is regressed.
    start : str
        Of `INSTRUMENT_STARTS`, where an iteration starts; least squares only where its loop follows
        records.
    loss : str
        Of `ROW_LOSSES`, how rows count.
    """

    name: str
    form: type[Form]
    start: str = INSTRUMENT_STARTS[0]
    loss: str = ROW_LOSSES[0]

    def fitted(self, problem: Problem) -> Fit:
        """The fit of a problem, which is made once; see `fit`."""
        if self not in problem.made:
            problem.made[self] = self.fit(problem)
        found: Fit = problem.made[self]
        return found

    @abstractmethod
    def fit(self, problem: Problem) -> Fit:
        """Solve the rows.

        Raises
        ------
        ModelError
            The axis has no such form.
        EstimationError
            The rows cannot be solved; what is missing is named.
        """
