"""Estimates held against their data.

In: estimates and what they were made from. Out: measured findings, each with a `Check`.
Knows nothing of how it is shown.
"""

from .alignment import Alignment as Alignment
from .alignment import profile_alignment as profile_alignment
from .check import Check as Check
from .control_law import LawCheck as LawCheck
from .control_law import check_law as check_law
from .control_law import first_law as first_law
from .diagnose import DIAGNOSTICS as DIAGNOSTICS
from .diagnose import Diagnostic as Diagnostic
from .diagnose import by_weight as by_weight
from .diagnose import conclusion as conclusion
from .diagnose import diagnose as diagnose
from .diagnosis import Case as Case
from .diagnosis import Diagnosis as Diagnosis
from .diagnosis import RecordDiagnosis as RecordDiagnosis
from .diagnosis import preferred_method as preferred_method
from .excitation import Excitation as Excitation
from .filter_bias import filter_bias as filter_bias
from .instruments import NO_ENDOGENEITY as NO_ENDOGENEITY
from .instruments import Endogeneity as Endogeneity
from .instruments import InstrumentTests as InstrumentTests
from .instruments import Strength as Strength
from .instruments import biased_parameters as biased_parameters
from .instruments import endogeneity_of as endogeneity_of
from .instruments import instrument_tests as instrument_tests
from .motion import bounds_note as bounds_note
from .motion import within_bounds as within_bounds
from .records_alike import Alike as Alike
from .records_alike import Apart as Apart
from .records_alike import records_alike as records_alike
