"""Instrumental variables: instruments from the simulated loop, iterated until convergence.

Each estimate follows from instruments that are simulated with the previous estimate. If the model
leaves much of the force unexplained, a full step may overshoot, and the iteration oscillates
between two estimates without end. A damped step converges to the same estimate. If the steps shrink
by a constant factor, the limit follows from two of them [Walker2011]_. A loop that reverses
thousands of times jumps with the parameters, because reversals move from one sample to the next. In
that case no estimate reproduces itself to the last digit.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.lowering import STEPS_OF_SEARCH
from axisid.estimation.choices import LEAST_SQUARES_START, NOMINAL_START
from axisid.estimation.estimates import Iterate, NotSimulated
from axisid.estimation.estimation_problem import Problem, Solver
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
    loop_reference,
    search_bounds,
    separable_least_squares,
)
from axisid.estimation.signals import resting_axis
from axisid.estimation.simulation import Simulation, StepBudget
from axisid.estimation.thresholds import CONVERGED
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import DataError, EstimationError

from .least_squares import LeastSquares, check_loss, robust_solution
from .method import Fit, Method

_ROUNDING = 1e-9  # of the value, instead of the standard error in records without noise
# length of a step relative to the previous step, above which it hardly shrinks; if the directions
# are opposite, the iteration oscillates
_SWINGING = 0.5
_LEAST_SHARE = 0.125  # smallest part of a step that is taken
_NEAR = 0.5  # standard errors, within which an estimate is linear in the previous estimate
# length of a step relative to the previous step, up to which the limit is extrapolated from both
_FALLING = 0.25
_FIRST = 3  # steps; the first steps from the nominal values have any size and direction


class StepControl:
    """Control of the length of the steps of one iteration.

    It measures each step in standard errors, halves the steps if they oscillate, and extrapolates
    them if they shrink steadily.

    Without noise, the standard errors shrink with the distance from the solution, and the steps in
    units of their own standard errors never shrink. A step therefore stalls only if it hardly
    shrinks both in its own standard errors and in those of the previous step.
    """

    def __init__(self) -> None:
        """Begin without a step."""
        self.share = 1.0  # part of each step to take
        self.stalls = False  # True if the last step was hardly shorter than the previous step
        self._taken = 0  # number of steps so far
        self._last: Array | None = None  # the last step, (p,)
        self._length = 0.0  # length of the last step, in its own standard errors
        self._goal: Array | None = None  # end of the last step before it was shortened, (p,)

    def step(self, start: Array, goal: Array, deviation: Array) -> tuple[float, Array]:
        """Return the size of a step and the extrapolated end of the steps.

        Afterwards `share` is the part of the step to take, and `stalls` is True if the step is
        hardly shorter than the previous one.

        Parameters
        ----------
        start, goal : (p,) array
            Parameters at the start and at the end of the step.
        deviation : (p,) array
            Standard errors of the parameters.

        Returns
        -------
        size : float
            Largest component of the step, in standard errors.
        further : (p,) array
            Extrapolated end of the steps: the goal, or a point beyond it.
        """
        # This step and the last step, in standard errors, to which the rounding is added.
        unit = deviation + _ROUNDING / CONVERGED.value * np.abs(goal)
        step = goal - start
        scaled_step = _scaled(step, unit)
        length = float(np.linalg.norm(scaled_step))
        last = None if self._last is None else _scaled(self._last, unit)
        self._taken += 1
        # Halve the steps if they hardly shrink and change their direction.
        if last is not None and self._taken > _FIRST:
            lengths = self._length, float(np.linalg.norm(last))
            self.stalls = length > _SWINGING * max(lengths)
            if self.stalls and float(scaled_step @ last) < 0:
                self.share = max(self.share / 2, _LEAST_SHARE)
        further = self._beyond(goal, scaled_step, last)
        self._last, self._length, self._goal = step, length, goal
        return float(np.abs(scaled_step).max()), further

    def _beyond(self, goal: Array, scaled_step: Array, last: Array | None) -> Array:
        """Return the goal of a step, or the extrapolated limit if the steps shrink steadily, (p,).

        The limit is that of the secant through this and the last step, Anderson's method of depth
        one. The goal itself is returned for the first step, for damped steps, and for steps that
        are large or hardly shrink.

        Parameters
        ----------
        goal : (p,) array
            Parameters at the end of the step.
        scaled_step : (p,) array
            The step in standard errors.
        last : (p,) array or None
            The previous step, in the same standard errors; None for the first step.
        """
        before = self._goal
        if last is None or before is None or self.share < 1:
            return goal
        size = float(np.abs(scaled_step).max())
        last_size = float(np.abs(last).max())
        # The next step, shorter by the same factor, would converge without extrapolation.
        converges_next = size * size <= CONVERGED.value * last_size
        if converges_next or size > _NEAR or size > _FALLING * last_size:
            return goal
        change = scaled_step - last
        return np.asarray(
            goal - float(scaled_step @ change) / float(change @ change) * (goal - before)
        )


def _scaled(step: Array, unit: Array) -> Array:
    """Return a step divided by units (p,); 0 where the step is 0."""
    return np.divide(step, unit, out=np.zeros_like(step), where=step != 0)


# simulation error at the end relative to that of least squares; beyond it, a nonlinear model has
# converged to another solution
_MAX_SIMULATION_ERROR_RATIO = 2.0
# last step in standard errors, up to which an estimate is accepted where the simulated loop jumps
# too much for exact convergence: a hundredth of the variance
NEARLY_CONVERGED = 0.1

_MOST_ITERATIONS = 20
#: Simulated loops and their rows.
SimulatedRows = tuple[tuple[Simulation, ...], Equations]


@dataclass(frozen=True, slots=True)
class Start:
    """Start of an iteration: least squares, if its simulated loop follows the records.

    Least squares is usually nearer to the solution than the nominal values, and does not depend on
    the nominal values. Noise may bias least squares so much that the loop simulated with it is no
    instrument. The iteration then starts from the nominal values.

    Attributes
    ----------
    physical : (p,) array
        Physical parameters at the start.
    named : {"least-squares", "nominal"}
        Origin of these parameters.
    simulated : tuple of loops and Equations, or None
        Loops simulated with the start, and their rows; None if they are not yet simulated.
    why_not : str or None
        Sentence with the reason why the iteration does not start as requested; None if it does.
    """

    physical: Array
    named: str
    simulated: SimulatedRows | None = None
    why_not: str | None = None


@dataclass(frozen=True, slots=True)
class IterationStep:
    """Full step of an iteration, from a state to the solution with its loops as instruments.

    Attributes
    ----------
    at : IterationState
        Start of the step.
    goal : (p,) array
        Physical parameters of the solution, which are the end of the step.
    further : (p,) array
        Extrapolated end of all steps if they shrink steadily; otherwise the goal.
    size : float
        Largest component of the step, in standard errors.
    solution : Solution
        Solution of the rows at the start.
    simulated : QrFactors
        QR factors of the regressor along the loops that are simulated at the start of the step.
    """

    at: "IterationState"
    goal: Array
    further: Array
    size: float
    solution: Solution
    simulated: QrFactors


@dataclass(frozen=True, slots=True)
class IterationState:
    """Parameters of an iteration, with the measured rows and the loops simulated there.

    Attributes
    ----------
    measured : Equations
        Measured rows, of a form that is linearised at the parameters if it is not linear.
    physical : (p,) array
        Physical parameters.
    loops : tuple of Simulation
        Loops that are simulated with the parameters.
    simulated : (n,) array
        Left side of the model along these loops.
    right : Equations
        Rows along these loops.
    """

    measured: Equations
    physical: Array
    loops: tuple[Simulation, ...]
    simulated: Array
    right: Equations


class Iteration:
    """The iteration of one method on the rows of a problem.

    Parameters
    ----------
    method : Method
    form : Form
        Form of the regression, linearised at the start if it is not linear.
    start : Start
    problem : Problem
    """

    def __init__(self, method: Method, form: Form, start: Start, problem: Problem) -> None:
        """Prepare the iteration; see the class for the arguments."""
        self._method, self._form, self._start, self._loss = method.name, form, start, method.loss
        # A linearised model stays within the bounds of its search.
        self._bounds = (-np.inf, np.inf) if form.is_linear else search_bounds(form.axis)
        self._problem = problem  # its measured rows are solved, and its loops simulated
        self._iterates: list[Iterate] = []  # the start and every iterate so far
        loops = sum(len(data.record.spans) for data in problem.data)
        self._pace = StepControl()  # control of the length of the steps
        self._budget = StepBudget(loops * STEPS_OF_SEARCH)  # integration steps of all loops
        self.jumps = False  # True if the simulated loop jumps too much for exact convergence

    def fit(self) -> Fit:
        """Iterate to convergence, and return the fit at the end.

        Each round has three parts. `_state_at` simulates the loop with the present parameters, and
        appends them to the iterates. `_step` solves the rows with this loop; the solution is the
        `goal` of the step. `_next` takes the step or a part of it. DIDIM goes towards `further`
        instead of the goal: the extrapolated limit if the steps shrink steadily, see
        `StepControl`. The iteration has converged at the end of a step that is short enough.

        If the iteration does not converge, but its shortest step is at most a tenth of a standard
        error, this step is repeated to its goal without extrapolation. The fit at its end is
        returned with a remark, and `jumps` is True.

        Raises
        ------
        EstimationError
            The iteration does not converge, or a loop cannot be simulated; the iterate is named.
        """
        # `loops` are those simulated with the next parameters; None if not yet simulated.
        physical, loops = self._start.physical, self._start.simulated
        last: IterationStep | None = None
        shortest: IterationStep | None = None
        while len(self._iterates) <= _MOST_ITERATIONS:
            with self._method_in_errors():
                reached = self._state_at(physical, loops)  # appended to `_iterates`
                if last is not None and last.size <= CONVERGED.value:
                    return self._fit_at_end(last, reached)
                last = self._step(reached)
                if shortest is None or last.size < shortest.size:
                    shortest = last
                physical, loops = self._next(last, physical, self._pace.share)
        if shortest is None or shortest.size > NEARLY_CONVERGED:
            raise self._no_convergence(physical)
        # Not converged, but the shortest step is small: take this step again as the last one. It
        # starts from the state where it was found, and the whole step is tried, not extrapolated.
        with self._method_in_errors():
            not_extrapolated = replace(shortest, further=shortest.goal)
            end = self._next(not_extrapolated, shortest.at.physical, 1.0)
            reached = self._state_at(*end)
            self.jumps = True
            return self._fit_at_end(
                shortest,
                reached,
                f"the last step of the iteration is {shortest.size:.1g} standard errors, and "
                "smaller steps are not possible: the simulated loop reverses so often that it "
                "jumps with the parameters",
            )

    def _no_convergence(self, physical: Array) -> EstimationError:
        """Return the error of an iteration that does not converge.

        `physical`, (p,), has the last parameters.
        """
        other = "better nominal values."
        if self._start.named != NOMINAL_START:
            other = f'the nominal values: start="{NOMINAL_START}" in Python.'
        advice = f"Check the control law against the record, and start from {other}"
        resting = resting_axis(self._problem.rest)
        if resting is not None:
            advice = f"A likely cause is that {resting.sentence}."
        return EstimationError(
            f"{self._method} does not converge in {_MOST_ITERATIONS} iterations. The last estimate "
            f"is {self._form.describe(physical)}. {advice}",
            code="no-convergence",
        )

    def _state_at(self, physical: Array, simulated_before: SimulatedRows | None) -> IterationState:
        """Return the state at parameters `physical`, (p,), and append an `Iterate` to `_iterates`.

        The iterate has the parameters and the simulation error. The length of `_iterates` limits
        the iteration. `simulated_before` has the loops simulated with these parameters; with None
        they are simulated here.
        """
        # The form is linearised at the start already.
        form = self._form.at(physical) if self._iterates else self._form
        measured = self._problem.rows(form)
        loops, right = simulated_before or self._problem.simulated(
            self._form, physical, self._budget
        )
        # The regression's parameters are not those of the last solution if a step was damped.
        theta = self._form.regressed(physical)
        simulated = right.predicted(theta)  # the loop satisfies the model row by row
        error = relative_error_percent(measured.left - simulated, measured.left)
        self._iterates.append(
            Iterate(physical=physical, theta=theta, simulation_error_percent=error)
        )
        return IterationState(measured, physical, loops, simulated, right)

    def _step(self, at: IterationState) -> IterationStep:
        """Return the full step from a state to the solution of the rows at this state.

        The instruments, or the regressor of DIDIM, are those of the loop simulated there.
        """
        names = [q.label for q in self._form.quantities]
        simulated = factor(at.right.regressor, names, "the simulated loop")
        solution = self._solution(at, simulated)
        goal, jacobian = self._form.physical(solution.theta)
        covariance = delta_method(PublishedCovariance().matrix(solution), jacobian)
        deviation = np.sqrt(np.diag(covariance))
        # Size of the full step, because a damped step may be small far from the solution.
        size, further = self._pace.step(at.physical, goal, deviation)
        return IterationStep(at, goal, further, size, solution, simulated)

    def _solution(self, at: IterationState, simulated: QrFactors) -> Solution:
        """Return the solution of the measured rows with the simulated rows as instruments."""
        regressor = self._problem.factored(self._form, at.measured)
        left = at.measured.left - at.measured.intercept
        return robust_solution(left, regressor, simulated, self._loss)

    def _next(
        self, step: IterationStep, physical: Array, share: float
    ) -> tuple[Array, SimulatedRows | None]:
        """Return the next parameters, (p,), and the loops simulated with them.

        The loops are None, unless a subclass has simulated them. The next parameters are the given
        share of the way to the goal of the step. At convergence they are the goal itself, within
        the bounds. The step of a nonlinear inverse model is shortened where its linearisation does
        not hold.

        Parameters
        ----------
        step : IterationStep
            Step from the present parameters to the solution there.
        physical : (p,) array
            Present parameters.
        share : float
            Part of the step to take.

        Returns
        -------
        (p,) array
            The next parameters.
        tuple or None
            Loops simulated with these parameters, and their rows; None if not yet simulated.
        """
        if step.size <= CONVERGED.value:
            return np.clip(step.goal, *self._bounds), None
        if not self._form.is_linear and isinstance(self._form, InverseForm):
            rows = self._problem.rows
            return damped_step(self._form, rows, step.simulated, physical, step.goal), None
        if share == 1:
            return step.goal, None
        return physical + share * (step.goal - physical), None

    def _fit_at_end(self, step: IterationStep, reached: IterationState, *remarks: str) -> Fit:
        """Return the fit at the end of the last step.

        Parameters
        ----------
        step : IterationStep
            The last step.
        reached : IterationState
            State at the end of the last step.
        remarks : str
            Further remarks for the user.

        Raises
        ------
        EstimationError
            A nonlinear model has converged to another solution of its equations, with a larger
            simulation error.
        """
        first = self._iterates[0].simulation_error_percent
        last = self._iterates[-1].simulation_error_percent
        if not self._form.is_linear and last > _MAX_SIMULATION_ERROR_RATIO * first:
            # The equations of a nonlinear model have several solutions, most of them wrong.
            raise EstimationError(
                "the iteration converged to another solution of the same equations, "
                f"{self._form.describe(self._iterates[-1].physical)}. Its simulation error is "
                f"{last:.3g} % of the {self._form.left}, but {first:.3g} % with least squares. Use "
                "idm-ls, or record a motion that stays longer where the nonlinear terms change."
            )
        measured, solver, solution = self._solved(step, reached)
        if not self._form.is_linear:
            # The parameters within the bounds, where the rows are linearised.
            at = reached.physical
            solution = replace(solution, theta=at, residuals=measured.residuals(at))
        why_not = self._start.why_not
        return Fit(
            form=self._form,
            measured=measured,
            solution=solution,
            solver=solver,
            iterates=tuple(self._iterates),
            started=self._start.named,
            loops=reached.loops,
            simulated=reached.simulated,
            remarks=(why_not, *remarks) if why_not else remarks,
        )

    def _solved(
        self, step: IterationStep, reached: IterationState
    ) -> tuple[Equations, Solver, Solution]:
        """Return the measured rows at the end, their solver, and their solution.

        The influence in the solution is the effect of noise in the rows on the parameters.
        """
        solver = Solver(loop=step.simulated, counts=step.solution.counts)
        return reached.measured, solver, step.solution

    @contextmanager
    def _method_in_errors(self) -> Iterator[None]:
        """Add the method and the number of the iterate to an error in the ``with`` block."""
        iterate = f"{self._method}, iterate {len(self._iterates)}"
        try:
            yield
        except EstimationError as error:
            raise EstimationError(f"{iterate}: {error}", code=error.code) from error


class Instruments(Method):
    """Instrumental variables from the simulated loop."""

    #: Class of the iteration. It starts from least squares or from the nominal values. If it does
    #: not converge, it is repeated from the other start.
    iterated = Iteration

    def fit(self, problem: Problem) -> Fit:
        """Return the fit of a problem by the iteration from its start.

        If the iteration of a linear model does not converge, or only nearly converges because its
        simulated loop jumps, it is repeated from the other start. The first fit is kept if the
        second iteration does not converge exactly. Without any fit, the error of the second
        iteration is raised, or that of the first if there is no other start.

        Raises
        ------
        ModelError, EstimationError
            As in `Method.fit`.
        """
        form = problem.form(self.form)
        for data in problem.data:
            loop_reference(problem.axis, data.record)  # refuses what cannot be simulated
        check_loss(self.loss, form)
        form, start = _start_of(problem, form, self.start)
        first = self.iterated(self, form, start, problem)
        if not form.is_linear:
            return first.fit()
        # From the first start: return an exact fit, and keep a fit that nearly converged.
        nearly_converged: Fit | None = None
        try:
            nearly_converged = first.fit()
        except EstimationError:
            other = _other_start(problem, form, start)
            if other is None:
                raise
        else:
            other = _other_start(problem, form, start) if first.jumps else None
            if other is None:
                return nearly_converged
        # From the other start.
        second = self.iterated(self, form, other, problem)
        try:
            found = second.fit()
        except EstimationError:
            if nearly_converged is None:
                raise
            return nearly_converged
        if second.jumps and nearly_converged is not None:
            return nearly_converged
        return found


def _start_of(problem: Problem, form: Form, asked: str) -> tuple[Form, Start]:
    """Return the form, linearised if necessary, and the start of its iteration.

    A nonlinear model is first fitted by a global search with least squares, and instruments start
    from there whatever start is requested. A linear model, inverse or direct, starts from least
    squares of the inverse model if its simulated loop follows the records, otherwise from the
    nominal values. `asked` is the requested start, of `INSTRUMENT_STARTS`.

    Raises
    ------
    EstimationError
        The search of a nonlinear model gives no least-squares estimate.
    """
    if not form.is_linear:
        form = separable_least_squares(form, problem.rows)
        return form, Start(form.start, LEAST_SQUARES_START)
    if asked == NOMINAL_START:
        return form, _nominal_start(form)
    try:
        fit = LeastSquares(name="idm-ls", form=InverseForm).fitted(problem)
    except (DataError, EstimationError) as error:
        return form, _nominal_start(form, str(error))
    if fit.follows:
        # The rows of the loops, in the form of the iteration.
        right = fit.right
        if right is None or not isinstance(form, InverseForm):
            right = problem.simulated_rows(form, fit.physical, fit.loops)
        return form, Start(fit.physical, LEAST_SQUARES_START, (fit.loops, right))
    if isinstance(fit.simulated, NotSimulated) and fit.simulated.reason:
        return form, _nominal_start(form, fit.simulated.reason)
    percent = f"{fit.simulation_error_percent:.3g} %"
    reason = f"the simulation error of least squares is {percent} of the force"
    return form, _nominal_start(form, reason)


def _other_start(problem: Problem, form: Form, first: Start) -> Start | None:
    """Return the start of a linear model that was not used first.

    After least squares, it is at the nominal values; after the nominal values, at least squares.
    None where least squares fails.
    """
    if first.named != NOMINAL_START:
        return _nominal_start(form, "it does not converge from least squares")
    try:
        fit = LeastSquares(name="idm-ls", form=InverseForm).fitted(problem)
    except (DataError, EstimationError):
        return None
    return Start(
        fit.physical,
        LEAST_SQUARES_START,
        why_not="the iteration starts from least squares, because it does not converge from the "
        "nominal values",
    )


def _nominal_start(form: Form, why_not: str | None = None) -> Start:
    """Return a start at the nominal values of a form.

    `why_not` is the reason why it is not at least squares; None if nominal values were requested.
    """
    if why_not:
        why_not = f"the iteration starts from the nominal values, because {why_not}"
    return Start(form.start, NOMINAL_START, why_not=why_not)
