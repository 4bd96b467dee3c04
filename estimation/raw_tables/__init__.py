"""Columns by name, with units as written, and where they come from.

In: names and arrays. Out: `Table`, `Provenance`.
Knows nothing of file formats, axes and roles.
"""

from .table import (
    PeriodSource as PeriodSource,
    Provenance as Provenance,
    RawColumn as RawColumn,
    Repair as Repair,
    Samples as Samples,
    Table as Table,
    TableBuilder as TableBuilder,
    library as library,
    npz_bytes as npz_bytes,
    numbered as numbered,
    one_line as one_line,
    parquet_bytes as parquet_bytes,
    refusing as refusing,
)
from .unit_labels import (
    COUNTS as COUNTS,
    LABEL_WITH_UNIT as LABEL_WITH_UNIT,
    UNITS_ENTRY as UNITS_ENTRY,
    UnitQuantity as UnitQuantity,
    exact_unit as exact_unit,
    is_unit as is_unit,
    split_labels as split_labels,
)
