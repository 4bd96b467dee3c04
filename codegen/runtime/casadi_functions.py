"""CasADi functions from generated text, and their arguments and results at many samples."""

import linecache
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.lowering import HELD_REFERENCE
from axisid.support.arrays import Array
from axisid.support.checks import real_array
from axisid.support.errors import UsageError

#: Arguments that are vectors; all others are scalars.
VECTORS = frozenset(
    {"parameters", "ddm_parameters", "law_gains", "state", "held", "sides", "signals", "states"}
)


def recorded_count(functions: Mapping[str, Any]) -> int:
    """Return the number of values of all recorded signals at a sample: value and rate of each."""
    step = functions.get("closed_loop_step")
    if step is None or "signals" not in step.name_in():
        return 0
    return int(step.size1_in("signals"))


def is_continuous(functions: Mapping[str, Any]) -> bool:
    """Return True if the control law is continuous.

    Under a continuous law its inputs (`HELD_REFERENCE`) are held between samples. Under a sampled
    law the force is held, for some drives with a second value. So the number of held values shows
    the kind of the law.
    """
    return held_count(functions) == len(HELD_REFERENCE)


def held_count(functions: Mapping[str, Any]) -> int:
    """Return the number of values that are held between samples, without recorded signals."""
    return int(functions["held_acceleration"].size1_in("held")) - recorded_count(functions)


def by_sample(values: Array, samples: int) -> Array:
    """Return the results of a CasADi function at N samples as an (N, elements) array.

    `values` has the result matrices of the samples side by side.
    """
    height, width = values.shape[0], values.shape[1] // samples
    columns = values.reshape(height, samples, width).swapaxes(0, 1)
    return columns.reshape(samples, height * width)


@dataclass(frozen=True, slots=True)
class FunctionShape:
    """Sizes of the arguments and results of a function, read once because CasADi is slow.

    Attributes
    ----------
    name : str
    arguments : tuple of str
        Names of the arguments.
    lengths : tuple of int
        Lengths of the arguments.
    vectors : tuple of bool
        True for each argument that is a vector.
    results : tuple of int
        Number of elements of each result.
    """

    name: str
    arguments: tuple[str, ...]
    lengths: tuple[int, ...]
    vectors: tuple[bool, ...]
    results: tuple[int, ...]

    @classmethod
    def of(cls, function: Any) -> "FunctionShape":
        """Return the shape of a CasADi function."""
        names = tuple(function.name_in())
        return cls(
            function.name(),
            names,
            tuple(function.size1_in(i) for i in range(len(names))),
            tuple(name in VECTORS for name in names),
            tuple(function.numel_out(i) for i in range(function.n_out())),
        )


def checked_arguments(
    shape: FunctionShape, arguments: Sequence[ArrayLike]
) -> tuple[list[Array], int]:
    """Return the arguments of a function at many samples, and the number of samples.

    Scalars have one value per sample, (N,); vectors are the same for every sample, (p,), or have
    one row per sample, (N, p).

    Raises
    ------
    UsageError
        There are too few or too many arguments, or the length of an argument is wrong.
    """
    if len(arguments) != len(shape.arguments):
        raise UsageError(
            f"{shape.name} takes {len(shape.arguments)} arguments, not {len(arguments)}. Give "
            f"{', '.join(shape.arguments)}.",
            code="generated-code",
        )
    arrays = [_floats(values, shape, i) for i, values in enumerate(arguments)]
    # True for the arguments that have a value for each sample.
    varying = [a.ndim == 2 or not vector for a, vector in zip(arrays, shape.vectors, strict=True)]
    sizes = [len(array) for array, varies in zip(arrays, varying, strict=True) if varies]
    # The largest number of values; one sample if all arguments are vectors.
    samples = max(sizes, default=0) or int(not any(varying))
    for i, array in enumerate(arrays):
        wanted = samples if varying[i] else shape.lengths[i]
        if len(array) == wanted:
            continue
        if not shape.vectors[i] and len(array) == 1:
            arrays[i] = np.full(wanted, array[0])
        else:
            raise UsageError(
                f"{shape.name}: {shape.arguments[i]} has {len(array)} values. Give {wanted}.",
                code="generated-code",
            )
    return arrays, samples


def _floats(values: ArrayLike, shape: FunctionShape, index: int) -> Array:
    """Return an argument as a contiguous array of floats.

    The shape is (N,) for a scalar argument, and (p,) or (N, p) for a vector argument.
    """
    if not (type(values) is np.ndarray and values.dtype == np.float64):
        values = real_array(values, f"{shape.name}: {shape.arguments[index]}")
    elif values.ndim == 1 and values.flags.c_contiguous:
        return values
    array = np.ascontiguousarray(values)
    # Only a vector with one row per sample stays two-dimensional.
    has_rows = shape.vectors[index] and array.ndim == 2 and len(array) > 1
    if has_rows and array.shape[1] == shape.lengths[index]:
        return array
    return array.ravel()


@lru_cache(maxsize=64)  # the same text is requested repeatedly for loops and laws
def execute(text: str, name: str) -> Mapping[str, Any]:
    """Return the CasADi functions that a generated ``functions.py`` defines, by name.

    Parameters
    ----------
    text : str
        Text that `axis_artefacts` wrote in this process. Names in it were checked when the axis was
        declared, and numbers are literals. Text from another source must not be passed, because it
        is executed.
    name : str
        Name of the axis, for tracebacks.

    Returns
    -------
    mapping of str to casadi.Function
    """
    filename = f"<generated {name}>"
    linecache.cache[filename] = (len(text), None, text.splitlines(keepends=True), filename)
    namespace: dict[str, Any] = {}
    exec(compile(text, filename, "exec"), namespace)  # noqa: S102
    return {function: make() for function, make in namespace["FUNCTIONS"].items()}
