"""Motion and force under a filter.

In: `Record`, `Prefilter`. Out: `FilteredRecord`: `Signals`, rows, and which samples count.
Knows nothing of methods.
"""

from .drive_response import (
    DriveAlong as DriveAlong,
    acting_control as acting_control,
    as_logged as as_logged,
    commands_as_logged as commands_as_logged,
    hides_command as hides_command,
    lagged_force as lagged_force,
    late_in_log as late_in_log,
    limit_in_log as limit_in_log,
    through_path as through_path,
)
from .filtered_record import FilteredRecord as FilteredRecord, show_too_little as show_too_little
from .prefilter import (
    Prefilter as Prefilter,
    SampledFilter as SampledFilter,
    Span as Span,
    matching_decimation as matching_decimation,
)
from .sampling import RowTimes as RowTimes, Sampling as Sampling
from .signals import (
    Motion as Motion,
    Signals as Signals,
    dependence as dependence,
    drive_force as drive_force,
    hold_mean as hold_mean,
    motion_lacks as motion_lacks,
    one_direction as one_direction,
    one_speed as one_speed,
    recorded_signals as recorded_signals,
    remaining_information as remaining_information,
    rests_first as rests_first,
    searches_friction as searches_friction,
    takes_robust_loss as takes_robust_loss,
)
