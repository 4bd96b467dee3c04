"""Batched identification of many records of one reference.

In: an axis, and records of one reference as lanes. Out: estimates and standard errors by lane, as
from `identify`. Knows nothing of diagnoses and documents.
"""

from .identify_lanes import identify_lanes as identify_lanes, is_served as is_served
from .lanes import LaneEstimates as LaneEstimates, RecordLanes as RecordLanes
