"""Generated C as functions that run: compiled, tested, cached and called.

In: generated C. Out: native functions, or why there are none. Knows nothing of SymPy.
"""

from .column_filter import column_filter as column_filter
from .lanes import Decimation as Decimation, LaneLibrary as LaneLibrary
from .native import Native as Native
from .slices import slices as slices
