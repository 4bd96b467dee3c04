"""The moves of a record: which repeat, and what an estimate owes to each.

In: an estimate and the record behind its filter. Out: its residuals split into noise and what the
model lacks, and how far parameters scatter where moves are left out. Knows nothing of verdicts.
"""

from .lack_of_fit import (
    Band as Band,
    LackOfFit as LackOfFit,
    lack_of_fit as lack_of_fit,
    model_bands as model_bands,
)
