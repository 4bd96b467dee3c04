"""Many logs through one axis or several: a result for each, a table, the axes that stand out.

In: logs, a manifest, an executor. Out: files of results, a fleet with its outliers. Knows nothing
of the command line, and of how a log is identified.
"""

from .fleet import fleet as fleet, written_files as written_files
from .items import FleetItem as FleetItem, gather_items as gather_items
from .ledger import (
    LEDGER as LEDGER,
    FleetRow as FleetRow,
    FleetValue as FleetValue,
    fleet_value as fleet_value,
    read_ledger as read_ledger,
    strays as strays,
)
from .result import Fleet as Fleet
