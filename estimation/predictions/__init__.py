"""What is predicted of records' outputs, for many parameter sets side by side, and its slopes.

In: axes, records, parameters. Out: `Lanes` of predicted less recorded outputs; `Slopes`.
Knows nothing of how parameters are searched for.
"""

from .free_time import TimedPredictions as TimedPredictions
from .lanes import Predictions as Predictions
from .lanes import record_rows as record_rows
from .lanes import whole_lanes as whole_lanes
from .loop_predictions import LoopPredictions as LoopPredictions
from .measured_output import measured_output as measured_output
from .slopes import Slopes as Slopes
from .slopes import slopes_of as slopes_of
from .window_predictions import FEWEST_IN_WINDOW as FEWEST_IN_WINDOW
from .window_predictions import WindowPredictions as WindowPredictions
from .window_predictions import default_horizon as default_horizon
