"""Misspecification of a model on a record: missing terms, faulty signals, systematic residuals.

In: an estimate and its record. Out: each `Misspecification` with its finding, the one that explains
most first; `LackOfFit` of the residual that repeats; `JackknifeInterval` of the possible effect of
the model error on a parameter. Knows nothing of verdicts.
"""

from .misspecification_findings import (
    CandidateTerm as CandidateTerm,
    ChangedParameter as ChangedParameter,
    LateSignal as LateSignal,
    MissingTerm as MissingTerm,
    OutlyingSample as OutlyingSample,
    ScaledSignal as ScaledSignal,
    ShareOfForce as ShareOfForce,
    misspecification_finding as misspecification_finding,
)
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
)
from .terms import TERMS as TERMS, Along as Along, Term as Term
