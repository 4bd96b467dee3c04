"""Least squares in which rows at high speed count less."""

import numpy as np

from axisid.estimation.problems import Problem
from axisid.estimation.regression import weighted_least_squares

from .method import Fit, Method


class WeightedLeastSquares(Method):
    """Least squares of one form, each row weighted by the inverse of its speed."""

    def fit(self, problem: Problem) -> Fit:
        """See `Method.fit`."""
        form = self.form(problem.axis)
        measured = problem.rows(form)
        regressor = problem.factored(form, measured)
        speed = np.abs(problem.stacked(lambda data: data.reduce(data.signals.velocity)))
        weights = 1 / (0.1 * speed.max() + speed)
        solution = weighted_least_squares(measured.left - measured.intercept, regressor, weights)
        return Fit(form=form, measured=measured, solution=solution)
