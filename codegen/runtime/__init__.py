"""Text as functions that run.

In: generated text. Out: loaded, tested and cached functions, and the time loop.
Knows nothing of SymPy.
"""

from .arguments import VECTORS as VECTORS
from .arguments import by_sample as by_sample
from .arguments import checked_arguments as checked_arguments
from .execute import execute as execute
from .native import Native as Native
from .native_errors import NativeUnavailableError as NativeUnavailableError
from .slices import slices as slices
from .virtual_loop import VirtualLoop as VirtualLoop
