"""Reading of delimited text of any dialect.

In: the bytes of a file. Out: `Table`. Knows nothing of axes and roles.
"""

from .dialect import is_number as is_number
from .reader import read_text as read_text
from .time_stamps import (
    TimeStampError as TimeStampError,
    is_stamp as is_stamp,
    stamp_seconds as stamp_seconds,
)
