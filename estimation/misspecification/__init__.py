"""What a model lacks on a record: columns beside it, against twins that lack nothing.

In: an estimate and its record. Out: `Misspecification`, the name that explains most first, each
with its sentence. Knows nothing of verdicts.
"""

from .scores import RecordScores as RecordScores, scores_at as scores_at, scores_of as scores_of
from .search import (
    Misspecification as Misspecification,
    find_misspecification as find_misspecification,
    misspecification_text as misspecification_text,
)
from .terms import TERMS as TERMS, Along as Along, Term as Term
