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
from axisid.estimation.regression import Solution, factor, instrumental_variables, least_squares
from axisid.estimation.signals import RowTimes
from axisid.support.arrays import Array, Exact
from axisid.support.errors import DataError

_MIN_TRAINING_ROWS_PER_PARAMETER = 5  # left to estimate from; with fewer no block is held out

_BLOCKS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Regression:
    """A regression that can be solved again on part of its rows.

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
        return replace(
            self,
            left=self.left[rows],
            regressor=self.regressor[rows],
            instruments=None if self.instruments is None else self.instruments[rows],
            neighbours=self.neighbours[rows],
        )

    def solved(self, *, by_instruments: bool = True) -> Solution:
        """By instruments where there are any and they are wanted, else by least squares."""
        regressor = factor(self.regressor, self.names, neighbours=self.neighbours)
        if self.instruments is None or not by_instruments:
            return least_squares(self.left, regressor)
        instruments = factor(self.instruments, self.names, "the simulated loop")
        return instrumental_variables(self.left, regressor, instruments)


def regression_rows(estimate: Estimate) -> Regression:
    """The rows that an inverse model's estimate was made from."""
    axis, weights = estimate.form.axis, estimate.weights
    return Regression(
        left=weights * (estimate.residuals + estimate.X @ estimate.theta),
        regressor=weights[:, None] * estimate.X,
        instruments=None if estimate.Z is None else weights[:, None] * estimate.Z,
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


def contiguous_blocks(rows: int, gap: int, parameters: int) -> tuple[HeldOutBlock, ...]:
    """Ten blocks of equal length, one after the other.

    Parameters
    ----------
    rows : int
        Of the regression.
    gap : int
        Rows left out on both sides of a block.
    parameters : int
        Of the richest model that is to be estimated.

    Raises
    ------
    DataError
        Too few rows are left to estimate from.
    """
    edges = np.linspace(0, rows, _BLOCKS + 1).round().astype(int)
    left = rows - int(np.diff(edges).max()) - 2 * gap
    if left < _MIN_TRAINING_ROWS_PER_PARAMETER * parameters:
        raise DataError(
            f"the record leaves {rows} rows; with a block of 1/{_BLOCKS} held out and a gap of "
            f"{gap} rows on both sides, the filters' memory, {max(left, 0)} are left for "
            f"{parameters} parameters. Record longer, or raise the cutoff and decimate less.",
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
        return float(difference.mean()), float(np.std(difference, ddof=1)) / len(difference) ** 0.5


def held_out_equation(rows: Regression, blocks: Sequence[HeldOutBlock], signal: float) -> HeldOut:
    """Errors of the equation, by the size of what all rows together have.

    Raises
    ------
    EstimationError
        Without some block the parameters cannot be told apart.
    """
    pairs = ((rows.at(each.held_out), rows.at(each.training).solved().theta) for each in blocks)
    squares = [np.sum((test.left - test.regressor @ theta) ** 2) for test, theta in pairs]
    return HeldOut(squares=np.array(squares), signal=signal)
