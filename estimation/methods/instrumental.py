"""Instrumental variables: instruments from the simulated loop, until the estimate stands still."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import numpy as np

from axisid.estimation.choices.methods import NOMINAL_START
from axisid.estimation.estimates import Iterate
from axisid.estimation.problems import Problem, adding
from axisid.estimation.regression import (
    Equations,
    Form,
    InverseForm,
    PublishedCovariance,
    QrFactors,
    Solution,
    damped_step,
    delta_method,
    factor,
    instrumental_variables,
    search_bounds,
)
from axisid.estimation.signals import rests_first
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds.estimates import (
    CONVERGED,
    MAX_SIMULATION_ERROR_RATIO,
    NEARLY_CONVERGED,
)
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError
from axisid.support.remedy import Note, Remedy, Setting

from .method import Fit, Method, at_point
from .pace import Pace
from .starting import Start, nominal_start, start_of

_MOST = 20


@dataclass(frozen=True, slots=True)
class _Step:
    """A step of the iteration: from where, to which estimate, by how many deviations."""

    start: Array
    goal: Array
    size: float
    solution: Solution
    instruments: QrFactors


@dataclass(frozen=True, slots=True)
class _IterationState:
    """Where the iteration is: the measured rows about it, and the loops simulated with it."""

    measured: Equations
    physical: Array
    loops: tuple[Simulation, ...]
    simulated: Array


class Instruments(Method):
    """Instrumental variables from the simulated loop."""

    def fit(self, problem: Problem) -> Fit:
        """See `Method.fit`."""
        form = problem.form(self.form)
        with adding(lambda: "Instruments need it; idm-ls and ddm-ls do without."):
            problem.check_loop()
        form, start = start_of(problem, form, self.start)
        if start.named == NOMINAL_START or not form.is_linear:
            return Iteration(self.name, form, start, problem).fit()
        return self._from_least_squares(problem, form, start)

    def _from_least_squares(self, problem: Problem, form: Form, start: Start) -> Fit:
        """From least squares; from the nominal values where that comes to no end."""
        first = Iteration(self.name, form, start, problem)
        near: Fit | None = None
        with suppress(EstimationError):
            near = first.fit()
            if not first.jumps:
                return near
        why = Note("from least squares it comes to no end")
        second = Iteration(self.name, form, nominal_start(form, why), problem)
        try:
            found = second.fit()
        except EstimationError:
            if near is None:
                raise
            return near
        return near if near is not None and second.jumps else found


class Iteration:
    """The iteration of one method.

    Parameters
    ----------
    method : str
        For messages.
    form : Form
        Linearised where it starts, if it is not linear.
    start : Start
    problem : Problem
    """

    def __init__(self, method: str, form: Form, start: Start, problem: Problem) -> None:
        self._method, self._form, self._start, self._on = method, form, start, problem
        self._iterates: list[Iterate] = []
        self._pace = Pace()
        self.jumps = False  # whether the fit is near an estimate, and none

    def fit(self) -> Fit:
        """Iterate.

        Raises
        ------
        EstimationError
            It does not come to an end, or a loop cannot be simulated; the iterate is named.
        """
        form, physical = self._form, self._start.physical
        last: _Step | None = None
        nearest: _Step | None = None
        while len(self._iterates) <= _MOST:
            with self._naming():
                measured = self._on.rows(form.at(physical) if self._iterates else form)
                reached, Z = self._reached(measured, physical)
                if last is not None and last.size <= CONVERGED.value:
                    return self._ended(last, reached)
                last = self._step(measured, Z, physical)
                if nearest is None or last.size < nearest.size:
                    nearest = last
                physical = self._next(last, physical, self._pace.share)
        if nearest is None or nearest.size > NEARLY_CONVERGED.value:
            raise self._moving(physical)
        with self._naming():
            end = self._next(nearest, nearest.start, 1.0)
            reached, _ = self._reached(self._on.rows(form.at(end)), end)
            self.jumps = True
            return self._ended(nearest, reached, (_jumping(nearest.size),))

    def _moving(self, physical: Array) -> EstimationError:
        rests = rests_first(self._on.rest)
        cause = Note.of("It may be that ", rests, ".") if rests else self._elsewhere()
        said = Note.of(
            f"{self._method} still moves after {_MOST} iterations; the last estimate is "
            f"{self._form.describe(physical)}. ",
            cause,
        )
        return EstimationError(said.text, said.remedy, code="no-convergence")

    def _elsewhere(self) -> Remedy:
        """What to try where nothing is known of the record."""
        law = "Check the control law against the record, and start from "
        if self._start.named == NOMINAL_START:
            return Remedy.of(law, "better nominal values.")
        return Remedy.of(law, "the nominal values: ", Setting("start", NOMINAL_START), ".")

    def _reached(self, measured: Equations, physical: Array) -> tuple[_IterationState, Array]:
        """The loop simulated with the next iterate, parameters (p,), and its regressor."""
        loops = self._start.loops if not self._iterates else ()
        loops = loops or self._on.loops(self._form, physical)
        intercept, Z = self._on.right_of(self._form, physical, loops)
        # Of the point that is simulated, which a damped step leaves short of the solution.
        theta = self._form.regressed(physical)
        # The loop satisfies the model row by row, so this is its left side.
        simulated = Z @ theta + intercept
        error = relative_error_percent(measured.left - simulated, measured.left)
        self._iterates.append(
            Iterate(physical=physical, theta=theta, simulation_error_percent=error)
        )
        return _IterationState(measured, physical, loops, simulated), Z

    def _step(self, measured: Equations, Z: Array, physical: Array) -> _Step:
        """From parameters (p,) to the estimate by the instruments that they give."""
        regressor = self._on.factored(self._form, measured)
        instruments = factor(Z, regressor.names, "the simulated loop")
        solution = instrumental_variables(
            measured.left - measured.intercept, regressor, instruments
        )
        goal, jacobian = self._form.physical(solution.theta)
        deviation = np.sqrt(np.diag(delta_method(PublishedCovariance().matrix(solution), jacobian)))
        # Of the whole step: part of one may be small far from the solution.
        size = self._pace.step(physical, goal, deviation)
        return _Step(physical, goal, size, solution, instruments)

    def _next(self, step: _Step, physical: Array, share: float) -> Array:
        """Where the iteration goes from parameters (p,), to a solution of the linearised model."""
        if self._form.is_linear or not isinstance(self._form, InverseForm):
            whole = step.size <= CONVERGED.value or share == 1.0
            return step.goal if whole else physical + share * (step.goal - physical)
        if step.size <= CONVERGED.value:
            return np.clip(step.goal, *search_bounds(self._form.axis))
        return damped_step(self._form, self._on.rows, step.instruments, physical, step.goal)

    def _ended(self, step: _Step, reached: _IterationState, remarks: tuple[str, ...] = ()) -> Fit:
        """The fit that a step led to."""
        self._check_valley()
        solution, measured = step.solution, reached.measured
        if not self._form.is_linear:
            solution = at_point(solution, measured, reached.physical)
        return Fit(
            form=self._form,
            measured=measured,
            solution=solution,
            instruments=step.instruments,
            iterates=tuple(self._iterates),
            started=self._start.named,
            loops=reached.loops,
            simulated=reached.simulated,
            remarks=(*self._why_not(), *remarks),
        )

    def _why_not(self) -> tuple[Note, ...]:
        """Why it did not start from least squares, if it was to."""
        return () if self._start.why_not is None else (self._start.why_not,)

    def _check_valley(self) -> None:
        """A partially linear model's equations have several solutions, most of them wrong."""
        first, last = (self._iterates[i].simulation_error_percent for i in (0, -1))
        if not self._form.is_linear and last > MAX_SIMULATION_ERROR_RATIO.value * first:
            raise EstimationError(
                f"it went from least squares, whose loop leaves {first:.3g} % unexplained, to "
                f"{self._form.describe(self._iterates[-1].physical)}, whose loop leaves "
                f"{last:.3g} %; that is another solution of the same equations. Believe idm-ls, or "
                "record a motion that stays longer where the nonlinear terms change."
            )

    @contextmanager
    def _naming(self) -> Iterator[None]:
        """Say in an estimation error where it arose."""
        what = f"{self._method}, iterate {len(self._iterates)}"
        try:
            yield
        except EstimationError as error:
            problem = f"{what}: {error.problem}"
            raise EstimationError(problem, error.remedy, code=error.code) from error


def _jumping(size: float) -> str:
    """What to say of an iteration that ends near an estimate."""
    return (
        f"the iteration ends {size:.1g} deviations from an estimate that follows from itself: the "
        "simulated loop reverses so often that it jumps with the parameters"
    )
