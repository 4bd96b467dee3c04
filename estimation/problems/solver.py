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
)
from axisid.support.arrays import Array

#: Of rows of a form.
Solver = Callable[[Form, Equations], Solution]


def by_least_squares(form: Form, rows: Equations) -> Solution:
    """Least squares of the rows as they are."""
    names = [q.label for q in form.quantities]
    return least_squares(rows.left - rows.intercept, factor(rows.regressor, names))


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
    """

    intercept: Array
    regressor: QrFactors

    def __call__(self, form: Form, rows: Equations) -> Solution:  # noqa: ARG002
        """Solve rows of a form for their left side."""
        return least_squares(rows.left - self.intercept, self.regressor)
