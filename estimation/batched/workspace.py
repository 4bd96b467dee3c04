"""Arrays that one block after the other is worked out in.

The system gives memory page by page as it is first written to, which takes as long as what is
written. So what a thread had for one block serves for its next. What it keeps is bounded: a block
of a long record has arrays of its own.
"""

from threading import local
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array

Scalar = TypeVar("Scalar", bound=np.generic)

_KEPT = local()
_MOST = 2**24  # values that a thread keeps, 134 MB; what would go beyond is let go after use


def space(name: str, *shape: int) -> Array:
    """An array of a name, with whatever is in it; that of the name before is of no use any more."""
    size = int(np.prod(shape))
    kept: dict[str, Array] = vars(_KEPT).setdefault("arrays", {})
    if name not in kept or kept[name].size < size:
        kept.pop(name, None)
        if size + sum(each.size for each in kept.values()) > _MOST:
            return np.empty(shape)
        kept[name] = np.empty(size)
    return kept[name][:size].reshape(shape)


def spaces(name: str, count: int, *shape: int) -> tuple[Array, ...]:
    """Several arrays of one shape."""
    return tuple(space(f"{name} {i}", *shape) for i in range(count))


def some_lanes(values: NDArray[Scalar] | None, chosen: NDArray[np.intp]) -> NDArray[Scalar] | None:
    """Some lanes, by number, of values (..., L) that there may be, in contiguous memory."""
    return None if values is None else np.ascontiguousarray(values[..., chosen])
