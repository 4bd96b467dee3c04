"""Held-out errors: prediction errors on rows that were not used for the estimate.

The held-out rows form contiguous blocks with a gap on both sides. Neighbouring rows share samples
through the filters, so that rows drawn at random would be correlated with the rows of the estimate;
blocks with a gap as long as the memory of the filters are not.
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

_MIN_TRAINING_ROWS_PER_PARAMETER = 5  # with fewer rows to estimate from, no block is held out

_BLOCKS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Regression:
    """A regression that can be solved again on part of its rows.

    Attributes
    ----------
    left : (n,) array
        Force minus known terms.
    regressor : (n, k) array
        Derivatives of the left side by the k parameters.
    instruments : (n, k) array or None
        None for least squares.
    names : tuple of str
        Names of the k parameters.
    neighbours : RowTimes
        Times of the rows.
    nonlinear : tuple of str
        Names of the parameters that enter nonlinearly, and in which the model is linearised.
    """

    left: Array
    regressor: Array
    instruments: Array | None
    names: tuple[str, ...]
    neighbours: RowTimes
    nonlinear: tuple[str, ...] = ()

    def at(self, rows: NDArray[np.intp]) -> "Regression":
        """Return the regression on some of the rows, given by their indices."""
        return replace(
            self,
            left=self.left[rows],
            regressor=self.regressor[rows],
            instruments=None if self.instruments is None else self.instruments[rows],
            neighbours=self.neighbours[rows],
        )

    def solved(self, *, by_instruments: bool = True) -> Solution:
        """Return the solution by instrumental variables, or by least squares.

        Least squares is used if there are no instruments, or if `by_instruments` is False.
        """
        regressor = factor(self.regressor, self.names, neighbours=self.neighbours)
        if self.instruments is None or not by_instruments:
            return least_squares(self.left, regressor)
        instruments = factor(self.instruments, self.names, "the simulated loop")
        return instrumental_variables(self.left, regressor, instruments)


def regression_rows(estimate: Estimate) -> Regression:
    """Return the weighted rows of an estimate of the inverse model."""
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
    """A block of rows that is held out of an estimate.

    Attributes
    ----------
    held_out : (h,) array of int
        Indices of the held-out rows.
    training : (t,) array of int
        Indices of the rows for the estimate: all others except the gaps on both sides.
    """

    held_out: NDArray[np.intp]
    training: NDArray[np.intp]


def contiguous_blocks(rows: int, gap: int, parameters: int) -> tuple[HeldOutBlock, ...]:
    """Return ten contiguous blocks of equal length, which together have all rows.

    Parameters
    ----------
    rows : int
        Number of rows of the regression.
    gap : int
        Number of rows on both sides of a block that are not used for the estimate.
    parameters : int
        Number of parameters of the model.

    Raises
    ------
    DataError
        Too few rows remain to estimate from.
    """
    edges = np.linspace(0, rows, _BLOCKS + 1).round().astype(int)
    remaining = rows - int(np.diff(edges).max()) - 2 * gap
    if remaining < _MIN_TRAINING_ROWS_PER_PARAMETER * parameters:
        raise DataError(
            f"the record has {rows} rows. With a block of 1/{_BLOCKS} of them held out, and a gap "
            f"of {gap} rows (the memory of the filters) on both sides, {max(remaining, 0)} rows "
            f"remain for {parameters} parameters. Record a longer motion, or raise the cutoff and "
            "decimate less.",
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
    """Prediction errors of held-out blocks, each by the estimate from the other rows.

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
        """Held-out error ``100 ||e|| / ||y||`` over all blocks, %."""
        return 100.0 * float(np.sqrt(self.squares.sum())) / self.signal

    def excess(self, other: "HeldOut") -> tuple[float, float]:
        """Return the mean excess of squared errors over another model, and its standard error.

        The excess is that of the sum of squared errors of each block. The mean is over the blocks,
        and the standard error follows from the scatter of the blocks.
        """
        difference = self.squares - other.squares
        return float(difference.mean()), float(np.std(difference, ddof=1)) / len(difference) ** 0.5


def held_out_equation(rows: Regression, blocks: Sequence[HeldOutBlock], signal: float) -> HeldOut:
    """Return the prediction errors of held-out blocks, each by the estimate from its other rows.

    Parameters
    ----------
    rows : Regression
        Regression of all rows.
    blocks : sequence of HeldOutBlock
        Held-out blocks of the rows.
    signal : float
        ``||y||`` over all rows.

    Raises
    ------
    EstimationError
        Without some block the parameters cannot be separated.
    """
    squares = []
    for block in blocks:
        test, theta = rows.at(block.held_out), rows.at(block.training).solved().theta
        squares.append(np.sum((test.left - test.regressor @ theta) ** 2))
    return HeldOut(squares=np.array(squares), signal=signal)
