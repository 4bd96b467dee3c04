"""How a method solves rows, whether the record's or those of a simulated loop."""

from dataclasses import dataclass

from axisid.estimation.regression import (
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """What solves rows of a form: least squares, unless loops were simulated with an estimate.

    Attributes
    ----------
    loop : QrFactors or None
        The simulated loop's columns, the same whatever the rows: instruments, or the regressor of
        output error. None for least squares.
    intercept : (n,) array or None
        Known part of the loop's rows, by which the left side alone is explained: output error.
    counts : RowCounts or None
        What each row counted under a loss; None where all rows count alike.
    """

    loop: QrFactors | None = None
    intercept: Array | None = None
    counts: RowCounts | None = None

    @property
    def instruments(self) -> QrFactors | None:
        """None where there are none."""
        return self.loop if self.intercept is None else None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form."""
        names = [q.label for q in form.quantities]
        left = rows.left - (rows.intercept if self.intercept is None else self.intercept)
        Z = factor(rows.regressor, names) if self.loop is None else self.loop
        X = Z if self.instruments is None else checked_columns(rows.regressor, names)
        if self.counts is not None:
            return as_counted(left, X, Z, self.counts)
        if self.instruments is None:
            return least_squares(left, Z)
        return instrumental_variables(left, X, Z)
