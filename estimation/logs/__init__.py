"""Logs of every format.

In: a file, a dataframe. Out: `Table`. Knows nothing of axes and roles.
"""

from .file_kinds import check_kind as check_kind
from .file_kinds import check_regular as check_regular
from .formats import format_of as format_of
from .formats import log_endings as log_endings
from .formats import streamed_formats as streamed_formats
from .packings import packing_of as packing_of
from .packings import unpacking as unpacking
from .reading import read_table as read_table
