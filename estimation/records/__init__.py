"""Records: columns by role in SI, with one clock; repairs on request, which are counted.

In: `Table`, `Axis`. Out: `Record`. Knows nothing of filters.
"""

from .clocks import check_sample_period as check_sample_period
from .quantisation import (
    position_step as position_step,
    quantisation_step as quantisation_step,
    sensor_steps as sensor_steps,
)
from .reading import read_record as read_record
from .record import (
    OtherPeriod as OtherPeriod,
    Record as Record,
    check_record as check_record,
    is_same_period as is_same_period,
    law_clock as law_clock,
    record_labels as record_labels,
)
from .run_toml import (
    Repairs as Repairs,
    is_run_file as is_run_file,
    log_of as log_of,
    started_run as started_run,
)
from .segments import windows_text as windows_text
from .shifts_and_interpolation import (
    AdvisedShift as AdvisedShift,
    Interpolation as Interpolation,
    advised_interpolation as advised_interpolation,
    at_times as at_times,
    samples_apart as samples_apart,
    shift_into_time as shift_into_time,
)
from .wild_samples import wild_steps as wild_steps
