"""Nonlinear least squares: weighted residuals under a loss, within bounds.

In: predictions, unknowns, weights. Out: `SearchResult`.
Knows nothing of records, drives and standard errors.
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
