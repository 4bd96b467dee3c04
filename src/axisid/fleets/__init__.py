"""Identification of many logs: a table, outliers, and changes of parameters over time.

In: logs, a manifest, an executor; files of results. Out: a result for each log, a fleet with its
outliers; series with their limits, steps and drifts, as text, a page, a table. Knows nothing of the
command line, and of how a log is identified.
"""

from .fleet import fleet as fleet, written_files as written_files
from .items import FleetItem as FleetItem, gather_items as gather_items
from .ledger import (
    LEDGER as LEDGER,
    FleetRow as FleetRow,
    Ledger as Ledger,
    read_ledger as read_ledger,
)
from .result import Fleet as Fleet
from .trend import Trend as Trend, trend as trend
