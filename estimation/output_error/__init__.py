"""Output error: parameters whose simulated output follows the recorded one.

In: an axis, records, an output. Out: `OutputFit`. Knows nothing of filters except those of its
start, and nothing of its presentation.
"""

from .covariance import UnseenDirection as UnseenDirection
from .fit import fit as fit
from .fit_findings import (
    EndOfSearch as EndOfSearch,
    EndsOfSearches as EndsOfSearches,
    FitPrecision as FitPrecision,
    LawSensitivity as LawSensitivity,
    MovedByLaw as MovedByLaw,
    NoParameterAtBound as NoParameterAtBound,
    OpenLoopWindows as OpenLoopWindows,
    OtherCauseOfMissingTerms as OtherCauseOfMissingTerms,
    PriorAndRecord as PriorAndRecord,
    SamplesNearRests as SamplesNearRests,
    ShownParameters as ShownParameters,
    SimulatedOutput as SimulatedOutput,
)
from .fit_setup import checked_horizon as checked_horizon
from .inference import FittedParameters as FittedParameters
from .result import OutputFit as OutputFit, RecordError as RecordError
