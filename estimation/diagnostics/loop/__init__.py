"""The recorded loop held against the declared one: its columns and the delay of its force.

In: an axis and a record, an estimate. Out: measured findings, each with a `Check`.
Knows nothing of what other checks find.
"""

from .alignment import (
    Alignment as Alignment,
    ForceTiming as ForceTiming,
    alignment_check as alignment_check,
    alignment_of as alignment_of,
    declared_lateness as declared_lateness,
    estimate_delay as estimate_delay,
    force_timing as force_timing,
    law_in_time as law_in_time,
    timing_remedy as timing_remedy,
)
from .column_comparison import (
    ColumnComparison as ColumnComparison,
    compared_motion as compared_motion,
    force_check as force_check,
    limit_check as limit_check,
    motion_check as motion_check,
    scale_remedy as scale_remedy,
)
