"""The moves of a record: which repeat, and what an estimate owes to each.

In: an estimate and the record behind its filter. Out: its residuals split into noise and what the
model lacks, and how far parameters scatter where moves are left out. Knows nothing of verdicts.
"""

from .repeated_phases import (
    JackknifeInterval as JackknifeInterval,
    LackOfFit as LackOfFit,
    jackknife_intervals as jackknife_intervals,
    lack_of_fit as lack_of_fit,
)
