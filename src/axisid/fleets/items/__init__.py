"""Logs by name, pattern, folder and manifest, before they are read.

In: what names logs. Out: an item for each. Knows nothing of axes and results.
"""

from .gathering import gather_items as gather_items
from .item import FleetItem as FleetItem, result_names as result_names
