"""Searches for parameters: what is searched, how errors count, and where bounds let it end.

In: predictions, unknowns, weights. Out: `SearchResult`.
Knows nothing of records, of drives and of how sure its end is.
"""

from .trust_region import (
    LOSSES as LOSSES,
    MOST_IN_ALL as MOST_IN_ALL,
    MOST_STEPS as MOST_STEPS,
    RESOLUTION as RESOLUTION,
    FitStep as FitStep,
    Search as Search,
    SearchResult as SearchResult,
    WeightedLoss as WeightedLoss,
    best_of as best_of,
    cost_of as cost_of,
)
