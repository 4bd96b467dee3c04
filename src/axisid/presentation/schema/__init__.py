"""The classes of everything that is written as JSON, and the schema that is made of them.

In: a file. Out: its document, typed; the JSON schema.
Knows nothing of results and how they are made.
"""

from .base import JsonObject as JsonObject, Matrix as Matrix, about as about
from .comparison import (
    WrittenAlone as WrittenAlone,
    WrittenCandidate as WrittenCandidate,
    WrittenComparison as WrittenComparison,
    WrittenCriteria as WrittenCriteria,
    WrittenDifference as WrittenDifference,
    WrittenHeldOut as WrittenHeldOut,
    WrittenHeldOutBlocks as WrittenHeldOutBlocks,
    WrittenNestedTest as WrittenNestedTest,
    WrittenParameterCheck as WrittenParameterCheck,
    WrittenResultComparison as WrittenResultComparison,
)
from .diagnosis import (
    WrittenAlignment as WrittenAlignment,
    WrittenBand as WrittenBand,
    WrittenCheck as WrittenCheck,
    WrittenExcitation as WrittenExcitation,
    WrittenExplainedLaw as WrittenExplainedLaw,
    WrittenHausmanTest as WrittenHausmanTest,
    WrittenInstruments as WrittenInstruments,
    WrittenLackOfFit as WrittenLackOfFit,
    WrittenLawCheck as WrittenLawCheck,
    WrittenLawSearch as WrittenLawSearch,
    WrittenMotionComparison as WrittenMotionComparison,
    WrittenSetting as WrittenSetting,
    WrittenStrength as WrittenStrength,
)
from .estimate import WrittenEstimate as WrittenEstimate
from .identification import (
    WrittenApart as WrittenApart,
    WrittenIdentification as WrittenIdentification,
    WrittenMember as WrittenMember,
    WrittenMethodValidation as WrittenMethodValidation,
    WrittenSweep as WrittenSweep,
    WrittenValidation as WrittenValidation,
)
from .json_schema import results_schema as results_schema
from .monte_carlo import (
    WrittenCheckFigures as WrittenCheckFigures,
    WrittenEstimand as WrittenEstimand,
    WrittenFailedRun as WrittenFailedRun,
    WrittenMean as WrittenMean,
    WrittenMonteCarlo as WrittenMonteCarlo,
    WrittenShare as WrittenShare,
    WrittenTwins as WrittenTwins,
)
from .output_fit import (
    WrittenFitted as WrittenFitted,
    WrittenFitValidation as WrittenFitValidation,
    WrittenLack as WrittenLack,
    WrittenOutputFit as WrittenOutputFit,
    WrittenRecordError as WrittenRecordError,
)
from .reading import plain as plain, read_document as read_document, schema_of as schema_of
from .record import (
    WrittenDriveTime as WrittenDriveTime,
    WrittenPrefilter as WrittenPrefilter,
    WrittenRecord as WrittenRecord,
    WrittenRepair as WrittenRepair,
    WrittenRequest as WrittenRequest,
    WrittenResponse as WrittenResponse,
    WrittenSignal as WrittenSignal,
)
from .residuals import (
    WrittenAutocorrelation as WrittenAutocorrelation,
    WrittenCrossCorrelation as WrittenCrossCorrelation,
    WrittenNormality as WrittenNormality,
    WrittenResidualTests as WrittenResidualTests,
)
from .values import (
    WrittenDirectValue as WrittenDirectValue,
    WrittenDrawn as WrittenDrawn,
    WrittenHeld as WrittenHeld,
    WrittenKnown as WrittenKnown,
    WrittenLevels as WrittenLevels,
    WrittenPhysical as WrittenPhysical,
    WrittenValue as WrittenValue,
)
