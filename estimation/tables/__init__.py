"""Columns by name, with units as written, and where they come from.

In: names and arrays. Out: `Table`, `Provenance`.
Knows nothing of file formats, axes and roles.
"""

from .provenance import LogClock as LogClock
from .provenance import Provenance as Provenance
from .provenance import Repair as Repair
from .table import Column as Column
from .table import Samples as Samples
from .table import Table as Table
from .table import TableBuilder as TableBuilder
from .table import library as library
from .table import loaded_column as loaded_column
from .table import numbered as numbered
from .table import one_line as one_line
from .table import parquet_bytes as parquet_bytes
from .unit_labels import COUNTS as COUNTS
from .unit_labels import LABEL_WITH_UNIT as LABEL_WITH_UNIT
from .unit_labels import UNITS_ENTRY as UNITS_ENTRY
from .unit_labels import exact_unit as exact_unit
from .unit_labels import is_unit as is_unit
from .unit_labels import label_unit as label_unit
from .unit_labels import split_labels as split_labels
