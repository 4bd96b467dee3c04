"""The classes of everything that is written as JSON, and the schema that is made of them.

In: a file. Out: its document, typed; the JSON schema.
Knows nothing of results and how they are made.
"""

from .diagnosis import (
    WrittenAlignment as WrittenAlignment,
    WrittenExcitation as WrittenExcitation,
    WrittenExplainedLaw as WrittenExplainedLaw,
    WrittenLawCheck as WrittenLawCheck,
    WrittenLawSearch as WrittenLawSearch,
)
from .estimate import (
    WrittenEstimate as WrittenEstimate,
)
from .identification import (
    WrittenApart as WrittenApart,
    WrittenIdentification as WrittenIdentification,
    WrittenMember as WrittenMember,
    WrittenMethodValidation as WrittenMethodValidation,
    WrittenSweep as WrittenSweep,
    WrittenValidation as WrittenValidation,
)
from .reading import (
    plain as plain,
    read_document as read_document,
    results_schema as results_schema,
    schema_of as schema_of,
)
from .record import (
    WrittenDriveTime as WrittenDriveTime,
    WrittenPrefilter as WrittenPrefilter,
    WrittenRecord as WrittenRecord,
    WrittenRequest as WrittenRequest,
    WrittenResponse as WrittenResponse,
    WrittenSignal as WrittenSignal,
)
from .studies import (
    ResultComparison as ResultComparison,
    WrittenAlone as WrittenAlone,
    WrittenCandidate as WrittenCandidate,
    WrittenComparison as WrittenComparison,
    WrittenDifference as WrittenDifference,
    WrittenFitted as WrittenFitted,
    WrittenFitValidation as WrittenFitValidation,
    WrittenHeldOut as WrittenHeldOut,
    WrittenHeldOutBlocks as WrittenHeldOutBlocks,
    WrittenLack as WrittenLack,
    WrittenMonteCarlo as WrittenMonteCarlo,
    WrittenOutputFit as WrittenOutputFit,
    WrittenRecordError as WrittenRecordError,
    WrittenTwins as WrittenTwins,
)
from .values import (
    JsonObject as JsonObject,
    Matrix as Matrix,
    WrittenDirectValue as WrittenDirectValue,
    WrittenHeld as WrittenHeld,
    WrittenKnown as WrittenKnown,
    WrittenPhysical as WrittenPhysical,
    WrittenValue as WrittenValue,
    about as about,
)
