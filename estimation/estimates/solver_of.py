"""How the rows of an estimate were solved, so that others can be solved alike."""

from axisid.estimation.problems import ByInstruments, ByLeastSquares, ByOutputError, Solver
from axisid.estimation.regression import factor

from .estimate import Estimate


def solver_of(estimate: Estimate) -> Solver:
    """What solves rows of the estimate's own records as the estimate's were, weighted like them.

    Raises
    ------
    EstimationError
        The simulated loop's columns cannot be told apart.
    """
    columns = estimate.loop_rows
    if columns is None:
        return ByLeastSquares(estimate.counts)
    weights = estimate.row_weights
    loop = factor(
        weights[:, None] * columns,
        [q.label for q in estimate.form.quantities],
        "the simulated loop",
        estimate.neighbours,
    )
    if not estimate.by_output_error:
        return ByInstruments(loop, estimate.counts)
    intercept = estimate.y - estimate.residuals - estimate.X @ estimate.theta
    return ByOutputError(weights * intercept, loop, estimate.counts)
