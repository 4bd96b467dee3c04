"""Generated C as functions that run: compiled, tested, cached and called.

In: generated C. Out: native functions, or why there are none. Knows nothing of SymPy.
"""

from .batched_rows import (
    Decimation as Decimation,
    LaneLibrary as LaneLibrary,
    column_filter as column_filter,
)
from .library import slices as slices
from .native import Native as Native
