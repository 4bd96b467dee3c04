"""Programs in each language.

In: `Program`. Out: text. Knows nothing of axes and compilers. Printers of whole files are named by
the rows of `axisid.export_targets`.
"""

from .c import (
    has_known_part as has_known_part,
    print_c_filter as print_c_filter,
    print_c_function as print_c_function,
    print_c_lanes as print_c_lanes,
    print_c_loop as print_c_loop,
    print_c_loop_header as print_c_loop_header,
    print_c_prelude as print_c_prelude,
    print_c_rows as print_c_rows,
    with_loop_header as with_loop_header,
)
from .python import print_function as print_function
