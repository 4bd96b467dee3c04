"""Arguments and results of functions that are evaluated at many samples at once."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.real_numbers import real_array

#: Arguments that are vectors; every other one is a scalar.
VECTORS = frozenset({"parameters", "ddm_parameters", "state", "held", "sides", "signals"})


def recorded_values(functions: Mapping[str, Any]) -> int:
    """How many numbers a sample has of recorded signals: of each its value and its rate."""
    step = functions.get("closed_loop_step")
    if step is None or "signals" not in step.name_in():
        return 0
    return int(step.size1_in("signals"))


def is_continuous(functions: Mapping[str, Any]) -> bool:
    """Whether a law is evaluated between samples, so that more than a force is held."""
    return int(functions["held_acceleration"].size1_in("held")) > 1 + recorded_values(functions)


def by_sample(values: Array, samples: int) -> Array:
    """CasADi puts the results of many samples side by side; here each gets a row."""
    height, width = values.shape[0], values.shape[1] // samples
    columns = values.reshape(height, samples, width).swapaxes(0, 1)
    return columns.reshape(samples, height * width)


def is_scalar(function: Any, index: int) -> bool:
    """Whether an argument is one number a sample."""
    return function.name_in(index) not in VECTORS


def checked_arguments(
    name: str, function: Any, arguments: Sequence[ArrayLike]
) -> tuple[list[Array], int]:
    """Arguments of a function at many samples, each of its length, and how many samples.

    Raises
    ------
    UsageError
        There are too few or too many, or one has another length.
    """
    if len(arguments) != function.n_in():
        raise UsageError(
            f"{name} takes {function.n_in()} arguments, not {len(arguments)}.",
            code="argument-count",
        )
    arrays = [_floats(a, name, function, i) for i, a in enumerate(arguments)]
    by_sample = [is_scalar(function, i) for i in range(len(arrays))]
    samples = max((len(a) for a, each in zip(arrays, by_sample, strict=True) if each), default=1)
    for i, array in enumerate(arrays):
        wanted = samples if by_sample[i] else function.size1_in(i)
        if by_sample[i] and len(array) == 1 != wanted:
            arrays[i] = np.full(wanted, array[0])
        elif len(array) != wanted:
            raise UsageError(
                f"{name}: {function.name_in(i)} has {len(array)} values, not {wanted}.",
                code="argument-length",
            )
    return arrays, samples


def _floats(values: ArrayLike, name: str, function: Any, index: int) -> Array:
    if not (type(values) is np.ndarray and values.dtype == np.float64):
        values = real_array(values, f"{name}: {function.name_in(index)}")
    return np.ascontiguousarray(values).ravel()
