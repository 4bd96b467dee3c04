"""Records: roles, SI units, one clock, repairs on request, each counted.

In: `Table`, `Axis`. Out: `Record`. Knows nothing of filters.
"""

from .between import Between as Between
from .between import advised_between as advised_between
from .between import at_times as at_times
from .between import samples_apart as samples_apart
from .clipping import quantum_of as quantum_of
from .reading import read_record as read_record
from .record import Record as Record
from .record import check_record as check_record
from .record import in_own_order as in_own_order
from .record import record_labels as record_labels
from .repairs import Repairs as Repairs
from .shifts import advised_shift as advised_shift
from .time_base import clock_of as clock_of
from .time_base import hold_delay as hold_delay
from .time_base import is_same_period as is_same_period
from .time_base import is_sampled_by as is_sampled_by
from .time_base import law_ratio as law_ratio
from .time_base import other_period as other_period
