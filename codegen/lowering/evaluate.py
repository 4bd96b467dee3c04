"""Programs run as they are, without any target: what their operations give, number by number."""

from collections.abc import Callable, Mapping

import numpy as np

from axisid.support.arrays import Array

from .program import Program


def _select(condition: Array, value: Array, otherwise: Array) -> Array:
    chosen: Array = np.where(condition != 0, value, otherwise)
    return chosen


_FUNCTIONS: dict[str, Callable[..., Array]] = {
    "neg": np.negative,
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "pow": np.power,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "min": np.fmin,
    "max": np.fmax,
    "lt": lambda a, b: (a < b).astype(float),
    "le": lambda a, b: (a <= b).astype(float),
    "eq": lambda a, b: (a == b).astype(float),
    "not": lambda a: (a == 0).astype(float),
    "and": lambda a, b: ((a != 0) & (b != 0)).astype(float),
    "or": lambda a, b: ((a != 0) | (b != 0)).astype(float),
    "select": _select,
}


def evaluate(program: Program, elements: Mapping[str, Array]) -> dict[str, Array]:
    """Results of a program at N points.

    Parameters
    ----------
    program : Program
    elements : mapping of str to (N,) array
        Every element of its arguments by name.

    Returns
    -------
    dict of str to (N, elements) array
        By output, row by row.
    """
    points = len(next(iter(elements.values())))
    values: list[Array] = []
    with np.errstate(all="ignore"):
        for operation in program.operations:
            if operation.name == "input":
                values.append(elements[operation.symbol])
            elif operation.name == "constant":
                values.append(np.full(points, operation.value))
            else:
                function = _FUNCTIONS.get(operation.name) or getattr(np, operation.name)
                values.append(function(*(values[i] for i in operation.operands)))
    return {
        port.name: np.array([values[i] for row in port.rows for i in row]).reshape(-1, points).T
        for port in program.outputs
    }
