"""Regression rows of many simulations of an axis, and filters of columns, in compiled code.

A lane is one simulation of a batch; L lanes are computed side by side.
"""

import contextlib
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.printers import print_c_filter
from axisid.support.arrays import Array

from .library import LoadedLibrary
from .library_cache import NativeUnavailableError, compiled_library

_WIDE, _STATES, _STREAMS, _STRETCH = 8, 8, 7, 16  # as in the C text


class Decimation(NamedTuple):
    """Low-pass filter of columns, forward and backward, with decimation to rows.

    The filter is a sum of modes, one for each pair of complex poles. The attributes are in the
    order of the arguments of the compiled functions.

    Attributes
    ----------
    sizes : (10,) array of int
        First sample, number of samples, first sample with weight and the one after the last,
        padding, samples of a block, end of the first block, blocks before the first row, blocks,
        rows.
    powers : (every + 1, 8) array
        Powers of the poles: real and imaginary part of one pole of each pair in turn.
    gains, settled : (8,) array
        Gains of the modes in the sum, and their steady state for an input of ones.
    ends : (8, 8) array
        Matrix that gives the initial state of the backward modes, from the difference between the
        final state of the forward modes and their steady state.
    direct : float
        Direct feedthrough: weight of an input value in the sum, in addition to the modes.
    """

    sizes: NDArray[np.int64]
    powers: Array
    gains: Array
    settled: Array
    ends: Array
    direct: float


class LaneLibrary(LoadedLibrary):
    """Compiled functions that compute regression rows from the signals of L lanes.

    Arrays are contiguous: (N, L) for samples, (n, columns, L) for rows.

    Parameters
    ----------
    path : Path
        Path of the library.
    parameters : int
        Number of parameters.
    known : bool
        True if the force has a part without a parameter, which is then one more column.
    """

    def __init__(self, path: Path, parameters: int, *, known: bool) -> None:
        super().__init__(path, "lanes_measured")
        self._parameters, self._columns = parameters, parameters + known

    def motion(
        self,
        position: Array,
        sections: Array,
        settled: Array,
        padding: int,
        period: float,
        into: Sequence[Array],
    ) -> None:
        """Write the low-passed position and its first and second differences into three arrays.

        Parameters
        ----------
        position : (N, L) array
        sections : array
            Second-order sections of the low-pass.
        settled : array
            Steady state of the sections for a unit step.
        padding : int
            Samples by which the signal is extended at each end.
        period : float
            Sampling period, s.
        into : sequence of (N, L) array
            Arrays for position, velocity and acceleration.
        """
        samples, lanes = position.shape
        self(
            "lanes_motion",
            samples,
            lanes,
            np.ascontiguousarray(position),
            len(sections),
            sections,
            settled,
            padding,
            float(period),
            *into,
            self.memory(_WIDE + (samples + 2 * padding) * _WIDE),
        )

    def measured(
        self,
        control: Array,
        motion: tuple[Array, Array, Array],
        delay: float,
        excluded: NDArray[np.bool_] | None,
        decimation: Decimation,
    ) -> Array:
        """Return the regression rows of measured lanes, (n, columns, L).

        The columns are the regressor, the known part if there is one, and the force.

        Parameters
        ----------
        control : (N, L) array
        motion : tuple of (N, L) array
            Position, velocity and acceleration.
        delay : float
            Fraction of a sample by which the force follows the control: the force is the mean of
            the present one, with the weight 1 - delay, and the one before.
        excluded : (N, L) array of bool or None
            Samples without weight; None for none.
        decimation : Decimation
        """
        given = (np.ascontiguousarray(control), *motion, float(delay), _bytes(excluded))
        return self._decimated(
            "lanes_measured", control.shape, given, decimation, (self._columns + 1,)
        )

    def simulated(
        self,
        loops: tuple[Array, ...],
        before: Array | None,
        parameters: Array,
        excluded: NDArray[np.bool_] | None,
        decimation: Decimation,
    ) -> Array:
        """Return the regression rows of simulated lanes, (n, columns, L).

        The columns are the regressor, and the known part if there is one.

        Parameters
        ----------
        loops : tuple of (N, L) array
            Signals of the simulations.
        before : (N, L) array or None
            Friction direction just before each sample, with which the row is the mean of just
            before and just after the sample; None if it does not change there.
        parameters : (L, p) array
        excluded : (N, L) array of bool or None
            Samples without weight; None for none.
        decimation : Decimation
        """
        given = (*loops, before, np.ascontiguousarray(parameters.T), _bytes(excluded))
        return self._decimated(
            "lanes_simulated", loops[0].shape, given, decimation, (self._columns,)
        )

    def weights(self, excluded: NDArray[np.bool_], decimation: Decimation) -> Array:
        """Return the weight of each row, (n, L): a filtered and decimated signal.

        The signal is 1 at samples that are used, and 0 at excluded ones.
        """
        return self._decimated("lanes_weights", excluded.shape, (_bytes(excluded),), decimation)

    def turns(self, velocity: Array, rest: float, reach: int) -> NDArray[np.bool_]:
        """Return a mask, (N, L), of samples close to a velocity reversal or to standstill.

        Parameters
        ----------
        velocity : (N, L) array
        rest : float
            Share of the largest speed of a lane, up to which the axis is at standstill.
        reach : int
            Number of samples on each side that are close.
        """
        samples, lanes = velocity.shape
        out = np.empty((samples, lanes), dtype=np.bool_)
        self("lanes_turns", samples, lanes, velocity, float(rest), reach, _bytes(out))
        return out

    def information(
        self,
        motion: tuple[Array, Array, Array],
        kept: NDArray[np.bool_],
        near: NDArray[np.bool_],
        slow: Array,
    ) -> tuple[Array, Array]:
        """Return two sums of products of the regressor's columns, (p, p, L) each.

        The first sum is over samples that are faster than the slow speed of their lane. The second
        sum is over samples that are not close to a reversal.

        Parameters
        ----------
        motion : tuple of (N, L) array
        kept : (N,) array of bool
            Samples that are used in either sum.
        near : (N, L) array of bool
            Samples close to a reversal.
        slow : (L,) array
            Slow speed of each lane.
        """
        samples, lanes = near.shape
        size = self._parameters
        moving, left = np.empty((size, size, lanes)), np.empty((size, size, lanes))
        masks = (_bytes(kept), _bytes(near))
        self("lanes_information", samples, lanes, *motion, *masks, slow, moving, left)
        return moving, left

    def products(self, one: Array, other: Array) -> Array:
        """Return sums over rows of products of columns, (p, q, L), from (n, p, L) and (n, q, L)."""
        (rows, p, lanes), q = one.shape, other.shape[1]
        out = np.empty((p, q, lanes))
        one, other = _rows_apart(one), _rows_apart(other)
        apart = (one.strides[0] // one.itemsize, other.strides[0] // other.itemsize)
        self("lanes_products", rows, lanes, p, q, one, apart[0], other, apart[1], out)
        return out

    def _decimated(
        self,
        function: str,
        shape: tuple[int, int],
        given: Sequence[float | NDArray[Any] | None],
        decimation: Decimation,
        kept: tuple[int, ...] = (),
    ) -> Array:
        """Return the rows, (n, *kept, L), that a compiled function computes from samples (N, L).

        Parameters
        ----------
        function : str
            Name of the C function.
        shape : (int, int)
            N and L.
        given : sequence
            Arguments of the function before the decimation.
        decimation : Decimation
        kept : tuple of int
            Number of columns of a row; empty for one value in each row.
        """
        every, blocks, rows = map(int, decimation.sizes[[5, 8, 9]])
        columns, groups = self._columns + 1, -(-shape[1] // _WIDE)
        blocked = every * (_STREAMS + 2 * columns + 1)
        states = groups * (_STRETCH + -(-blocks // _STRETCH) + 1)
        work = self.memory(_WIDE + (blocked + columns * states * _STATES) * _WIDE)
        out = np.empty((rows, *kept, shape[1]))
        self(function, *shape, *given, *decimation, out, work)
        return out


def _rows_apart(columns: Array) -> Array:
    """Return columns, (n, p, L), in which each row is contiguous; copied only if necessary."""
    return columns if columns[0].flags.c_contiguous else np.ascontiguousarray(columns)


def _bytes(chosen: NDArray[np.bool_] | None) -> NDArray[np.uint8] | None:
    """Return a mask as bytes; None for None."""
    return None if chosen is None else np.ascontiguousarray(chosen).view(np.uint8)


_FILTERED = 4  # columns that are filtered in parallel, as in the C text
_KEPT = 2**21  # values of the largest workspace that a thread keeps, 17 MB


class ColumnFilter(LoadedLibrary):
    """Second-order sections applied forward and backward along columns, in compiled code.

    SciPy filters one column at a time, and each sum waits for the previous one. Here several
    columns are filtered at once in the time of one column. The results are equal to SciPy's to the
    last bit.
    """

    def without_phase(self, columns: Array, sections: Array, settled: Array, padding: int) -> Array:
        """Return columns, (N, k), filtered with zero phase, with odd extensions at both ends.

        Parameters
        ----------
        columns : (N, k) array
        sections : (s, 6) array
            Sections in SciPy's form; at most 5.
        settled : (s, 2) array
            Steady state of the sections for a unit step.
        padding : int
            Number of samples of an extension.
        """
        samples, count = columns.shape
        over_time, over_columns = (stride // columns.itemsize for stride in columns.strides)
        out = np.empty((samples, count))
        self(
            "filter_columns",
            samples,
            count,
            columns,
            over_time,
            over_columns,
            len(sections),
            sections,
            settled,
            padding,
            out,
            self.memory((samples + 2 * padding + 1) * _FILTERED, _KEPT),
        )
        return out


@lru_cache(maxsize=1)
def column_filter() -> ColumnFilter | None:
    """Return the compiled filter, built at the first call; None if it is unavailable."""
    with contextlib.suppress(NativeUnavailableError, OSError):
        return ColumnFilter(compiled_library(print_c_filter()), "filter_columns")
    return None
