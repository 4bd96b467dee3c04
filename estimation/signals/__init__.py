"""Motion and force under a filter.

In: `Record`, `Prefilter`. Out: `FilteredRecord`: `Signals`, rows, and which samples count.
Knows nothing of methods.
"""

from .drive_response import (
    DriveAlong as DriveAlong,
    acting_along as acting_along,
    acting_control as acting_control,
    through_path as through_path,
)
from .filtered_record import FilteredRecord as FilteredRecord, show_too_little as show_too_little
from .motion import (
    motion_lacks as motion_lacks,
    one_direction as one_direction,
    one_speed as one_speed,
    rests_first as rests_first,
)
from .neighbours import Neighbours as Neighbours
from .prefilter import Prefilter as Prefilter, matching_decimation as matching_decimation
from .recorded import recorded_signals as recorded_signals
from .sampled_filter import (
    DECIMATION_PADDING as DECIMATION_PADDING,
    SampledFilter as SampledFilter,
    Span as Span,
)
from .sampling import Sampling as Sampling
from .signals import (
    Motion as Motion,
    Signals as Signals,
    about_samples as about_samples,
    drive_force as drive_force,
)
from .without_turns import (
    dependence as dependence,
    losses_count as losses_count,
    of_signals as of_signals,
    remaining_information as remaining_information,
    searches_friction as searches_friction,
)
