"""Several estimates of the same parameters: what is usual among them, and what is not.

In: values with their covariances, as arrays. Out: centre and scatter, points that stand out, steps
and drifts.
Knows nothing of axes, logs and results.
"""

from .changes import Change as Change, Drift as Drift, Step as Step, change_in as change_in
from .robust_centre import (
    LARGEST as LARGEST,
    DetectedOutliers as DetectedOutliers,
    RandomEffects as RandomEffects,
    detect_outliers as detect_outliers,
    prediction_limit as prediction_limit,
    spread_of as spread_of,
)
