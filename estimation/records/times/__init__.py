"""The times of a column: steps, gaps, drift, and the period behind them.

In: times. Out: steps, gaps and periods. Knows nothing of what was measured at them.
"""

from .own_period import own_period as own_period
from .time_steps import BACKWARD as BACKWARD
from .time_steps import RESAMPLE_EVENLY as RESAMPLE_EVENLY
from .time_steps import UNEVEN as UNEVEN
from .time_steps import advice_on_backward as advice_on_backward
from .time_steps import advice_on_uneven as advice_on_uneven
from .time_steps import count_by_period as count_by_period
from .time_steps import count_past_restarts as count_past_restarts
from .time_steps import drift_of as drift_of
from .time_steps import odd_steps as odd_steps
from .time_steps import open_end as open_end
from .time_steps import step_notes as step_notes
