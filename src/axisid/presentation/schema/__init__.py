"""The classes of everything that is written as JSON, and the schema that is made of them.

In: a file. Out: its document, typed; the JSON schema.
Knows nothing of results and how they are made.
"""

from .base import JsonObject as JsonObject
from .base import Matrix as Matrix
from .comparison import WrittenCandidate as WrittenCandidate
from .comparison import WrittenComparison as WrittenComparison
from .comparison import WrittenCriteria as WrittenCriteria
from .comparison import WrittenHeldOut as WrittenHeldOut
from .comparison import WrittenHeldOutBlocks as WrittenHeldOutBlocks
from .comparison import WrittenNestedTest as WrittenNestedTest
from .comparison import WrittenParameterCheck as WrittenParameterCheck
from .diagnosis import WrittenAlignment as WrittenAlignment
from .diagnosis import WrittenAttenuation as WrittenAttenuation
from .diagnosis import WrittenBand as WrittenBand
from .diagnosis import WrittenCheck as WrittenCheck
from .diagnosis import WrittenEndogeneity as WrittenEndogeneity
from .diagnosis import WrittenExcitation as WrittenExcitation
from .diagnosis import WrittenExplainedLaw as WrittenExplainedLaw
from .diagnosis import WrittenInstruments as WrittenInstruments
from .diagnosis import WrittenLackOfFit as WrittenLackOfFit
from .diagnosis import WrittenLawCheck as WrittenLawCheck
from .diagnosis import WrittenLawSearch as WrittenLawSearch
from .diagnosis import WrittenMotionComparison as WrittenMotionComparison
from .diagnosis import WrittenNoiseBias as WrittenNoiseBias
from .diagnosis import WrittenSetting as WrittenSetting
from .diagnosis import WrittenStrength as WrittenStrength
from .estimate import WrittenEstimate as WrittenEstimate
from .estimate import WrittenStream as WrittenStream
from .identification import WrittenApart as WrittenApart
from .identification import WrittenIdentification as WrittenIdentification
from .identification import WrittenMember as WrittenMember
from .identification import WrittenMethodValidation as WrittenMethodValidation
from .identification import WrittenSweep as WrittenSweep
from .identification import WrittenValidation as WrittenValidation
from .json_schema import results_schema as results_schema
from .output_fit import WrittenFitted as WrittenFitted
from .output_fit import WrittenOutputFit as WrittenOutputFit
from .output_fit import WrittenRecordError as WrittenRecordError
from .reading import plain as plain
from .reading import read_document as read_document
from .reading import schema_of as schema_of
from .record import WrittenDriveTime as WrittenDriveTime
from .record import WrittenOrigin as WrittenOrigin
from .record import WrittenPrefilter as WrittenPrefilter
from .record import WrittenRecord as WrittenRecord
from .record import WrittenRepair as WrittenRepair
from .record import WrittenRequest as WrittenRequest
from .record import WrittenResponse as WrittenResponse
from .record import WrittenSignal as WrittenSignal
from .record import WrittenStreamRecord as WrittenStreamRecord
from .residuals import WrittenAutocorrelation as WrittenAutocorrelation
from .residuals import WrittenCrossCorrelation as WrittenCrossCorrelation
from .residuals import WrittenLjungBox as WrittenLjungBox
from .residuals import WrittenNormality as WrittenNormality
from .residuals import WrittenResidualTests as WrittenResidualTests
from .residuals import WrittenRuns as WrittenRuns
from .result_comparison import WrittenAlone as WrittenAlone
from .result_comparison import WrittenDifference as WrittenDifference
from .result_comparison import WrittenResultComparison as WrittenResultComparison
from .values import WrittenDirectValue as WrittenDirectValue
from .values import WrittenDrawn as WrittenDrawn
from .values import WrittenKnown as WrittenKnown
from .values import WrittenPhysical as WrittenPhysical
from .values import WrittenValue as WrittenValue
