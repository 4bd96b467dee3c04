"""What a method of estimation is, and what it makes of a problem before that is judged."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

from axisid.estimation.choices import ROW_LOSSES, STARTS
from axisid.estimation.estimates import Iterate, NotSimulated
from axisid.estimation.problems import ByInstruments, Problem, Solver, by_least_squares
from axisid.estimation.regression import Equations, Form, QrFactors, Solution
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds import MAX_SIMULATION_ERROR
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.remedy import Note

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
    solver : callable
        What solved the rows, and solves others as it did.
    iterates : tuple of Iterate
        The start and every iterate; empty for what is no iteration.
    started : str
        Where the iteration started, of `STARTS`; empty for what is no iteration.
    loops : tuple of Simulation
        One for each segment of each record; empty where they could not be simulated.
    simulated : (n,) array or NotSimulated
        Left side as the simulated loops have it.
    remarks : tuple of str or Note
    """

    form: Form
    measured: Equations
    solution: Solution
    solver: Solver = by_least_squares
    iterates: tuple[Iterate, ...] = ()
    started: str = ""
    loops: tuple[Simulation, ...] = ()
    simulated: Array | NotSimulated = _NO_LOOP
    remarks: tuple[str | Note, ...] = ()

    @property
    def physical(self) -> Array:
        """Physical parameters, (p,)."""
        return self.form.physical(self.solution.theta)[0]

    @property
    def instruments(self) -> QrFactors | None:
        """None where there are none."""
        return self.solver.instruments if isinstance(self.solver, ByInstruments) else None

    @property
    def follows(self) -> bool:
        """Whether the simulated loops move as the records do, so that they stand for them."""
        if isinstance(self.simulated, NotSimulated):
            return False
        left = self.measured.left
        return relative_error_percent(left - self.simulated, left) < MAX_SIMULATION_ERROR.value


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
        Of `STARTS`, where an iteration starts; least squares only where its loop follows the
        records.
    loss : str
        Of `ROW_LOSSES`, how rows count.
    """

    name: str
    form: type[Form]
    start: str = STARTS[0]
    loss: str = ROW_LOSSES[0]

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


def at_point(solution: Solution, measured: Equations, physical: Array) -> Solution:
    """A solution moved to where the measured rows are linearised, (p,): their residuals there."""
    left = measured.left - measured.intercept - measured.regressor @ physical
    return replace(solution, theta=physical, residuals=left)
