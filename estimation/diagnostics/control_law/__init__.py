"""Comparison of the declared control law with the recorded control.

In: an axis and a record. Out: `LawAgreement`, with the change that would make the law fit.
Knows nothing of estimates, nor of the simulated loop.
"""

from .control_residuals import (
    CONSTANT as CONSTANT,
    DRIFT as DRIFT,
    comparison_filter as comparison_filter,
)
from .gain_regression import (
    GAINS as GAINS,
    SCALE as SCALE,
    Explanation as Explanation,
    GainRegression as GainRegression,
)
from .law_agreement import (
    EstimatedGains as EstimatedGains,
    LawAgreement as LawAgreement,
    first_failing as first_failing,
    found_law_agreement as found_law_agreement,
    law_agreement as law_agreement,
    law_check as law_check,
)
from .law_findings import (
    ConstantOrDrift as ConstantOrDrift,
    ControlDiffers as ControlDiffers,
    ControlScale as ControlScale,
    ExchangedColumns as ExchangedColumns,
    FoundByReading as FoundByReading,
    FoundGainsAgree as FoundGainsAgree,
    FoundGainsDiffer as FoundGainsDiffer,
    LateControl as LateControl,
    LawOfSecondRecord as LawOfSecondRecord,
    LawRepair as LawRepair,
    LawReproduced as LawReproduced,
    MovedColumn as MovedColumn,
    MovedZero as MovedZero,
    OtherGain as OtherGain,
    OtherGains as OtherGains,
    OtherInjectedSize as OtherInjectedSize,
    OtherScale as OtherScale,
    OtherTestSignal as OtherTestSignal,
    OtherVelocity as OtherVelocity,
    ReferenceClock as ReferenceClock,
    RepairedLaw as RepairedLaw,
    ScaledColumn as ScaledColumn,
    UndeclaredLimit as UndeclaredLimit,
    UnexplainedControl as UnexplainedControl,
)
from .noise_gain import (
    NOISE_GAIN as NOISE_GAIN,
    NoiseGain as NoiseGain,
    noise_gain_check as noise_gain_check,
)
from .record_laws import RecordLaws as RecordLaws
