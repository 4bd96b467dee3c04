"""Text as functions that run.

In: generated text. Out: loaded, tested and cached functions, and the time loop.
Knows nothing of SymPy.
"""

from .arguments import VECTORS as VECTORS
from .arguments import by_sample as by_sample
from .arguments import checked_arguments as checked_arguments
from .arguments import is_scalar as is_scalar
from .execute import execute as execute
from .virtual_loop import VirtualLoop as VirtualLoop
