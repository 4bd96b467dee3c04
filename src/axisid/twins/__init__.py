"""Logs of twins: of one machine, or of many whose true values scatter and drift.

In: an axis, what its twins are. Out: logs that are read back as they are, a manifest with
the truth. Knows nothing of how a log is identified, and of the command line.
"""

from .twin_machines import (
    TwinMachines as TwinMachines,
    twin_files as twin_files,
    write_twin as write_twin,
    write_twins as write_twins,
)
