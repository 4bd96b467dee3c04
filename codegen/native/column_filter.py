"""Filters of columns side by side in compiled code, the same for every axis."""

import contextlib
from functools import lru_cache
from threading import local

import numpy as np

from axisid.codegen.printers import print_c_filter
from axisid.support.arrays import Array

from .errors import NativeUnavailableError, WrongLibraryError
from .library import Caller, LoadedLibrary
from .library_cache import compiled_library
from .workshop import Workshop

_WIDE = 4  # as in the C text
_KEPT = 2**21  # values to work in that a thread keeps, 17 MB
_SAMPLES, _COLUMNS, _PADDING = 50, 11, 6  # of the trial; more columns than registers


class ColumnFilter:
    """Second-order sections forward and backward along columns.

    SciPy filters one column after the other, and waits for each sum before it begins the next;
    columns side by side take as long as one. What comes of it is the same to the last bit.

    Parameters
    ----------
    call : callable
        Calls the library's function.
    """

    def __init__(self, call: Caller) -> None:
        self._call = call
        self._own = local()

    def without_phase(self, columns: Array, sections: Array, settled: Array, padding: int) -> Array:
        """Columns (N, k) with odd extensions at both ends, (N, k).

        Parameters
        ----------
        columns : (N, k) array
        sections : (s, 6) array
            As SciPy has them; at most 5.
        settled : (s, 2) array
            Their state after a step has settled.
        padding : int
            Samples of an extension.
        """
        samples, count = columns.shape
        over_time, over_columns = (stride // columns.itemsize for stride in columns.strides)
        out = np.empty((samples, count))
        self._call(
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
            self._memory((samples + 2 * padding + 1) * _WIDE),
        )
        return out

    def _memory(self, size: int) -> Array:
        """Floats to work in; each thread has its own."""
        kept: Array | None = getattr(self._own, "memory", None)
        if kept is None or len(kept) < size:
            kept = np.empty(size)
            if size <= _KEPT:
                self._own.memory = kept
        return kept


@lru_cache(maxsize=1)
def column_filter() -> ColumnFilter | None:
    """Return the compiled filter, made when first needed; None where it cannot be had."""
    with contextlib.suppress(NativeUnavailableError, OSError):
        path = compiled_library(print_c_filter(), _check)
        return ColumnFilter(LoadedLibrary(path, "filter_columns"))
    return None


def _check(workshop: Workshop) -> None:
    """Compare a fresh library with sections one value after the other."""
    rng = np.random.default_rng(0)
    sections = np.array([[0.2, 0.3, 0.1, 1.0, -0.5, 0.2], [0.7, -0.2, 0.4, 1.0, 0.3, 0.1]])
    settled = rng.uniform(-1.0, 1.0, (len(sections), 2))
    columns = rng.uniform(-1.0, 1.0, (_SAMPLES, _COLUMNS))
    found = ColumnFilter(workshop.call).without_phase(columns, sections, settled, _PADDING)
    ends = columns[_PADDING:0:-1], columns[-2 : -_PADDING - 2 : -1]
    wanted = np.concatenate([2 * columns[0] - ends[0], columns, 2 * columns[-1] - ends[1]])
    for _ in range(2):
        wanted = _passed(wanted, sections, settled)[::-1]
    if not np.allclose(found, wanted[_PADDING:-_PADDING], rtol=1e-12, atol=1e-12):
        raise WrongLibraryError("the compiled filter is wrong")


def _passed(values: Array, sections: Array, settled: Array) -> Array:
    """Values (N, k) through sections, from states that are so many times the first."""
    first = values[0]
    for (b0, b1, b2, _, a1, a2), (one, two) in zip(sections, settled, strict=True):
        state, made = (one * first, two * first), np.empty_like(values)
        for k, x in enumerate(values):
            made[k] = b0 * x + state[0]
            state = b1 * x - a1 * made[k] + state[1], b2 * x - a2 * made[k]
        values = made
    return values
