"""Logs by name, pattern, folder and manifest, before they are read.

In: what names logs. Out: an item for each. Knows nothing of axes and results.
"""

from .gathering import (
    FleetItem as FleetItem,
    gather_items as gather_items,
    result_names as result_names,
)
