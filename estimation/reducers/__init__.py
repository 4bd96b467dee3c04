"""What is kept of many simulations in place of their signals.

In: the signals of some lanes. Out: numbers of each.
Knows nothing of simulations and axes.
"""

from .lane_block import LaneBlock as LaneBlock
from .lane_block import Reducer as Reducer
from .reducers import check_wanted as check_wanted
from .reducers import checked_reducers as checked_reducers
from .reducers import joined as joined
from .reducers import needed_signals as needed_signals
from .reducers import reduced as reduced
