"""Every diagnostic of a result, in the order of the verdict.

In: estimates and what they were made from. Out: `Diagnosis` with what rooms below it measured.
Knows nothing of how it is shown.
"""

from .diagnose import (
    DIAGNOSTICS as DIAGNOSTICS,
    Belief as Belief,
    Checked as Checked,
    Diagnosed as Diagnosed,
    Diagnostic as Diagnostic,
    belief as belief,
    by_weight as by_weight,
    conclusion as conclusion,
    diagnose as diagnose,
    gravest_first as gravest_first,
)
from .diagnosis import (
    Case as Case,
    Diagnosis as Diagnosis,
    RecordDiagnosis as RecordDiagnosis,
)
from .misfit_checks import lacks_check as lacks_check
from .records_alike import (
    Alike as Alike,
    Difference as Difference,
    RecordDifference as RecordDifference,
    RecordRegressor as RecordRegressor,
    alike_check as alike_check,
    covariance_of_twins as covariance_of_twins,
    overlaps as overlaps,
    records_alike as records_alike,
    repeated_check as repeated_check,
    rows_alike as rows_alike,
)
