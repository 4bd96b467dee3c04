"""What a check of a result is, and where checks are run.

In: a figure, what it is held against, what that means. Out: `Check`.
Knows nothing of what is checked.
"""

from .check import Check as Check
from .check import Status as Status
from .check import made as made
from .check import passed as passed
from .faults import told_or as told_or
from .faults import unless_faulty as unless_faulty
from .kinds import KINDS as KINDS
from .kinds import Kind as Kind
from .kinds import kind_of as kind_of
from .kinds import lines_of as lines_of
from .levels import DEFAULT_LEVELS as DEFAULT_LEVELS
from .levels import Levels as Levels
