"""How a method solves rows, whether the record's or those of a simulated loop."""

from collections.abc import Callable
from dataclasses import dataclass

from axisid.estimation.regression import (
    Columns,
    Equations,
    Form,
    QrFactors,
    RowCounts,
    Solution,
    as_counted,
    checked_columns,
    factor,
    instrumental_variables,
    least_squares,
)
from axisid.support.arrays import Array

#: Of rows of a form.
Solver = Callable[[Form, Equations], Solution]


@dataclass(frozen=True, slots=True)
class ByLeastSquares:
    """Least squares, each row as it counted under a loss.

    Attributes
    ----------
    counts : RowCounts or None
        None where all rows count alike.
    """

    counts: RowCounts | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form."""
        columns = factor(rows.regressor, [q.label for q in form.quantities])
        return self.solved(rows.left - rows.intercept, columns)

    def solved(self, left: Array, columns: QrFactors) -> Solution:
        """Solve a left side, (n,), and its columns."""
        if self.counts is None:
            return least_squares(left, columns)
        return as_counted(left, columns, columns, self.counts)


#: Least squares of the rows as they are.
by_least_squares: Solver = ByLeastSquares()


@dataclass(frozen=True, slots=True)
class ByInstruments:
    """Instrumental variables, the instruments the same whatever the rows.

    Attributes
    ----------
    instruments : QrFactors
    counts : RowCounts or None
        As of `ByLeastSquares`.
    """

    instruments: QrFactors
    counts: RowCounts | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form by the instruments."""
        columns = checked_columns(rows.regressor, [q.label for q in form.quantities])
        return self.solved(rows.left - rows.intercept, columns)

    def solved(self, left: Array, columns: Columns) -> Solution:
        """Solve a left side, (n,), and its columns."""
        if self.counts is None:
            return instrumental_variables(left, columns, self.instruments)
        return as_counted(left, columns, self.instruments, self.counts)


@dataclass(frozen=True, slots=True)
class ByOutputError:
    """Least squares of the left side by the simulated loop's rows, whatever was measured there.

    Attributes
    ----------
    intercept : (n,) array
        Known part of the loop's rows.
    regressor : QrFactors
        Of the loop's rows.
    counts : RowCounts or None
        As of `ByLeastSquares`.
    """

    intercept: Array
    regressor: QrFactors
    counts: RowCounts | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:  # noqa: ARG002
        """Solve rows of a form for their left side."""
        return ByLeastSquares(self.counts).solved(rows.left - self.intercept, self.regressor)
