"""Motion and force under a filter.

In: `Record`, `Prefilter`. Out: `FilteredRecord`: `Signals`, rows, and which samples count.
Knows nothing of methods.
"""

from .drive_response import DriveAlong as DriveAlong
from .drive_response import acting_along as acting_along
from .drive_response import acting_control as acting_control
from .drive_response import through_path as through_path
from .filtered_record import FilteredRecord as FilteredRecord
from .filtered_record import show_too_little as show_too_little
from .motion import motion_lacks as motion_lacks
from .motion import one_direction as one_direction
from .motion import one_speed as one_speed
from .motion import rests_first as rests_first
from .neighbours import Neighbours as Neighbours
from .prefilter import Prefilter as Prefilter
from .prefilter import matching_decimation as matching_decimation
from .recorded import recorded_signals as recorded_signals
from .sampled_filter import DECIMATION_PADDING as DECIMATION_PADDING
from .sampled_filter import SampledFilter as SampledFilter
from .sampled_filter import Span as Span
from .sampling import Sampling as Sampling
from .signals import Signals as Signals
from .signals import about_samples as about_samples
from .signals import drive_force as drive_force
from .without_turns import Information as Information
from .without_turns import dependence as dependence
from .without_turns import losses_count as losses_count
from .without_turns import of_signals as of_signals
from .without_turns import searches_friction as searches_friction
