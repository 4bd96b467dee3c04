"""Straight-line programs, the form between SymPy expressions and the text of a target language.

A program is a list of operations on scalars. An operation refers to earlier operations by index.
Equal operations share an index (value numbering), which eliminates common subexpressions. A printer
turns a program into text; each language has a printer. A program can also be evaluated directly
with NumPy.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from axisid.support.arrays import Array
from axisid.support.errors import ModelError

#: Names of all operations.
OPERATIONS = (
    "input",
    "constant",
    "neg",
    "add",
    "sub",
    "mul",
    "div",
    "pow",
    "sqrt",
    "exp",
    "log",
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "abs",
    "sign",
    "floor",
    "min",
    "max",
    "lt",
    "le",
    "eq",
    "not",
    "and",
    "or",
    "select",
)


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation of a program.

    Attributes
    ----------
    name : str
        One of `OPERATIONS`.
    operands : tuple of int
        Indices of the operands; empty for an input or a constant.
    symbol : str
        Name of an input, or text of a constant.
    value : float
        Value of a constant.
    """

    name: str
    operands: tuple[int, ...] = ()
    symbol: str = ""
    value: float = 0.0


@dataclass(frozen=True, slots=True)
class Input:
    """An argument of a program.

    Attributes
    ----------
    name : str
    elements : tuple of str
        Names of the elements of a column vector; only `name` itself for a scalar.
    """

    name: str
    elements: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Output:
    """A result of a program.

    Attributes
    ----------
    name : str
    rows : tuple of tuple of int
        Indices of operations, row by row, of a scalar, a row, a column or a matrix.
    """

    name: str
    rows: tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A function from scalars and vectors to matrices, without branches and loops.

    Attributes
    ----------
    name : str
    summary : str
        Description in one or two sentences.
    inputs : tuple of Input
        Arguments, in order.
    outputs : tuple of Output
        Results, in order.
    operations : tuple of Operation
        Operations in the order of evaluation.
    """

    name: str
    summary: str
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    operations: tuple[Operation, ...]

    @property
    def operation_count(self) -> int:
        """Return the number of operations, without inputs and constants."""
        return sum(bool(operation.operands) for operation in self.operations)


@dataclass(slots=True)
class Builder:
    """Collects the operations of a program; equal operations share an index.

    Attributes
    ----------
    inputs : list of Input
    outputs : list of Output
    operations : list of Operation
    reciprocals : bool
        True if a division becomes a product with the reciprocal, which is computed once for all
        divisions by the same value. This is faster for steps that often divide by the inertia.
    """

    inputs: list[Input] = field(default_factory=list)
    outputs: list[Output] = field(default_factory=list)
    operations: list[Operation] = field(default_factory=list)
    reciprocals: bool = False
    _index: dict[Operation, int] = field(default_factory=dict)

    def scalar(self, name: str) -> int:
        """Declare a scalar argument, and return its index."""
        return self.vector(name, (name,))[0]

    def vector(self, name: str, elements: Sequence[str]) -> tuple[int, ...]:
        """Declare a vector argument with named elements, and return their indices."""
        self.inputs.append(Input(name, tuple(elements)))
        return tuple(self._intern(Operation("input", symbol=element)) for element in elements)

    def constant(self, value: float) -> int:
        """Return the index of a constant.

        Raises
        ------
        ModelError
            The number is not finite, so that no target language has a literal for it.
        """
        number = float(value)
        if not math.isfinite(number):
            raise ModelError(
                "a number in the generated code is not finite, because a declared number of the "
                "drive, the law or the force is too small or too large. Correct this number.",
                code="not-finite",
            )
        return self._intern(Operation("constant", value=number, symbol=repr(number)))

    def apply(self, name: str, *operands: int) -> int:
        """Return the index of an operation on earlier operations, `operands`."""
        if name == "div" and self.reciprocals:
            one = self.constant(1)
            if operands[0] != one:
                return self.apply("mul", operands[0], self.apply("div", one, operands[1]))
        return self._intern(Operation(name, operands))

    def inline(self, program: Program, *arguments: Sequence[int]) -> dict[str, tuple[int, ...]]:
        """Copy the operations of another program into this one.

        Parameters
        ----------
        program : Program
        *arguments : sequence of int
            For each argument of the program, the indices of its elements in this builder.

        Returns
        -------
        dict of str to tuple of int
            Indices of the elements of each output in this builder, row by row.
        """
        index_of = {
            element: index
            for port, indices in zip(program.inputs, arguments, strict=True)
            for element, index in zip(port.elements, indices, strict=True)
        }
        here: list[int] = []  # index in this builder of each operation of the program
        for operation in program.operations:
            if operation.name == "input":
                here.append(index_of[operation.symbol])
            elif operation.operands:
                here.append(self.apply(operation.name, *(here[i] for i in operation.operands)))
            else:
                here.append(self._intern(operation))
        return {
            port.name: tuple(here[i] for row in port.rows for i in row) for port in program.outputs
        }

    def output(self, name: str, rows: Sequence[Sequence[int]]) -> None:
        """Declare a result by rows of indices."""
        self.outputs.append(Output(name, tuple(map(tuple, rows))))

    def program(self, name: str, summary: str) -> Program:
        """Return the program, without operations that no result needs."""
        needed = {i for port in self.outputs for row in port.rows for i in row}
        for index in range(len(self.operations) - 1, -1, -1):
            if index in needed:
                needed.update(self.operations[index].operands)
        kept = sorted(needed)
        renumbered = {old: new for new, old in enumerate(kept)}
        return Program(
            name=name,
            summary=summary,
            inputs=tuple(self.inputs),
            outputs=tuple(
                Output(port.name, tuple(tuple(renumbered[i] for i in row) for row in port.rows))
                for port in self.outputs
            ),
            operations=tuple(
                replace(op, operands=tuple(renumbered[i] for i in op.operands))
                for op in (self.operations[i] for i in kept)
            ),
        )

    def _intern(self, operation: Operation) -> int:
        """Return the index of an operation; add the operation if there is no equal one."""
        if operation not in self._index:
            self._index[operation] = len(self.operations)
            self.operations.append(operation)
        return self._index[operation]


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
    "select": lambda condition, *values: np.select([condition != 0], values[:1], values[1]),
}


def evaluate(program: Program, elements: Mapping[str, Array]) -> dict[str, Array]:
    """Return the results of a program at N points.

    Parameters
    ----------
    program : Program
    elements : mapping of str to (N,) array
        Every element of the program's arguments, by name.

    Returns
    -------
    dict of str to (N, elements) array
        Elements of each output, row by row, by the output's name.
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
