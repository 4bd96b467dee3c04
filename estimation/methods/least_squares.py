"""Least squares of one form, linear or partially linear."""

from dataclasses import replace

from axisid.estimation.estimates import NotSimulated
from axisid.estimation.estimation_problem import Problem, Solver
from axisid.estimation.regression import least_squares, separable_least_squares
from axisid.support.errors import DataError, EstimationError, ModelError

from .m_estimation import check_loss, robust_solution
from .method import Fit, Method


class LeastSquares(Method):
    """Least squares of one form; the simulated loop is a courtesy."""

    def fit(self, problem: Problem) -> Fit:
        """See `Method.fit`."""
        form = separable_least_squares(problem.form(self.form), problem.rows)
        measured = problem.rows(form)
        check_loss(self.loss, form)
        regressor = problem.factored(form, measured)
        left = measured.left - measured.intercept
        if form.is_linear:
            solution = robust_solution(left, regressor, regressor, self.loss)
        else:
            # The search ends within the bounds, where a step of the linearised model might not.
            found, at = least_squares(left, regressor), form.start
            solution = replace(found, theta=at, residuals=measured.residuals(at))
        solver = Solver(counts=solution.counts)
        fit = Fit(form=form, measured=measured, solution=solution, solver=solver)
        try:
            loops, right = problem.simulated(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            by_estimate = isinstance(error, EstimationError)
            said = f"no simulation error, since {error!s}"
            return replace(
                fit,
                simulated=NotSimulated(str(error), by_estimate=by_estimate),
                remarks=(said,) if by_estimate else (),  # what no method has, the verdict tells
            )
        return replace(fit, loops=loops, right=right, simulated=right.predicted(solution.theta))
