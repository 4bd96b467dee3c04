"""Which of the ready laws gives a recorded control, and with which gains and delay.

In: an axis and its record. Out: `LawSearch`.
Knows nothing of the axis's parameters.
"""

from .search import (
    ExplainedLaw as ExplainedLaw,
    LawSearch as LawSearch,
    find_law as find_law,
)
