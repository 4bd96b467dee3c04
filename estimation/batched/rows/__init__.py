"""Lanes behind one filter: their rows, their loops, and what solves them.

In: records of one reference as lanes. Out: `Block`, whose rows are (n, columns, L), and solutions.
Knows nothing of iterations and covariances.
"""

from .block import Block as Block
from .block import Chosen as Chosen
from .block import LaneRows as LaneRows
from .columns import measured_columns as measured_columns
from .lanes import ALONE as ALONE
from .lanes import FAILED as FAILED
from .lanes import SIDE_BY_SIDE as SIDE_BY_SIDE
from .lanes import LaneEstimates as LaneEstimates
from .lanes import RecordLanes as RecordLanes
from .loops import simulated_lanes as simulated_lanes
from .regression import LaneSolutions as LaneSolutions
from .regression import combined as combined
from .regression import fitted as fitted
from .regression import inverse_products as inverse_products
from .regression import lagged_products as lagged_products
from .regression import products as products
from .regression import row_counts as row_counts
from .regression import solved as solved
from .workspace import of_lanes as of_lanes
from .workspace import put_lanes as put_lanes
from .workspace import some_lanes as some_lanes
from .workspace import space as space
