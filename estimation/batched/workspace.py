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
_LINE = 8  # values of a line
_MOST = 2**24  # values that a thread keeps, 134 MB; what would go beyond is let go after use


def space(name: str, *shape: int) -> Array:
    """An array of a name, with whatever is in it; that of the name before is of no use any more."""
    size = int(np.prod(shape))
    kept: dict[str, Array] = vars(_KEPT).setdefault("arrays", {})
    if name not in kept or kept[name].size < size:
        kept.pop(name, None)
        if size + sum(each.size for each in kept.values()) > _MOST:
            return np.empty(shape)
        kept[name] = _at_cache_lines(size)
    return kept[name][:size].reshape(shape)


def _at_cache_lines(size: int) -> Array:
    """Values that begin with a line of the cache, so that no register of them lies in two."""
    values = np.empty(size + _LINE)
    return values[-values.ctypes.data // values.itemsize % _LINE :][:size]


def spaces(name: str, count: int, *shape: int) -> tuple[Array, ...]:
    """Several arrays of one shape."""
    return tuple(space(f"{name} {i}", *shape) for i in range(count))


def of_lanes(values: NDArray[Scalar], chosen: NDArray[np.intp]) -> NDArray[Scalar]:
    """Some lanes, by number, of values (..., L); all of them in their order as they are."""
    if _are_all(chosen, values.shape[-1]):
        return values
    return np.ascontiguousarray(values[..., chosen])


def some_lanes(values: NDArray[Scalar] | None, chosen: NDArray[np.intp]) -> NDArray[Scalar] | None:
    """The same of values that there may be."""
    return None if values is None else of_lanes(values, chosen)


def put_lanes(values: Array, chosen: NDArray[np.intp], made: Array) -> None:
    """Put values of some lanes, (..., B), among those of all, (..., L)."""
    if _are_all(chosen, values.shape[-1]):
        values[...] = made
    else:
        values[..., chosen] = made


def _are_all(chosen: NDArray[np.intp], lanes: int) -> bool:
    """Whether lanes by number are all there are, in their order."""
    return len(chosen) == lanes and bool(np.all(chosen == np.arange(lanes)))
