"""Generated code of an axis, and its folder.

In: `AxisModel`. Out: texts, `GeneratedAxis`.
Knows nothing of records.
"""

from .folder import (
    check_files as check_files,
    expected_files as expected_files,
    write_files as write_files,
)
from .generated_axis import (
    GeneratedAxis as GeneratedAxis,
    Quantity as Quantity,
    as_declared as as_declared,
    as_generated as as_generated,
    build as build,
)
from .loop_by_gains import law_functions as law_functions, law_over_block as law_over_block
from .texts import MANIFEST as MANIFEST, signature as signature
