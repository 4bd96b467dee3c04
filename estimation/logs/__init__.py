"""Logs of every format.

In: a file, a dataframe. Out: `Table`. Knows nothing of axes and roles.
"""

from .columnar import parquet_blocks as parquet_blocks
from .file_kinds import check_kind as check_kind
from .file_kinds import check_regular as check_regular
from .formats import read_table as read_table
