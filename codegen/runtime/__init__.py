"""Text as functions that run.

In: generated text. Out: functions of samples, and the time loop in the CasADi virtual machine.
Knows nothing of SymPy and of compilers.
"""

from .casadi_functions import (
    FunctionShape as FunctionShape,
    by_sample as by_sample,
    checked_arguments as checked_arguments,
    execute as execute,
    is_continuous as is_continuous,
    recorded_count as recorded_count,
)
from .interpreted_loop import VirtualLoop as VirtualLoop
