"""What a batch of loops is given, checked: lanes side by side, signals by name, threads."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.lowering import SIGNALS
from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.real_numbers import is_whole, real_array
from axisid.support.user_values import quoted

_MOST_THREADS = 1024


def check_lanes(parameters: Array, reference: Array) -> None:
    """Refuse arrays that are no lanes side by side."""
    lanes = len(parameters)
    if parameters.ndim != 2 or reference.shape[1:] not in ((), (lanes,)):
        raise UsageError(
            f"parameters have the shape {parameters.shape} and the reference {reference.shape}; "
            "give (B, p) and (N,) or (N, B).",
            code="batch-shapes",
        )
    if not lanes:
        raise UsageError("no parameter set was given; give at least one lane.", code="no-lane")


def check_threads(threads: int | None) -> None:
    """Refuse what is no number of threads."""
    if threads is not None and not (is_whole(threads) and 1 <= threads <= _MOST_THREADS):
        raise UsageError(
            f"the threads are {quoted(threads)}; give a whole number from 1 to {_MOST_THREADS}."
        )


def lane_noise(noise: ArrayLike | None, shape: tuple[int, int]) -> Array | None:
    """Noise of the positions, one column a lane, if there is any."""
    if noise is None:
        return None
    lanes = aligned(noise, "the noise")
    if lanes.shape != shape or not np.all(np.isfinite(lanes)):
        raise UsageError(
            f"the noise has the shape {lanes.shape}; give {shape}, all finite.", code="batch-noise"
        )
    return lanes


def lane_injected(injected: ArrayLike | None, shape: tuple[int, int]) -> Array | None:
    """What is added to the control, shared or one column a lane, if there is any."""
    if injected is None:
        return None
    lanes = aligned(injected, "the injected signal")
    if lanes.shape not in (shape[:1], shape) or not np.all(np.isfinite(lanes)):
        raise UsageError(
            f"the injected signal has the shape {lanes.shape}; give {shape[:1]} or {shape}, all "
            "finite.",
            code="batch-injected",
        )
    return lanes


def wanted_names(signals: Sequence[str]) -> list[str]:
    """The generated code's names of the signals."""
    names = {"direction_before" if name == "before" else name: name for name in SIGNALS}
    several = isinstance(signals, Iterable) and not isinstance(signals, str)
    if not several or not all(isinstance(name, str) for name in signals):
        raise UsageError(
            f"the wanted signals are {quoted(signals)}; give a list of names.", code="signals-type"
        )
    if unknown := set(signals) - set(names):
        raise UsageError(
            f"there is no signal {', '.join(sorted(unknown))}; there are {', '.join(names)}.",
            code="unknown-signal",
        )
    return [names[name] for name in signals]


def aligned(values: ArrayLike, what: str) -> Array:
    """The array itself, unless its floats do not lie on whole multiples of their size."""
    array = np.require(real_array(values, what), requirements=["A"])
    whole = all(stride % array.itemsize == 0 for stride in array.strides)
    return array if whole else array.copy()
