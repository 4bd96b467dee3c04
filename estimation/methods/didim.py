"""DIDIM: least squares of the measured force by the rows of the simulated loop.

The direct and inverse dynamic identification model of [Gautier2013]_: the loop is simulated with
an estimate, and the measured force is explained by what that loop's motion makes of the model. No
measured motion is in the regressor, so that neither the encoder's noise nor the derivative of what
was filtered biases it; measured and simulated force pass the same filter. It is an output-error
estimate, of the force, and asks that the control law is the drive's.

Where the iteration stands still, the rows Z of the loop are orthogonal to what is left. How far
noise moves that point depends on how the whole simulated force changes with the parameters, J, and
not on Z alone: by (Z'J)^-1 Z' of it. A law that holds the motion tightly has J near Z; under P-PI
laws deviations are 0.8 to 1.4 times those by Z alone.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from axisid.estimation.estimation_problem import Solver
from axisid.estimation.regression import Equations, PublishedCovariance, QrFactors, Solution
from axisid.estimation.thresholds import CONVERGED, MAX_SIMULATION_ERROR
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .instrumental import Instruments, Iteration, IterationState, IterationStep, SimulatedRows
from .least_squares import robust_scale, robust_solution, size_by_loss

# of a parameter, left by a step where the loop does not follow: measured, from 5 to 1000 kg on
# the EMPS record, with 0.1 to 0.5 alike
_LEAST_SHARE_OF_A_STEP = 0.25
# of the simulation error; a step that adds more is halved. A loop's reversals round by less
_MAX_ERROR_GROWTH = 1e-3
_LEAST_SLOPE_STEP = 1e-4  # of the force, by which a parameter's part changes for a slope

_MOST_BY_ROWS = 10  # iterates, after which steps are by the slopes of the loop

_HALVINGS = 6


class _ByOutputError(Iteration):
    """The iteration, whose rows are the simulated loop's and whose left side was measured.

    What it minimises is the loop's own error, so that a step that makes that larger goes too far.

    A loop whose motion depends on the parameters, as under a PI law, has slopes J far from its rows
    Z, and steps by Z alone hardly shrink or are many. From there on steps are Newton's towards the
    same estimate, ``(Z'J)^-1 Z'`` of the force that the loop leaves.
    """

    _by_slopes = False

    def _solution(self, at: IterationState, simulated: QrFactors) -> Solution:
        left = at.measured.left - at.right.intercept
        solution = robust_solution(left, simulated, simulated, self._loss)
        return replace(solution, neighbours=self._on.neighbours)

    def _next(
        self, step: IterationStep, physical: Array, share: float
    ) -> tuple[Array, SimulatedRows | None]:
        if step.size <= CONVERGED.value:
            return np.clip(step.goal, *self._bounds), None
        is_slow = self._pace.stalls or len(self._iterates) > _MOST_BY_ROWS
        self._by_slopes = self._by_slopes or (self._form.is_linear and is_slow)
        goal = step.further
        if self._by_slopes:
            share, goal = 1.0, self._newton_goal(step)
        if self._iterates[-1].simulation_error_percent >= MAX_SIMULATION_ERROR.value:
            goal = self._near(physical, goal if self._by_slopes else step.goal)
        scale = robust_scale(step.solution.residuals)
        for _ in range(_HALVINGS):
            wanted = np.clip(physical + share * (goal - physical), *self._bounds)
            with suppress(EstimationError):
                loops, right = self._on.simulated(self._form, wanted, self._budget)
                left = self._on.rows(self._form.at(wanted)).left
                # What the loop leaves is to be less than before, or hardly more.
                now, before = (
                    size_by_loss(left - each, scale, self._loss)
                    for each in (right.predicted(self._form.regressed(wanted)), step.at.simulated)
                )
                if now < before * (1 + _MAX_ERROR_GROWTH):
                    return wanted, (loops, right)
            share /= 2
        return wanted, None

    def _newton_goal(self, step: IterationStep) -> Array:
        """Where the simulated force, as straight lines of the parameters, has the estimate."""
        solver = Solver(
            loop=step.simulated,
            slopes=self._slopes(step.solution, step.at),
            counts=step.solution.counts,
        )
        return self._form.physical(solver(self._form, step.at.measured).theta)[0]

    def _near(self, physical: Array, goal: Array) -> Array:
        """Less of a step, from where the simulated loop does not follow the records.

        A loop that swings asks for what would stop it at once: nearly no inertia, or friction that
        drives the axis. Within the bounds, and no positive parameter to less than a share of it.
        """
        lower, upper = (
            [getattr(p, end) for p in self._form.declared] for end in ("lower", "upper")
        )
        goal = np.clip(goal, lower, upper)
        least = _LEAST_SHARE_OF_A_STEP * physical
        falls = (physical > 0) & (goal < least)
        fall = np.divide(physical - least, physical - goal, out=np.ones_like(physical), where=falls)
        return np.asarray(physical + float(fall.min()) * (goal - physical))

    def _solved(
        self, step: IterationStep, reached: IterationState
    ) -> tuple[Equations, Solver, Solution]:
        left, slopes = reached.measured.left, self._slopes(step.solution, reached)
        solver = Solver(loop=step.simulated, slopes=slopes, counts=step.solution.counts)
        rows = replace(step.at.right if self._form.is_linear else reached.right, left=left)
        influence = solver(self._form, rows).influence
        return rows, solver, replace(step.solution, influence=influence)

    def _slopes(self, solution: Solution, at: IterationState) -> Equations:
        """The simulated left side, (n,), as straight lines of the parameters about an estimate.

        Over a deviation, as reversals that move from one sample to the next have no slope.
        """
        simulated, Z, theta = at.simulated, at.right.regressor, self._form.regressed(at.physical)
        J = Z.copy()
        deviations = np.sqrt(np.diag(PublishedCovariance().matrix(solution)))
        least = _LEAST_SLOPE_STEP * np.linalg.norm(simulated) / np.linalg.norm(Z, axis=0)
        for j, step in enumerate(np.maximum(deviations, least)):
            moved = theta.copy()
            moved[j] += step
            # At the edge of what can be simulated the rows have to do.
            with suppress(EstimationError):
                at_moved = self._form.physical(moved)[0]
                _, right = self._on.simulated(self._form, at_moved, self._budget)
                J[:, j] = (right.predicted(moved) - simulated) / step
        return Equations(left=simulated, intercept=simulated - J @ theta, regressor=J)


class Didim(Instruments):
    """Output error of the force, by the simulated loop's own rows."""

    iterated = _ByOutputError
