"""Functions evaluated at many samples at once, and the generated text that defines them."""

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
    """Return the number of values per sample of recorded signals: two for each, value and rate."""
    step = functions.get("closed_loop_step")
    if step is None or "signals" not in step.name_in():
        return 0
    return int(step.size1_in("signals"))


def is_continuous(functions: Mapping[str, Any]) -> bool:
    """Return whether the control law is continuous.

    Between samples the inputs of such a law (`HELD_REFERENCE`) are held. Under a sampled law the
    force is held, with a second value for some drives. The number of held values tells which.
    """
    return held_count(functions) == len(HELD_REFERENCE)


def held_count(functions: Mapping[str, Any]) -> int:
    """Return the number of values that are held between samples, without recorded signals."""
    return int(functions["held_acceleration"].size1_in("held")) - recorded_count(functions)


def by_sample(values: Array, samples: int) -> Array:
    """Return CasADi results, which are side by side, with one row per sample: (N, elements)."""
    height, width = values.shape[0], values.shape[1] // samples
    columns = values.reshape(height, samples, width).swapaxes(0, 1)
    return columns.reshape(samples, height * width)


@dataclass(frozen=True, slots=True)
class FunctionShape:
    """Sizes of the inputs and outputs of a function, read once because CasADi is slow.

    Attributes
    ----------
    name : str
    arguments : tuple of str
    lengths : tuple of int
        Lengths of the arguments.
    vectors : tuple of bool
        Whether each argument is a vector.
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
        There are too few or too many arguments, or one has another length.
    """
    if len(arguments) != len(shape.arguments):
        raise UsageError(
            f"{shape.name} takes {len(shape.arguments)} arguments, not {len(arguments)}.",
            code="generated-code",
        )
    arrays = [_floats(values, shape, i) for i, values in enumerate(arguments)]
    # Flags of the arguments that have a value for each sample.
    own = [a.ndim == 2 or not vector for a, vector in zip(arrays, shape.vectors, strict=True)]
    most = max((len(array) for array, each in zip(arrays, own, strict=True) if each), default=0)
    samples = most or int(not any(own))
    for i, array in enumerate(arrays):
        wanted = samples if own[i] else shape.lengths[i]
        if len(array) == wanted:
            continue
        if not shape.vectors[i] and len(array) == 1:
            arrays[i] = np.full(wanted, array[0])
        else:
            raise UsageError(
                f"{shape.name}: {shape.arguments[i]} has {len(array)} values, not {wanted}.",
                code="generated-code",
            )
    return arrays, samples


def _floats(values: ArrayLike, shape: FunctionShape, index: int) -> Array:
    """Return an argument as a contiguous array of floats.

    It is (N,) for a scalar, and (p,) or (N, p) for a vector.
    """
    if not (type(values) is np.ndarray and values.dtype == np.float64):
        values = real_array(values, f"{shape.name}: {shape.arguments[index]}")
    elif values.ndim == 1 and values.flags.c_contiguous:
        return values
    array = np.ascontiguousarray(values)
    # Only vectors with one row per sample keep their shape.
    own = shape.vectors[index] and array.ndim == 2 and len(array) > 1
    return array if own and array.shape[1] == shape.lengths[index] else array.ravel()


@lru_cache(maxsize=64)  # requested repeatedly for loops by gains and for laws
def execute(text: str, name: str) -> Mapping[str, Any]:
    """Return the CasADi functions that a generated ``functions.py`` defines, by name.

    Parameters
    ----------
    text : str
        Text written by `axis_artefacts` in this process: every name in it was checked at
        declaration, every number is a literal. Text from elsewhere must not be passed; it would
        run.
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
