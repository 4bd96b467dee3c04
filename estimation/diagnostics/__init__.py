"""Every diagnostic of a result, in the order of the verdict.

In: estimates and what they were made from. Out: `Diagnosis` with what rooms below it measured.
Knows nothing of how it is shown.
"""

from .diagnose import DIAGNOSTICS as DIAGNOSTICS
from .diagnose import Belief as Belief
from .diagnose import Checked as Checked
from .diagnose import Diagnosed as Diagnosed
from .diagnose import Diagnostic as Diagnostic
from .diagnose import alignment_in as alignment_in
from .diagnose import belief as belief
from .diagnose import by_weight as by_weight
from .diagnose import conclusion as conclusion
from .diagnose import diagnose as diagnose
from .diagnose import gravest_first as gravest_first
from .diagnosis import Case as Case
from .diagnosis import Diagnosis as Diagnosis
from .diagnosis import RecordDiagnosis as RecordDiagnosis
from .joined import joined as joined
from .preferred import Choice as Choice
from .records_alike import Alike as Alike
from .records_alike import Apart as Apart
from .records_alike import OwnColumns as OwnColumns
from .records_alike import alike_check as alike_check
from .records_alike import records_alike as records_alike
from .records_alike import rows_alike as rows_alike
from .repeated_samples import overlaps as overlaps
from .repeated_samples import repeated_check as repeated_check
