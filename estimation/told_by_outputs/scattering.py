"""Covariances of what columns make of errors: by their colour, by windows, by twins."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.regression import widened
from axisid.support.arrays import Array

from .colour import Autoregression


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
