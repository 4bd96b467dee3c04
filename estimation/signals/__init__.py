"""Filtered motion and force of records.

In: `Record`, `Prefilter`. Out: `FilteredRecord` with its `Signals`, rows and selected samples.
Knows nothing of estimation methods.
"""

from .drive_response import (
    DriveReplay as DriveReplay,
    acting_control as acting_control,
    as_logged as as_logged,
    commands_as_logged as commands_as_logged,
    control_delay_in_log as control_delay_in_log,
    hides_command as hides_command,
    lagged_force as lagged_force,
    limit_in_log as limit_in_log,
    through_path as through_path,
)
from .filtered_record import FilteredRecord as FilteredRecord, show_too_little as show_too_little
from .information import (
    columns_by_signal as columns_by_signal,
    has_nonlinear_speed_friction as has_nonlinear_speed_friction,
    is_speed_friction as is_speed_friction,
    remaining_information as remaining_information,
)
from .motion import (
    RestingAxis as RestingAxis,
    motion_lacks as motion_lacks,
    one_direction as one_direction,
    one_speed as one_speed,
    resting_axis as resting_axis,
)
from .prefilter import (
    Prefilter as Prefilter,
    SampledFilter as SampledFilter,
    Span as Span,
    matching_decimation as matching_decimation,
)
from .sample_selection import RowTimes as RowTimes, Sampling as Sampling
from .signals import (
    Motion as Motion,
    Signals as Signals,
    drive_force as drive_force,
    hold_mean as hold_mean,
    recorded_signals as recorded_signals,
)
