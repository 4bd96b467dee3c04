"""Several estimates of the same parameters: what is usual among them, and what is not.

In: values with their covariances, as arrays. Out: centre and scatter, points that stand out, steps
and drifts.
Knows nothing of axes, logs and results.
"""

from .changes import Change as Change, Drift as Drift, Step as Step, change_in as change_in
from .robust_centre import (
    LARGEST as LARGEST,
    Alike as Alike,
    Usual as Usual,
    alike_points as alike_points,
    limit_of_a_new_point as limit_of_a_new_point,
    spread_of as spread_of,
)
