"""Delimited text, its dialect guessed.

In: the bytes of a file. Out: `Table`. Knows nothing of axes and roles.
"""

from .reader import NoTextError as NoTextError
from .reader import cut_end_notes as cut_end_notes
from .reader import encoding_of as encoding_of
from .reader import read_text as read_text
from .reader import text_blocks as text_blocks
from .time_stamps import NoStampsError as NoStampsError
from .time_stamps import StampHistory as StampHistory
from .time_stamps import is_stamp as is_stamp
from .time_stamps import stamp_seconds as stamp_seconds
