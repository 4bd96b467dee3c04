"""axisid: from the equation of motion of a one-degree-of-freedom axis to trustworthy parameters.

Declare an axis with `newton` or `lagrange` (or take one of the library with `load_axis`), read a
record, choose a `Prefilter`, `identify`. Friction and loads are in `axisid.elements`, control laws
in `axisid.control`. The types that results contain are in `axisid.modeling`, `axisid.codegen` and
`axisid.estimation`. Names are imported when they are first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
