"""Errors on rows that the estimate was not made from: contiguous blocks, with a gap around each.

Neighbouring rows share samples through the filters, so rows drawn at random would be known to the
estimate already; blocks with a gap of the filters' memory are not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import Problem
from axisid.estimation.regression import (
    InverseForm,
    QrFactors,
    Solution,
    factor,
    instrumental_variables,
    least_squares,
    search_bounds,
)
from axisid.estimation.signals import RowTimes
from axisid.support.arrays import Array, Exact
from axisid.support.errors import DataError, EstimationError, Missing, ModelError

_MIN_TRAINING_ROWS_PER_PARAMETER = 5  # left to estimate from; with fewer no block is held out

_BLOCKS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Regression:
    """A regression that can be solved again on part of its rows or columns.

    Attributes
    ----------
    left : (n,) array
        Force less what no parameter scales.
    regressor : (n, k) array
    instruments : (n, k) array or None
        None for least squares.
    names : tuple of str
        Of the k parameters.
    neighbours : RowTimes
        Which of the rows follow each other in time.
    nonlinear : tuple of str
        Those about which the model is linearised.
    """

    left: Array
    regressor: Array
    instruments: Array | None
    names: tuple[str, ...]
    neighbours: RowTimes
    nonlinear: tuple[str, ...] = ()

    def at(self, rows: NDArray[np.intp]) -> "Regression":
        """Some of the rows."""
        chosen = None if self.instruments is None else self.instruments[rows]
        return replace(
            self,
            left=self.left[rows],
            regressor=self.regressor[rows],
            instruments=chosen,
            neighbours=self.neighbours[rows],
        )

    def without(self, column: int) -> "Regression":
        """Without one parameter."""
        chosen = None if self.instruments is None else np.delete(self.instruments, column, axis=1)
        return replace(
            self,
            regressor=np.delete(self.regressor, column, axis=1),
            instruments=chosen,
            names=(*self.names[:column], *self.names[column + 1 :]),
        )

    def by_least_squares(self) -> Solution:
        """Whatever the instruments."""
        return least_squares(self.left, self._factored())

    def solved(self) -> Solution:
        """By instruments where there are any, else by least squares."""
        if self.instruments is None:
            return self.by_least_squares()
        instruments = factor(self.instruments, self.names, "the simulated loop")
        return instrumental_variables(self.left, self._factored(), instruments)

    def _factored(self) -> QrFactors:
        return factor(self.regressor, self.names, neighbours=self.neighbours)


def regression_rows(estimate: Estimate) -> Regression:
    """The rows that an inverse model's estimate was made from."""
    axis, explained = estimate.form.axis, estimate.X @ estimate.theta
    left, regressor, instruments = estimate.residuals + explained, estimate.X, estimate.Z
    if (weights := estimate.weights) is not None:
        left, regressor = weights * left, weights[:, None] * regressor
        instruments = None if instruments is None else weights[:, None] * instruments
    return Regression(
        left=left,
        regressor=regressor,
        instruments=instruments,
        names=tuple(q.name for q in estimate.quantities),
        neighbours=estimate.neighbours,
        nonlinear=tuple(
            name
            for name, is_nonlinear in zip(axis.names, axis.nonlinear, strict=True)
            if is_nonlinear
        ),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldOutBlock:
    """Rows to predict, and those to estimate from: all others but a gap on both sides."""

    held_out: NDArray[np.intp]
    training: NDArray[np.intp]


def contiguous_blocks(
    rows: int, gap: int, parameters: int, *, count: int = _BLOCKS
) -> tuple[HeldOutBlock, ...]:
    """Blocks of equal length, one after the other.

    Parameters
    ----------
    rows : int
        Of the regression.
    gap : int
        Rows left out on both sides of a block.
    parameters : int
        Of the richest model that is to be estimated.
    count : int
        Of the blocks.

    Raises
    ------
    DataError
        Too few rows are left to estimate from.
    """
    edges = np.linspace(0, rows, count + 1).round().astype(int)
    left = rows - int(np.diff(edges).max()) - 2 * gap
    if left < _MIN_TRAINING_ROWS_PER_PARAMETER * parameters:
        raise DataError(
            f"the record leaves {rows} rows; with a block of 1/{count} held out and a gap of {gap} "
            f"rows on both sides, the filters' memory, {max(left, 0)} are left for {parameters} "
            "parameters. Record longer, or raise the cutoff and decimate less.",
            code="too-short",
        )
    index = np.arange(rows)
    return tuple(
        HeldOutBlock(
            held_out=index[first:last],
            training=np.flatnonzero((index < first - gap) | (index >= last + gap)),
        )
        for first, last in pairwise(edges)
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeldOut(Exact):
    """Errors over blocks that were held out, each block by the estimate from the others.

    Attributes
    ----------
    squares : (b,) array
        Sum of the squared errors in each block.
    signal : float
        ``||y||`` over all rows.
    """

    squares: Array
    signal: float

    @property
    def error_percent(self) -> float:
        """``100 ||error|| / ||y||`` over all blocks."""
        return 100.0 * float(np.sqrt(self.squares.sum())) / self.signal

    def excess(self, other: "HeldOut") -> tuple[float, float]:
        """Mean excess of the squares over another's, and its standard error over the blocks."""
        difference = self.squares - other.squares
        error = float(np.std(difference, ddof=1)) / len(difference) ** 0.5
        return float(difference.mean()), error


def held_out_equation(
    rows: Regression, blocks: Sequence[HeldOutBlock], signal: float
) -> tuple[HeldOut, tuple[Array, ...]]:
    """Errors of the equation, and the estimate (k,) that each block was predicted with.

    Raises
    ------
    EstimationError
        Without some block the parameters cannot be told apart.
    """
    squares, estimates = [], []
    for block in blocks:
        theta = rows.at(block.training).solved().theta
        test = rows.at(block.held_out)
        squares.append(float(np.sum((test.left - test.regressor @ theta) ** 2)))
        estimates.append(theta)
    return HeldOut(squares=np.array(squares), signal=signal), tuple(estimates)


def held_out_simulation(
    problem: Problem,
    estimate: Estimate,
    blocks: Sequence[HeldOutBlock],
    thetas: Sequence[Array],
) -> HeldOut | Missing:
    """Errors of the loops simulated over all records with each block's estimate, on its rows.

    Nonlinear parameters are kept within their bounds: a linearised step may leave them.

    Returns
    -------
    HeldOut or Missing
        The reason where the loop cannot be simulated.
    """
    form, squares = problem.form(InverseForm), []
    weights = 1.0 if estimate.weights is None else estimate.weights
    try:
        for block, step in zip(blocks, thetas, strict=True):
            theta = step if form.is_linear else np.clip(step, *search_bounds(problem.axis))
            _, right = problem.simulated(form, form.physical(theta)[0])
            left = weights * estimate.y - right.regressor @ theta - right.intercept
            error = left[block.held_out]
            squares.append(float(error @ error))
    except (ModelError, DataError, EstimationError) as failure:
        return Missing(str(failure))
    signal = float(np.linalg.norm(weights * estimate.y))
    return HeldOut(squares=np.array(squares), signal=signal)
