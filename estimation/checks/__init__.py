"""What a check of a result is, and where checks are run.

In: a figure, what it is held against, what that means. Out: `Check`.
Knows nothing of what is checked.
"""

from .check import Check as Check
from .check import Status as Status
from .check import passed as passed
from .faults import told_or as told_or
from .faults import unless_faulty as unless_faulty
from .lines import LINES as LINES
from .lines import line_of as line_of
from .lines import lines_of as lines_of
