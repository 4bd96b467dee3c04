"""Least squares in which rows at high speed count less."""

from dataclasses import replace

import numpy as np

from axisid.estimation.estimation_problem import Problem
from axisid.estimation.regression import factor, instrumental_variables

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
        # (X'WX)^-1 X'Wy: the weighted columns as instruments.
        weighted = factor(weights[:, None] * measured.regressor, regressor.names)
        left = measured.left - measured.intercept
        solution = instrumental_variables(left, regressor, weighted)
        # Deviations for errors of one variance are of the influence, whatever the weights' unit.
        root = np.linalg.qr(solution.influence, "r").T
        solution = replace(solution, inverse_factor=root)
        return Fit(form=form, measured=measured, solution=solution)
