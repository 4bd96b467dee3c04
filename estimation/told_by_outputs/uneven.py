"""Errors whose colour changes on the way, as those of an axis whose friction remembers.

Such friction is a spring at rest and a damper in motion, so that noise of the position comes back
otherwise in a dwell than in a swing, and a start that is a little off stays until the axis slides.
An autoregression has one colour for all of it. Two others ask for none: what twins make of it that
are simulated with such noise, and the products of neighbouring scores, as [NeweyWest1987]_ has
them, which also see what is no noise of the position, from fewer independent errors. The larger
counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.regression import Hac, score_products, widened
from axisid.estimation.signals import Neighbours
from axisid.support.arrays import Array

from .colour import Autoregression

# s, over which errors are held against each other where friction remembers: measured, deviations
# of a LuGre axis by half of it are 0.5 to 0.9 of their scatter, by all of it 0.6 to 1.0; twins
# have the rest
_SCORES_ALIKE = 0.4

_FEWEST_ROWS = 4  # for each lag


@dataclass(frozen=True, slots=True, kw_only=True)
class Scattering:
    """Covariance of what columns make of errors, and how sure it is.

    Attributes
    ----------
    matrix : (k, k) array
    freedom : (k,) array
        Degrees of freedom of each variance.
    """

    matrix: Array
    freedom: Array

    def beside(self, sure: Array) -> "Scattering":
        """The sum with a covariance (k, k) that is known."""
        return added([self, Scattering(matrix=sure, freedom=np.full(len(sure), np.inf))])


def added(found: Sequence[Scattering]) -> Scattering:
    """The sum of independent ones, such as those of records: of how many degrees it is."""
    matrix = np.sum([each.matrix for each in found], axis=0)
    whole = np.diag(matrix)
    unsure = np.sum([np.diag(each.matrix) ** 2 / each.freedom for each in found], axis=0)
    freedom = np.divide(whole**2, unsure, out=np.full(len(whole), np.inf), where=unsure > 0)
    return Scattering(matrix=matrix, freedom=freedom)


def uneven(
    columns: Array,
    errors: Array,
    twins: Array,
    spans: Sequence[slice],
    period: float,
    outputs: int = 1,
) -> Scattering:
    """Of columns (n, k) and errors (n,), by twins and by the scores, whichever is more.

    Parameters
    ----------
    columns : (n, k) array
    errors : (n,) array
    twins : (n, B) array
        What noise makes of the errors, B draws.
    spans : sequence of slice
        The record's stretches.
    period : float
        s
    outputs : int
        Whose rows of a sample are neighbours: their scores are of one time.
    """
    k = columns.shape[1]
    scores = [
        (columns[rows] * errors[rows, None]).reshape(-1, outputs, k).sum(axis=1) for rows in spans
    ]
    pieces = Neighbours.joined([Neighbours.consecutive(len(each)) for each in scores])
    whole = np.concatenate(scores)
    lags = min(round(_SCORES_ALIKE / period), len(whole) // _FEWEST_ROWS)
    long_run = Hac(lags).long_run(lambda most: score_products(whole, pieces, most), len(whole))
    told = Scattering(matrix=long_run.matrix, freedom=long_run.freedom)
    return larger(told, columns, twins, spans)


def by_colour(
    columns: Array, model: Autoregression, spans: Sequence[slice], rows: int, taken: float
) -> Scattering:
    """Of columns (n, k) and a record's errors that follow a model, as sure as that model is.

    Parameters
    ----------
    columns : (n, k) array
    model : Autoregression
    spans : sequence of slice
        The record's stretches.
    rows : int
        Errors that the model was found from.
    taken : float
        Degrees of freedom that a fit has taken from them, so that they are smaller than before.
    """
    nothing = np.zeros((columns.shape[1], columns.shape[1]))
    matrix = sum((model.coloured(columns[each]) for each in spans), nothing)
    whole = np.array(
        [2 / model.uncertainty([column[each] for each in spans], rows) for column in columns.T]
    )
    return _less_taken(matrix, whole, taken)


def by_windows(columns: Array, errors: Array, windows: Sequence[slice], taken: float) -> Scattering:
    """Of columns (n, k) and errors of windows that are independent of each other, by their scores.

    A sandwich clustered by window: what moves an axis besides its control is summed up twice in the
    errors of an open loop, as no autoregression is. As many windows count for a column as it is
    alike in.

    Parameters
    ----------
    columns, taken
        As in `by_colour`.
    errors : (n,) array
    windows : sequence of slice

    References
    ----------
    [Wooldridge2010]_, chapter 20.
    """
    scores = np.array([columns[rows].T @ errors[rows] for rows in windows])
    sizes = np.array([np.sum(columns[rows] ** 2, axis=0) for rows in windows])
    whole = sizes.sum(axis=0) ** 2 / np.maximum(np.sum(sizes**2, axis=0), np.finfo(float).tiny)
    return _less_taken(scores.T @ scores, whole, taken)


def _less_taken(matrix: Array, whole: Array, taken: float) -> Scattering:
    """A covariance of so many degrees of freedom (k,), of which a fit has taken some."""
    left = np.maximum(whole - taken, 1.0)
    more = np.divide(whole, left, out=np.ones_like(whole), where=np.isfinite(whole))
    return Scattering(matrix=widened(matrix, np.diag(matrix) * more), freedom=left)


def larger(told: Scattering, columns: Array, twins: Array, spans: Sequence[slice]) -> Scattering:
    """What is told of columns (n, k), or what twins (n, B) make of them where that is more."""
    pairs = ((columns[rows].T, twins[rows]) for rows in spans)
    made = sum((each @ own for each, own in pairs), np.zeros((len(told.matrix), twins.shape[1])))
    by_twins = made.var(axis=1, ddof=1)
    more = by_twins > np.diag(told.matrix)
    return Scattering(
        matrix=widened(told.matrix, by_twins),
        freedom=np.where(more, twins.shape[1] - 1.0, told.freedom),
    )
