"""What a check of a result is, and where checks are run.

In: a figure, what it is held against, what that means. Out: `Check`.
Knows nothing of what is checked.
"""

from .check import (
    DEFAULT_LEVELS as DEFAULT_LEVELS,
    KINDS as KINDS,
    Check as Check,
    Kind as Kind,
    Levels as Levels,
    Status as Status,
    first_case as first_case,
    joined as joined,
    kind_of as kind_of,
    lines_of as lines_of,
    made as made,
    status_of as status_of,
    told_or as told_or,
    unless_faulty as unless_faulty,
)
