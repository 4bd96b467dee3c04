"""What outputs tell: which parameters they show, and how errors are coloured.

In: errors with their slopes. Out: `Unseen`, `Colour`, `Scattering`.
Knows nothing of how parameters are searched for.
"""

from .colour import Colour as Colour
from .colour import autoregression_of as autoregression_of
from .uneven import Scattering as Scattering
from .uneven import added as added
from .uneven import by_colour as by_colour
from .uneven import by_windows as by_windows
from .uneven import larger as larger
from .uneven import uneven as uneven
from .unseen import Unseen as Unseen
from .unseen import unseen_directions as unseen_directions
