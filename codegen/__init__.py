"""From symbolic models to functions: lower, print, build, store.

`Axis` -> `AxisModel` -> programs -> text -> `GeneratedAxis`. The text is what `generated/` holds,
and the same text is what runs.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
