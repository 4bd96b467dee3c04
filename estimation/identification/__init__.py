"""The pipeline: an axis and a record to estimates that are judged.

In: `Axis`, `Record`, `Prefilter`. Out: `Identification`.
Knows nothing of how it is shown.
"""

from .identify import identify as identify
from .identify import identify_filtered as identify_filtered
from .result import Identification as Identification
