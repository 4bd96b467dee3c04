"""One array type for all rooms.

Dimensions: N samples of a record, n rows of a regression, p physical parameters, m parameters of
the direct model.
"""

import math
from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """A read-only float copy."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def relative_error_percent(error: Array, signal: Array) -> float:
    """``100 ||error|| / ||signal||``."""
    return 100.0 * float(np.linalg.norm(error) / np.linalg.norm(signal))


def finite_tree(value: Any) -> Any:
    """A document for JSON with None for every number that is not finite."""
    if isinstance(value, dict):
        return {key: finite_tree(each) for key, each in value.items()}
    if isinstance(value, list):
        return [finite_tree(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def finite(value: float) -> float | None:
    """A number for JSON: None for what is not finite."""
    return float(value) if math.isfinite(value) else None


def runs(chosen: NDArray[np.bool_], start: int = 0) -> tuple[tuple[int, int], ...]:
    """First place and the one after the last of each run of what is chosen, from `start` on."""
    edges = start + np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]])))
    return tuple((int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True))


def covered(spans: Iterable[tuple[int, int]], size: int) -> NDArray[np.bool_]:
    """Which of so many places are in a span, from its first place to before its last, (size,)."""
    inside = np.zeros(size, dtype=bool)
    for start, stop in spans:
        inside[start:stop] = True
    return inside
