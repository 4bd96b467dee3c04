"""What a model lacks on a record, by name, and how much it leaves beside noise, whatever its name.

In: an estimate and its record. Out: `Misspecification`, the name that explains most first, each
with its sentence; `LackOfFit` of what repeats; `JackknifeInterval` of how far the model's error may
move a parameter. Knows nothing of verdicts.
"""

from .model_error import (
    JackknifeInterval as JackknifeInterval,
    LackOfFit as LackOfFit,
    groupings as groupings,
    jackknife_intervals as jackknife_intervals,
    lack_of_fit as lack_of_fit,
)
from .scores import RecordScores as RecordScores, scores_at as scores_at, scores_of as scores_of
from .search import (
    Misspecification as Misspecification,
    find_misspecification as find_misspecification,
    misspecification_text as misspecification_text,
)
from .terms import TERMS as TERMS, Along as Along, Term as Term
