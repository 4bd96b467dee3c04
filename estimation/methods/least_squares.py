"""Least squares of the measured rows."""

from collections.abc import Callable

from axisid.estimation.estimates import NotSimulated
from axisid.estimation.problems import Problem
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


class LeastSquares(Method):
    """Least squares of one form; the simulated loop is a courtesy."""

    def fit(self, problem: Problem) -> Fit:
        """See `Method.fit`."""
        form = least_squares_point(problem.form(self.form), problem.rows)
        measured = problem.rows(form)
        solution = _solved(problem, form, measured)
        try:
            loops, intercept, right = problem.simulated(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            return Fit(
                form=form,
                measured=measured,
                solution=solution,
                simulated=NotSimulated(
                    error.problem, error.remedy, by_estimate=isinstance(error, EstimationError)
                ),
                remarks=(Note.of("no simulation error, since ", error.note),),
            )
        simulated: Array = right @ solution.theta + intercept
        return Fit(
            form=form, measured=measured, solution=solution, loops=loops, simulated=simulated
        )


def least_squares_point(form: Form, rows: Callable[[Form], Equations]) -> Form:
    """A form, at the least-squares estimate if its model is only partially linear."""
    if form.is_linear or not isinstance(form, InverseForm):
        return form
    return form.at(variable_projection(form, rows))


def _solved(problem: Problem, form: Form, measured: Equations) -> Solution:
    regressor = problem.factored(form, measured)
    solution = least_squares(measured.left - measured.intercept, regressor)
    if form.is_linear:
        return solution
    # The search ends within the bounds, where a step of the linearised model might not.
    return at_point(solution, measured, form.start)
