"""Rows of many lanes of an axis, and filters of columns side by side, in compiled code."""

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
    """Filter of columns, forward and backward, with decimation.

    The attributes are in the order of the compiled functions' arguments.

    Attributes
    ----------
    sizes : (10,) array of int
        First sample, samples, first and one after the last with weight, padding, samples of a
        block, end of the first block, blocks before the first row, blocks, rows.
    powers : (every + 1, 8) array
        Powers of the poles, real and imaginary part of one of each pair in turn.
    gains, settled : (8,) array
        Gains of the modes in the sum, and their settled state for an input of ones.
    ends : (8, 8) array
        Start of the backward modes, by the distance of the forward modes from their settled state.
    direct : float
        Direct weight of a value in the sum, in addition to the modes.
    """

    sizes: NDArray[np.int64]
    powers: Array
    gains: Array
    settled: Array
    ends: Array
    direct: float


class LaneLibrary(LoadedLibrary):
    """Compiled rows of lanes; arrays are contiguous, (N, L) or (n, columns, L).

    Parameters
    ----------
    path : Path
    parameters : int
    known : bool
        Whether rows have a part that no parameter scales.
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
        """Write the low-passed position and its differences, (N, L) each, into three arrays."""
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
        """Return regressor, any known part, and force of measured lanes, (n, columns, L)."""
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
        """Return regressor and any known part of simulated lanes, (n, columns, L)."""
        given = (*loops, before, np.ascontiguousarray(parameters.T), _bytes(excluded))
        return self._decimated(
            "lanes_simulated", loops[0].shape, given, decimation, (self._columns,)
        )

    def weights(self, excluded: NDArray[np.bool_], decimation: Decimation) -> Array:
        """Return the rows of ones without excluded samples, (n, L)."""
        return self._decimated("lanes_weights", excluded.shape, (_bytes(excluded),), decimation)

    def turns(self, velocity: Array, rest: float, reach: int) -> NDArray[np.bool_]:
        """Return samples, (N, L), within a reach of slow reversals and rests."""
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
        """Return products of the regressor's columns, (p, p, L), over samples (N,) that are kept.

        The products are of samples faster than a lane's slow speed, (L,), and of samples that are
        not near reversals.
        """
        samples, lanes = near.shape
        size = self._parameters
        moving, left = np.empty((size, size, lanes)), np.empty((size, size, lanes))
        masks = (_bytes(kept), _bytes(near))
        self("lanes_information", samples, lanes, *motion, *masks, slow, moving, left)
        return moving, left

    def products(self, one: Array, other: Array) -> Array:
        """Return sums over rows of products of columns, (p, q, L), of (n, p, L) and (n, q, L)."""
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
        """Return the rows, (n, *kept, L), that a function makes of samples and lanes, (N, L)."""
        every, blocks, rows = map(int, decimation.sizes[[5, 8, 9]])
        columns, groups = self._columns + 1, -(-shape[1] // _WIDE)
        blocked = every * (_STREAMS + 2 * columns + 1)
        states = groups * (_STRETCH + -(-blocks // _STRETCH) + 1)
        work = self.memory(_WIDE + (blocked + columns * states * _STATES) * _WIDE)
        out = np.empty((rows, *kept, shape[1]))
        self(function, *shape, *given, *decimation, out, work)
        return out


def _rows_apart(columns: Array) -> Array:
    """Return columns (n, p, L), contiguous except for their rows, which may be strided."""
    return columns if columns[0].flags.c_contiguous else np.ascontiguousarray(columns)


def _bytes(chosen: NDArray[np.bool_] | None) -> NDArray[np.uint8] | None:
    return None if chosen is None else np.ascontiguousarray(chosen).view(np.uint8)


_FILTERED = 4  # as in the C text
_KEPT = 2**21  # workspace values that a thread keeps, 17 MB


class ColumnFilter(LoadedLibrary):
    """Second-order sections forward and backward along columns.

    SciPy filters one column after the other, and waits for each sum before it begins the next;
    columns in parallel take as long as one. The results are equal to the last bit.
    """

    def without_phase(self, columns: Array, sections: Array, settled: Array, padding: int) -> Array:
        """Return columns (N, k) filtered without phase, with odd extensions at both ends, (N, k).

        Parameters
        ----------
        columns : (N, k) array
        sections : (s, 6) array
            Sections in SciPy's form; at most 5.
        settled : (s, 2) array
            Their state after a step has settled.
        padding : int
            Samples of an extension.
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
    """Return the compiled filter, made when first needed; None where it is unavailable."""
    with contextlib.suppress(NativeUnavailableError, OSError):
        return ColumnFilter(compiled_library(print_c_filter()), "filter_columns")
    return None
