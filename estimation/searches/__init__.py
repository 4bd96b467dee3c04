"""Searches for parameters: what is searched, how errors count, and where bounds let it end.

In: predictions, unknowns, weights. Out: `Found`.
Knows nothing of records, of drives and of how sure its end is.
"""

from .search import (
    LOSSES as LOSSES,
    MOST_STEPS as MOST_STEPS,
    Elsewhere as Elsewhere,
    FitStep as FitStep,
    Found as Found,
    Search as Search,
    Weighing as Weighing,
    best_of as best_of,
    cost_of as cost_of,
    deviation_by_median as deviation_by_median,
    passed_as_low as passed_as_low,
)
