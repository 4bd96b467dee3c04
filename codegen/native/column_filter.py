"""Filters of columns side by side in compiled code, the same for every axis."""

import contextlib
from functools import lru_cache
from threading import local

import numpy as np

from axisid.codegen.printers import print_c_filter
from axisid.support.arrays import Array

from .compiler import NativeUnavailableError
from .library import LoadedLibrary
from .library_cache import compiled_library

_WIDE = 4  # as in the C text
_KEPT = 2**21  # values to work in that a thread keeps, 17 MB


class ColumnFilter:
    """Second-order sections forward and backward along columns.

    SciPy filters one column after the other, and waits for each sum before it begins the next;
    columns side by side take as long as one. What comes of it is the same to the last bit.

    Parameters
    ----------
    call : LoadedLibrary
    """

    def __init__(self, call: LoadedLibrary) -> None:
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
        path = compiled_library(print_c_filter())
        return ColumnFilter(LoadedLibrary(path, "filter_columns"))
    return None
