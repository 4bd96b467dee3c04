"""Columns of a log by name, with units as written in the log, and the provenance of a record.

In: names and arrays. Out: `Table`, `Provenance`.
Knows nothing of file formats, axes and roles.
"""

from .provenance import PeriodSource as PeriodSource, Provenance as Provenance, Repair as Repair
from .table import RawColumn as RawColumn, Samples as Samples, Table as Table, numbered as numbered
from .table_builder import TableBuilder as TableBuilder, twice as twice
from .unit_labels import (
    COUNTS as COUNTS,
    LABEL_WITH_UNIT as LABEL_WITH_UNIT,
    UNITS_ENTRY as UNITS_ENTRY,
    UnitQuantity as UnitQuantity,
    exact_unit as exact_unit,
    is_unit as is_unit,
    split_labels as split_labels,
)
