"""Choice of a model and of a cut-off frequency by a comparison of estimates.

In: axes, records, cut-offs. Out: `Comparison`, `Sweep`, each with a recommendation and its reason.
Knows nothing of presentation.
"""

from .comparison import (
    Candidate as Candidate,
    Comparison as Comparison,
    Criteria as Criteria,
    compare as compare,
)
from .cutoff_sweep import Sweep as Sweep, default_cutoffs as default_cutoffs, sweep as sweep
from .nested_models import NestedTest as NestedTest
