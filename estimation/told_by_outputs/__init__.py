"""What outputs tell: which parameters they show, and how errors are coloured.

In: errors with their slopes. Out: `Unseen`, `Autoregression`, `Scattering`.
Knows nothing of how parameters are searched for.
"""

from .colour import Autoregression as Autoregression, autoregression_of as autoregression_of
from .scattering import (
    Scattering as Scattering,
    added as added,
    by_colour as by_colour,
    by_windows as by_windows,
    larger as larger,
)
from .unseen import Unseen as Unseen, unseen_directions as unseen_directions
