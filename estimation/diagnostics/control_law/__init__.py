"""The declared control law held against what the drive did.

In: an axis and a record. Out: `LawCheck`, with what would mend it.
Knows nothing of estimates, and of what the loop makes of the law.
"""

from .control_law import (
    EstimatedGains as EstimatedGains,
    LawCheck as LawCheck,
    check_found_law as check_found_law,
    check_law as check_law,
    first_failing as first_failing,
    law_check as law_check,
)
from .control_residuals import compared_as as compared_as
from .gain_sensitivities import LawByGains as LawByGains
