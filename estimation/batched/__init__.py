"""Many records of one motion, identified side by side.

In: an axis, and records of one reference as lanes. Out: estimates, deviations and biases by lane,
as `identify` has them. Knows nothing of diagnoses and documents.
"""

from .identify_lanes import identify_lanes as identify_lanes, is_served as is_served
from .lanes import LaneEstimates as LaneEstimates, RecordLanes as RecordLanes
