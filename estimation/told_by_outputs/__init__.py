"""What outputs tell: which parameters they show, and how errors are coloured.

In: errors with their slopes. Out: `Unseen`, `Autoregression`, `Scattering`.
Knows nothing of how parameters are searched for.
"""

from .colour import (
    Autoregression as Autoregression,
    Scattering as Scattering,
    Unseen as Unseen,
    added as added,
    autoregression_of as autoregression_of,
    by_colour as by_colour,
    by_windows as by_windows,
    larger as larger,
    unseen_directions as unseen_directions,
)
