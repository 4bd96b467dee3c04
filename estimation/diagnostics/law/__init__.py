"""The declared control law held against what the drive did.

In: an axis and a record. Out: `LawCheck`, with what would mend it.
Knows nothing of estimates, and of what the loop makes of the law.
"""

from .by_runs import GainsBeside as GainsBeside
from .control_law import LawCheck as LawCheck
from .control_law import check_law as check_law
from .control_law import first_failing as first_failing
from .control_law import first_law as first_law
from .control_law import law_check as law_check
from .found_gains import FoundGains as FoundGains
from .found_gains import check_found_law as check_found_law
from .terms import compared_as as compared_as
