"""Several estimates of the same parameters: what is usual among them, and what is not.

In: values with their covariances, as arrays. Out: centre and scatter, points that stand out, steps
and drifts.
Knows nothing of axes, logs and results.
"""

from .alike import LARGEST as LARGEST
from .alike import Alike as Alike
from .alike import Usual as Usual
from .alike import alike_points as alike_points
from .alike import limit_of_a_new_point as limit_of_a_new_point
from .changes import Change as Change
from .changes import Drift as Drift
from .changes import change_in as change_in
from .robust_scatter import spread_of as spread_of
from .steps import Step as Step
