"""DIDIM: least squares of the measured force on the rows of the simulated loop.

The direct and inverse dynamic identification model of [Gautier2013]_: the loop is simulated with an
estimate, and the measured force is regressed on the model along the simulated motion. The regressor
contains no measured motion. Neither the noise of the encoder nor the derivative of a filtered
signal biases it. Measured and simulated force pass the same filter. DIDIM is an output-error
estimate of the force, and requires that the drive has the declared control law.

At convergence, the rows Z of the loop are orthogonal to the residual. The effect of noise on the
estimate depends on the derivatives J of the whole simulated force by the parameters, and not only
on Z: it is (Z'J)^-1 Z' times the noise. A stiff control law has J near Z. With P-PI laws the
standard errors are 0.8 to 1.4 times those by Z alone.
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

# share of a positive parameter that a step keeps at least, where the loop does not follow the
# record: measured on the EMPS record from 5 to 1000 kg, with the same result for 0.1 to 0.5
_LEAST_SHARE_OF_A_STEP = 0.25
# relative increase of the simulation error; a step with a larger increase is halved. Rounding at
# reversals increases the error by less
_MAX_ERROR_GROWTH = 1e-3
# smallest change of a parameter's force for a numerical derivative, relative to the whole force
_LEAST_SLOPE_STEP = 1e-4

_MOST_BY_ROWS = 10  # iterates, after which steps use the derivatives of the loop

_STEP_LENGTHS = 6  # lengths of a step that are tried, each half of the previous one


class _ByOutputError(Iteration):
    """Iteration of DIDIM: the measured force is regressed on the rows of the simulated loop.

    The iteration lowers the simulation error of the loop, so a step that increases this error is
    too long and is halved.

    The first steps use the rows Z of the loop as regressor. If the motion of the loop depends on
    the parameters, as with a PI law, the derivatives J of the simulated force differ from Z, and
    these steps hardly shrink. From then on the steps are Newton's steps towards the same estimate:
    ``(Z'J)^-1 Z'`` times the residual force of the loop.
    """

    #: True once the steps are Newton's.
    _by_slopes = False

    def _solution(self, at: IterationState, simulated: QrFactors) -> Solution:
        """Return the least-squares solution of the measured left side on the simulated rows.

        The known part of the simulated right side, its intercept, is subtracted from the left side
        first. The simulated rows are the regressor, and their own instruments. With a robust loss,
        the residuals are weighted by that loss.
        """
        left = at.measured.left - at.right.intercept
        solution = robust_solution(left, simulated, simulated, self._loss)
        # The rows of the loop are factored without times. A HAC covariance needs the times of the
        # measured rows, which tell which rows are neighbours and where the records have gaps.
        return replace(solution, neighbours=self._problem.neighbours)

    def _next(
        self, step: IterationStep, physical: Array, share: float
    ) -> tuple[Array, SimulatedRows | None]:
        """Return the next parameters, (p,), and the loops simulated with them.

        Six lengths of the step are tried, each half the previous one, until the residual force of
        the loop decreases or hardly increases. If no length is accepted, the parameters are those
        of the shortest step. The loops are None for the last step of the iteration, and where no
        length is accepted.

        Parameters
        ----------
        step : IterationStep
            Step from the present parameters to the least-squares solution there.
        physical : (p,) array
            Present parameters.
        share : float
            Part of the step that is tried first.
        """
        if step.size <= CONVERGED.value:
            return np.clip(step.goal, *self._bounds), None
        # Goal of the step: the extrapolated solution, or that of Newton's method for slow steps,
        # nearer to the present parameters where the loop does not follow the records.
        is_slow = self._pace.stalls or len(self._iterates) > _MOST_BY_ROWS
        self._by_slopes = self._by_slopes or (self._form.is_linear and is_slow)
        goal = step.further
        if self._by_slopes:
            share, goal = 1.0, self._newton_goal(step)
        if self._iterates[-1].simulation_error_percent >= MAX_SIMULATION_ERROR.value:
            goal = self._shortened(physical, goal if self._by_slopes else step.goal)
        scale = robust_scale(step.solution.residuals)
        for _ in range(_STEP_LENGTHS):
            trial = np.clip(physical + share * (goal - physical), *self._bounds)
            with suppress(EstimationError):
                loops, right = self._problem.simulated(self._form, trial, self._budget)
                left = self._problem.rows(self._form.at(trial)).left
                # The residual of the loop must decrease, or hardly increase.
                simulated = right.predicted(self._form.regressed(trial))
                now = size_by_loss(left - simulated, scale, self._loss)
                before = size_by_loss(left - step.at.simulated, scale, self._loss)
                if now < before * (1 + _MAX_ERROR_GROWTH):
                    return trial, (loops, right)
            share /= 2
        return trial, None

    def _newton_goal(self, step: IterationStep) -> Array:
        """Return the parameters, (p,), at the end of a step of Newton's method.

        They would be the estimate if the simulated force were linear in the parameters.
        """
        solver = Solver(
            loop=step.simulated,
            slopes=self._slopes(step.solution, step.at),
            counts=step.solution.counts,
        )
        return self._form.physical(solver(self._form, step.at.measured).theta)[0]

    def _shortened(self, physical: Array, goal: Array) -> Array:
        """Return the end of a shortened step, (p,), for a loop that does not follow the records.

        The rows of an oscillating loop give a useless solution: nearly no inertia, or friction that
        drives the axis. The step is therefore shortened, in its direction, until every positive
        parameter keeps at least a quarter of its value. Its goal is first clipped to the declared
        bounds.

        Parameters
        ----------
        physical : (p,) array
            Present parameters.
        goal : (p,) array
            End of the whole step.
        """
        lower = [p.lower for p in self._form.declared]
        upper = [p.upper for p in self._form.declared]
        goal = np.clip(goal, lower, upper)
        # Share of the step with which each parameter ends at its least value; 1 if it stays above.
        least = _LEAST_SHARE_OF_A_STEP * physical
        is_below = (physical > 0) & (goal < least)
        shares = np.divide(
            physical - least, physical - goal, out=np.ones_like(physical), where=is_below
        )
        return np.asarray(physical + float(shares.min()) * (goal - physical))

    def _solved(
        self, step: IterationStep, reached: IterationState
    ) -> tuple[Equations, Solver, Solution]:
        """Return the solved rows, their solver, and the solution with its influence of noise.

        The influence is that of the derivatives of the simulated force, ``(Z'J)^-1 Z'``.
        """
        left, slopes = reached.measured.left, self._slopes(step.solution, reached)
        solver = Solver(loop=step.simulated, slopes=slopes, counts=step.solution.counts)
        rows = replace(step.at.right if self._form.is_linear else reached.right, left=left)
        influence = solver(self._form, rows).influence
        return rows, solver, replace(step.solution, influence=influence)

    def _slopes(self, solution: Solution, at: IterationState) -> Equations:
        """Return the simulated left side, (n,), linearised in the k regression parameters.

        Its regressor, (n, k), has the derivatives J. A derivative is the difference quotient over
        one standard error of its parameter, because reversals that move from one sample to the next
        have no derivative.
        """
        simulated, Z, theta = at.simulated, at.right.regressor, self._form.regressed(at.physical)
        J = Z.copy()
        deviations = np.sqrt(np.diag(PublishedCovariance().matrix(solution)))
        least = _LEAST_SLOPE_STEP * np.linalg.norm(simulated) / np.linalg.norm(Z, axis=0)
        for j, step in enumerate(np.maximum(deviations, least)):
            changed = theta.copy()
            changed[j] += step
            # Where the loop cannot be simulated with the changed parameter, the column of Z stays.
            with suppress(EstimationError):
                physical = self._form.physical(changed)[0]
                _, right = self._problem.simulated(self._form, physical, self._budget)
                J[:, j] = (right.predicted(changed) - simulated) / step
        return Equations(left=simulated, intercept=simulated - J @ theta, regressor=J)


class Didim(Instruments):
    """Output-error estimate of the force with the rows of the simulated loop."""

    iterated = _ByOutputError
