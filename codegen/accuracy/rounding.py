"""How far rounding may move the results of a function: a running error bound.

Two programs that compute the same with the same operations, or with their order slightly changed,
differ by no more than such bounds. They follow the operations as they are, so that they are wide
where a model magnifies rounding, and only there.
"""

from collections.abc import Sequence
from typing import Any

import casadi
import numpy as np

from axisid.support.arrays import Array

#: Of an operation's result: some units in the last place, since libraries' functions differ.
_ROUNDING = 4 * np.finfo(float).eps


def rounding_bounds(function: Any, arguments: Sequence[Array]) -> tuple[Array, ...]:
    """How far rounding may move each output of a function at n points.

    Parameters
    ----------
    function : casadi.Function
        Of scalar operations (SX).
    arguments : sequence of (size, n) or (size, 1) arrays
        One per input; taken as exact.

    Returns
    -------
    tuple of (n, elements) arrays
        One per output, elements row by row; infinite where rounding may decide of the result.
    """
    points = max(argument.shape[1] for argument in arguments)
    work = np.zeros((2, function.sz_w(), points))  # values and their bounds
    bounds = [np.zeros((function.numel_out(i), points)) for i in range(function.n_out())]
    places = [_row_by_row(function.sparsity_out(i)) for i in range(function.n_out())]
    with np.errstate(all="ignore"):
        for k in range(function.n_instructions()):
            operation, slots = function.instruction_id(k), function.instruction_input(k)
            result = function.instruction_output(k)
            if operation == casadi.OP_OUTPUT:
                bounds[result[0]][places[result[0]][result[1]]] = work[1, slots[0]]
            elif operation == casadi.OP_INPUT:
                work[0, result[0]], work[1, result[0]] = arguments[slots[0]][slots[1]], 0.0
            elif operation == casadi.OP_CONST:
                value = function.instruction_constant(k)
                exact = value == round(value) if np.isfinite(value) else True
                work[0, result[0]] = value
                work[1, result[0]] = 0.0 if exact else _ROUNDING * abs(value)
            else:
                work[:, result[0]] = _applied(operation, work[:, slots])
    return tuple(bound.T for bound in bounds)


def _applied(operation: int, operands: Array) -> Array:
    """Value and bound, (2, n), of an operation from those of its operands, (2, operands, n)."""
    values, bounds = operands
    if operation in (casadi.OP_ADD, casadi.OP_SUB):
        second = values[1] if operation == casadi.OP_ADD else -values[1]
        here, bound = values[0] + second, bounds[0] + bounds[1]
    elif operation == casadi.OP_MUL:
        here, sizes = values[0] * values[1], np.abs(values)
        bound = sizes[0] * bounds[1] + bounds[0] * (sizes[1] + bounds[1])
    else:
        here, bound = _tried(operation, values, bounds)
    bound = bound + _ROUNDING * np.where(np.isfinite(here), np.abs(here), 0.0)
    unknown = ~np.isfinite(bounds).all(axis=0) | ~np.isfinite(bound)
    if operation == casadi.OP_SIGN:  # of what is not a number, C says 0
        unknown |= np.isnan(values[0])
    return np.stack([here, np.where(unknown, np.inf, bound)])


def _tried(operation: int, values: Array, bounds: Array) -> tuple[Array, Array]:
    """What an operation gives, and how far that moves with each operand within its bound."""
    tried = [values]
    for i in range(len(values)):
        for sign in (1, -1):
            moved = values.copy()
            moved[i] += sign * bounds[i]
            tried.append(moved)
    here, *there = _evaluated(operation, np.stack(tried, axis=1))
    moves = np.abs(np.stack(there) - here)
    moves[(there == here) | (np.isnan(there) & np.isnan(here))] = 0.0
    return here, np.maximum(moves[::2], moves[1::2]).sum(axis=0)


def _evaluated(operation: int, operands: Array) -> Array:
    """An operation on (operands, tried, n) values: (tried, n)."""
    matrices = [casadi.DM(each) for each in operands]
    apply = casadi.DM.unary if len(matrices) == 1 else casadi.DM.binary
    return np.asarray(apply(operation, *matrices).full())


def _row_by_row(sparsity: Any) -> list[int]:
    """Place of each stored element, column by column, in the dense result row by row."""
    rows, columns = sparsity.get_triplet()
    return [row * sparsity.size2() + column for row, column in zip(rows, columns, strict=True)]
