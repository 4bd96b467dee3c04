"""Text as functions that run.

In: generated text. Out: functions of samples, and the time loop in the CasADi virtual machine.
Knows nothing of SymPy and of compilers.
"""

from .arguments import FunctionShape as FunctionShape
from .arguments import along_samples as along_samples
from .arguments import by_sample as by_sample
from .arguments import checked_arguments as checked_arguments
from .arguments import is_continuous as is_continuous
from .arguments import recorded_values as recorded_values
from .execute import execute as execute
from .virtual_loop import VirtualLoop as VirtualLoop
