"""Arrays that one block after the other is worked out in.

The system gives memory page by page as it is first written to, which takes as long as what is
written. So what a thread had for one block serves for its next.
"""

from threading import local

import numpy as np

from axisid.support.arrays import Array

_KEPT = local()


def space(name: str, *shape: int) -> Array:
    """An array of a name, with whatever is in it; that of the name before is of no use any more."""
    size = int(np.prod(shape))
    kept: dict[str, Array] = vars(_KEPT).setdefault("arrays", {})
    if name not in kept or kept[name].size < size:
        kept[name] = np.empty(size)
    return kept[name][:size].reshape(shape)


def spaces(name: str, count: int, *shape: int) -> tuple[Array, ...]:
    """Several arrays of one shape."""
    return tuple(space(f"{name} {i}", *shape) for i in range(count))
