"""What is predicted of records' outputs, for many parameter sets side by side, and its slopes.

In: axes, records, parameters. Out: `Lanes` of predicted less recorded outputs, and their slopes.
Knows nothing of how parameters are searched for.
"""

from .lanes import (
    PredictionErrors as PredictionErrors,
    jacobian_at as jacobian_at,
    record_rows as record_rows,
)
from .loop_predictions import LoopPredictions as LoopPredictions, measured_output as measured_output
from .window_predictions import (
    FEWEST_IN_WINDOW as FEWEST_IN_WINDOW,
    WindowPredictions as WindowPredictions,
    default_horizon as default_horizon,
)
