"""Filters of columns side by side in compiled code, the same for every axis."""

import contextlib
from functools import lru_cache
from threading import local

import numpy as np

from axisid.codegen.printers import print_c_filter
from axisid.support.arrays import Array

from .errors import NativeUnavailableError
from .library import Caller, LoadedLibrary
from .library_cache import compiled_library
from .trial import Trial

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
        path = compiled_library(print_c_filter(), _trial)
        return ColumnFilter(LoadedLibrary(path, "filter_columns"))
    return None


def _trial() -> Trial:
    """Columns through two sections, as SciPy has them."""
    from scipy.signal import sosfilt_zi, sosfiltfilt

    rng, trial = np.random.default_rng(0), Trial()
    sections = np.array([[0.2, 0.3, 0.1, 1.0, -0.5, 0.2], [0.7, -0.2, 0.4, 1.0, 0.3, 0.1]])
    columns = rng.uniform(-1.0, 1.0, (_SAMPLES, _COLUMNS))
    found = ColumnFilter(trial).without_phase(columns, sections, sosfilt_zi(sections), _PADDING)
    trial.expect("filter", found, sosfiltfilt(sections, columns, 0, padlen=_PADDING))
    return trial
