"""Logs of every format.

In: a file, a dataframe. Out: `Table`. Knows nothing of axes and roles.
"""

from .formats import log_endings as log_endings, read_table as read_table
