"""Columns of files whose libraries read some rows of one column at a time, as tables of blocks."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.tables import Column, Samples, Table
from axisid.support.arrays import Array

#: Values from one row to before another.
Reader = Callable[[int, int], NDArray[Any]]


@dataclass(frozen=True, slots=True, kw_only=True)
class SlicedColumn:
    """A column that is read some rows at a time.

    Attributes
    ----------
    name : str
    length : int
        Rows there are.
    read : callable
        Numbers from one row to before another.
    clock : callable or None
        Their times, s; None for a column without its own.
    unit, note : str
        As of `Column`.
    """

    name: str
    length: int
    read: Reader
    clock: Reader | None = None
    unit: str = ""
    note: str = ""


def sliced_tables(
    source: str, columns: Sequence[SlicedColumn], rows: int, notes: tuple[str, ...] = ()
) -> Iterator[Table]:
    """The table of columns, so many rows at a time; what no role asks for is not read."""
    for start in range(0, max((each.length for each in columns), default=0), rows):
        yield Table(
            source=source,
            columns={each.name: _column(each, start, start + rows) for each in columns},
            notes=notes,
        )


def _column(column: SlicedColumn, start: int, stop: int) -> Column:
    read = partial(_samples, column, min(start, column.length), min(stop, column.length))
    return Column(read=read, unit=column.unit, note=column.note)


def _samples(column: SlicedColumn, start: int, stop: int) -> Samples:
    values = _floats(column.read(start, stop))
    return Samples(
        values=values, clock=None if column.clock is None else _floats(column.clock(start, stop))
    )


def _floats(values: NDArray[Any]) -> Array:
    return np.asarray(values, dtype=np.float64)


def matrix_columns(name: str, shape: tuple[int, ...], values: Any) -> list[SlicedColumn]:
    """The columns of an array that is stored transposed, as MATLAB's are; see `add_array`.

    Parameters
    ----------
    name : str
    shape : tuple of int
        As it is stored.
    values : data set
        Sliced as an array of that shape.
    """
    size, longest = int(np.prod(shape)), max(shape, default=0)
    if size < 2 or (len(shape) > 2 and size > longest):  # a column has two values
        return []
    if size == longest:
        axis = shape.index(longest)
        return [SlicedColumn(name=name, length=longest, read=partial(_along, values, axis, ()))]
    wide = shape[0] > shape[1]
    note = f"{name}: wider than long, so its rows are columns" if wide else ""
    axis, count = (0, shape[1]) if wide else (1, shape[0])
    return [
        SlicedColumn(
            name=f"{name}.{k + 1}",
            length=longest,
            read=partial(_along, values, axis, (k,)),
            note=note,
        )
        for k in range(count)
    ]


def _along(values: Any, axis: int, other: tuple[int, ...], start: int, stop: int) -> NDArray[Any]:
    """Part of a line of an array along an axis, at another index of the other."""
    place: list[int | slice] = [0] * len(values.shape)
    if other:
        place[1 - axis] = other[0]
    place[axis] = slice(start, stop)
    return np.asarray(values[tuple(place)])
