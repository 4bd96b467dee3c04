"""How a method solves the rows of a form: its own, or others such as a twin's."""

from dataclasses import dataclass

from axisid.estimation.regression import (
    Equations,
    Form,
    LossWeights,
    QrFactors,
    Solution,
    checked_columns,
    factor,
    instrumental_variables,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """What solves rows of a form: least squares, unless loops were simulated with an estimate.

    Attributes
    ----------
    loop : QrFactors or None
        The simulated loop's columns, the same whatever the rows: the instruments. None for least
        squares.
    slopes : Equations or None
        The simulated left side about the estimate, by which the measured one alone is explained:
        output error. None where the rows have their own regressor.
    counts : LossWeights or None
        What each row counted under a loss; None where all rows count alike.
    """

    loop: QrFactors | None = None
    slopes: Equations | None = None
    counts: LossWeights | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form."""
        names = [q.label for q in form.quantities]
        right = self.slopes or rows
        left = rows.left - right.intercept
        Z = factor(right.regressor, names) if self.loop is None else self.loop
        X = Z if self.loop is None else checked_columns(right.regressor, names)
        return instrumental_variables(left, X, Z, self.counts)
