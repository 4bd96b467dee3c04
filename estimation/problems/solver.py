"""How a method solves rows, whether the record's or those of a simulated loop."""

from collections.abc import Callable
from dataclasses import dataclass

from axisid.estimation.regression import (
    Equations,
    Form,
    QrFactors,
    Solution,
    checked_columns,
    factor,
    instrumental_variables,
    least_squares,
    weighted_least_squares,
)
from axisid.support.arrays import Array

#: Of rows of a form.
Solver = Callable[[Form, Equations], Solution]


def by_least_squares(form: Form, rows: Equations) -> Solution:
    """Least squares of the rows as they are."""
    return ByWeights(None)(form, rows)


@dataclass(frozen=True, slots=True)
class ByWeights:
    """Least squares, each row with the weight that a loss gave it.

    Attributes
    ----------
    weights : (n,) array or None
        None where all rows count alike, as they do where there are not as many.
    """

    weights: Array | None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form."""
        columns = factor(rows.regressor, [q.label for q in form.quantities])
        return self.solved(rows.left - rows.intercept, columns)

    def solved(self, left: Array, columns: QrFactors) -> Solution:
        """Solve a left side, (n,), and its columns."""
        if self.weights is None or len(self.weights) != len(left):
            return least_squares(left, columns)
        return weighted_least_squares(left, columns, self.weights)


@dataclass(frozen=True, slots=True)
class ByInstruments:
    """Instrumental variables, the instruments the same whatever the rows.

    Attributes
    ----------
    instruments : QrFactors
    """

    instruments: QrFactors

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form by the instruments."""
        columns = checked_columns(rows.regressor, [q.label for q in form.quantities])
        return instrumental_variables(rows.left - rows.intercept, columns, self.instruments)


@dataclass(frozen=True, slots=True)
class ByOutputError:
    """Least squares of the left side by the simulated loop's rows, whatever was measured there.

    Attributes
    ----------
    intercept : (n,) array
        Known part of the loop's rows.
    regressor : QrFactors
        Of the loop's rows.
    weights : (n,) array or None
        As of `ByWeights`.
    """

    intercept: Array
    regressor: QrFactors
    weights: Array | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:  # noqa: ARG002
        """Solve rows of a form for their left side."""
        return ByWeights(self.weights).solved(rows.left - self.intercept, self.regressor)
