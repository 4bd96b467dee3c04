"""Programs in each language.

In: `Program`. Out: text. Knows nothing of axes and compilers.
"""

from .c import print_c_function as print_c_function
from .c import print_c_loop as print_c_loop
from .c import print_c_prelude as print_c_prelude
from .c import print_c_rows as print_c_rows
from .c99 import print_c99 as print_c99
from .casadi import print_function as print_function
from .python import print_python as print_python
from .structured_text import print_st as print_st
