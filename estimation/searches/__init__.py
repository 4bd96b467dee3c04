"""Searches for parameters: what is searched, how errors count, and where bounds let it end.

In: predictions, unknowns, weights. Out: `Found`.
Knows nothing of records, of drives and of how sure its end is.
"""

from .search import LOSSES as LOSSES
from .search import MOST_STEPS as MOST_STEPS
from .search import Elsewhere as Elsewhere
from .search import FitStep as FitStep
from .search import Found as Found
from .search import Search as Search
from .search import Weighing as Weighing
from .search import best_of as best_of
from .search import cost_of as cost_of
from .search import deviation_by_median as deviation_by_median
from .search import passed_as_low as passed_as_low
