"""What is generated of an axis, and the folder that holds it.

In: `AxisModel`. Out: texts, `GeneratedAxis`.
Knows nothing of records.
"""

from .folder import check_files as check_files
from .folder import expected_files as expected_files
from .folder import replace_file as replace_file
from .folder import write_files as write_files
from .generated_axis import GeneratedAxis as GeneratedAxis
from .generated_axis import Quantity as Quantity
from .generated_axis import as_declared as as_declared
from .generated_axis import as_generated as as_generated
from .generated_axis import build as build
from .law_functions import law_functions as law_functions
from .texts import MANIFEST as MANIFEST
from .texts import signature as signature
