"""Run generated text as functions: in the CasADi virtual machine, or compiled and checked.

In: generated text. Out: functions of samples, and the time loop, as native code or in the virtual
machine; the reason why native code is unavailable. Knows nothing of SymPy.
"""

from .batched_rows import (
    Decimation as Decimation,
    LaneLibrary as LaneLibrary,
    column_filter as column_filter,
)
from .casadi_functions import (
    FunctionShape as FunctionShape,
    by_sample as by_sample,
    checked_arguments as checked_arguments,
    execute as execute,
    is_continuous as is_continuous,
    recorded_count as recorded_count,
)
from .interpreted_loop import VirtualLoop as VirtualLoop
from .library import slices as slices
from .native_availability import Native as Native
