"""Least squares of the measured rows."""

from collections.abc import Callable

from axisid.estimation.estimates import NotSimulated
from axisid.estimation.problems import Problem, Solver
from axisid.estimation.regression import (
    Equations,
    Form,
    InverseForm,
    Solution,
    least_squares,
    variable_projection,
)
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError, ModelError
from axisid.support.remedy import Note

from .method import Fit, Method, at_point
from .robust import check_loss, robust_least_squares


class LeastSquares(Method):
    """Least squares of one form; the simulated loop is a courtesy."""

    def fit(self, problem: Problem) -> Fit:
        """See `Method.fit`."""
        form = least_squares_point(problem.form(self.form), problem.rows)
        measured = problem.rows(form)
        solution = self._solved(problem, form, measured)
        solver = Solver(counts=solution.counts)
        try:
            loops, intercept, right = problem.simulated(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            by_estimate = isinstance(error, EstimationError)
            said = Note.of("no simulation error, since ", error.note)
            return Fit(
                form=form,
                measured=measured,
                solution=solution,
                solver=solver,
                simulated=NotSimulated(error.problem, error.remedy, by_estimate=by_estimate),
                remarks=(said,) if by_estimate else (),  # what no method has, the verdict tells
            )
        simulated: Array = right @ solution.theta + intercept
        return Fit(
            form=form,
            measured=measured,
            solution=solution,
            solver=solver,
            loops=loops,
            right=(intercept, right),
            simulated=simulated,
        )

    def _solved(self, problem: Problem, form: Form, measured: Equations) -> Solution:
        check_loss(self.loss, form)
        regressor = problem.factored(form, measured)
        left = measured.left - measured.intercept
        if form.is_linear:
            return robust_least_squares(left, regressor, self.loss)
        # The search ends within the bounds, where a step of the linearised model might not.
        return at_point(least_squares(left, regressor), measured, form.start)


def least_squares_point(form: Form, rows: Callable[[Form], Equations]) -> Form:
    """A form, at the least-squares estimate if its model is only partially linear."""
    if form.is_linear or not isinstance(form, InverseForm):
        return form
    return form.at(variable_projection(form, rows))
