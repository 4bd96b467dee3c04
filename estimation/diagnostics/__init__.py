"""Every diagnostic of a result, in the order of the verdict.

In: estimates and the problem that they were made from. Out: `Diagnosis` with all measurements.
Knows nothing of how it is shown.
"""

from .agreement_findings import (
    AgreementOfEstimates as AgreementOfEstimates,
    DirectAgainstInverse as DirectAgainstInverse,
    EstimateComparison as EstimateComparison,
    InstrumentsAgainstOutputError as InstrumentsAgainstOutputError,
    LeastSquaresAgainstInstruments as LeastSquaresAgainstInstruments,
    NoiseBias as NoiseBias,
    ParameterBias as ParameterBias,
    ParameterDifference as ParameterDifference,
    QuantisationBias as QuantisationBias,
    WeakestInstrument as WeakestInstrument,
)
from .agreement_of_estimates import (
    DDM_LESS_IDM as DDM_LESS_IDM,
    SECOND_OPINION as SECOND_OPINION,
    InstrumentStrength as InstrumentStrength,
    InstrumentTests as InstrumentTests,
    forms_check as forms_check,
    method_check as method_check,
)
from .alignment import (
    Alignment as Alignment,
    estimate_delay as estimate_delay,
)
from .alignment_findings import (
    DeclaredTooLong as DeclaredTooLong,
    DelayBeyondRange as DelayBeyondRange,
    ForceDelay as ForceDelay,
    LoggedAtOtherTime as LoggedAtOtherTime,
    OtherHold as OtherHold,
    UndeclaredDelay as UndeclaredDelay,
)
from .all_diagnostics import (
    DIAGNOSTICS as DIAGNOSTICS,
    Diagnosis as Diagnosis,
    Diagnostic as Diagnostic,
    RecordDiagnosis as RecordDiagnosis,
    diagnose as diagnose,
)
from .column_comparison import (
    ColumnComparison as ColumnComparison,
    compared_motion as compared_motion,
    derivative_check as derivative_check,
)
from .column_findings import (
    ColumnCorrections as ColumnCorrections,
    ControlAgainstLimit as ControlAgainstLimit,
    ForceAgainstControl as ForceAgainstControl,
    MeasuredMotion as MeasuredMotion,
)
from .diagnostic_inputs import DiagnosticInputs as DiagnosticInputs
from .hausman import HausmanTest as HausmanTest
from .model_error_checks import (
    LoopNotSimulated as LoopNotSimulated,
    MissingTerms as MissingTerms,
    MovedParameter as MovedParameter,
    Outliers as Outliers,
    RecordedSignals as RecordedSignals,
    ResidualAtRepeats as ResidualAtRepeats,
    SimulatedLoop as SimulatedLoop,
    misspecification_check as misspecification_check,
    moved_parameters_check as moved_parameters_check,
)
from .overlapping_records import (
    CommonSamples as CommonSamples,
    RepeatedSamples as RepeatedSamples,
    common_samples as common_samples,
    repeated_check as repeated_check,
)
from .parameter_checks import (
    NOMINAL_VALUES as NOMINAL_VALUES,
    Excitation as Excitation,
    at_bound_check as at_bound_check,
    fixed_check as fixed_check,
    gain_check as gain_check,
    nominal_check as nominal_check,
    precision_check as precision_check,
    rows_check as rows_check,
    within_bounds as within_bounds,
)
from .parameter_findings import (
    BeyondBounds as BeyondBounds,
    FarFromNominalValues as FarFromNominalValues,
    FewRows as FewRows,
    FixedAtBounds as FixedAtBounds,
    FixedValue as FixedValue,
    FixedValues as FixedValues,
    IdentifiedGain as IdentifiedGain,
    OutsideBounds as OutsideBounds,
    Precision as Precision,
    RelativeError as RelativeError,
    Unidentified as Unidentified,
    WithinBounds as WithinBounds,
    finite as finite,
    relative_error as relative_error,
)
from .pooling import (
    PoolingTest as PoolingTest,
    RecordDifference as RecordDifference,
    RecordRegressor as RecordRegressor,
    covariance_of_twins as covariance_of_twins,
    difference_of as difference_of,
    pooling_check as pooling_check,
    pooling_test as pooling_test,
    pooling_test_of as pooling_test_of,
)
from .pooling_findings import (
    ComparedRecords as ComparedRecords,
    DifferingParameter as DifferingParameter,
    OddRecord as OddRecord,
    UnidentifiedInRecord as UnidentifiedInRecord,
)
from .scale_of_control import (
    ControlScaleMoves as ControlScaleMoves,
)
from .sudden_steps import (
    SUDDEN_STEPS as SUDDEN_STEPS,
    SuddenSteps as SuddenSteps,
    sudden_steps_check as sudden_steps_check,
)
