"""Which model, and which cut-off: many estimates of the same rows, one held against another.

In: axes, records, cut-offs. Out: `Comparison`, `Sweep`, each with what it recommends and why. Knows
nothing of how it is shown.
"""

from .comparison import (
    Candidate as Candidate,
    Comparison as Comparison,
    Criteria as Criteria,
    compare as compare,
)
from .cutoff_sweep import Sweep as Sweep, default_cutoffs as default_cutoffs, sweep as sweep
from .nested_models import NestedTest as NestedTest
