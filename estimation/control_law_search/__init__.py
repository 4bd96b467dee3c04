"""Search for the ready control law, its gains and delay, that explain a recorded control.

In: an axis and its record. Out: `LawSearch`.
Knows nothing of the axis's parameters.
"""

from .search import (
    ExplainedLaw as ExplainedLaw,
    LawSearch as LawSearch,
    find_law as find_law,
)
