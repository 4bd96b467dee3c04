"""Arrays of a file as its columns: numbers, time stamps, matrices, and a word on all else."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from axisid.support.arrays import Array
from axisid.support.files.memory import Room

from .table import Column, Table, loaded_column

_LISTED = 8
_FEWEST = 2  # values of a column


@dataclass(slots=True)
class TableBuilder:
    """The columns of a file while it is read, and what in it is none.

    Attributes
    ----------
    columns, passed_over : dict
        As in `Table`.
    room : Room or None
        The memory that there is for the columns; None where they are in memory already.
    texts : dict
        As in `Table`.
    """

    columns: dict[str, Column] = field(default_factory=dict)
    passed_over: dict[str, str] = field(default_factory=dict)
    room: Room | None = None
    texts: dict[str, list[str]] = field(default_factory=dict)

    def add(
        self,
        name: str,
        values: object,
        *,
        unit: str = "",
        label: str = "",
        clock: Array | None = None,
    ) -> None:
        """Take an array: numbers, or time stamps and durations, counted in s.

        Time stamps count from the first.
        """
        array, note = np.asarray(values), ""
        number = len(self.columns) + len(self.passed_over) + 1
        if array.dtype.kind == "M" and array.ndim == 1:
            note = f"{name}: time stamps counted from the first"
            stamps = array[~np.isnat(array)]
            array = array - (stamps[0] if len(stamps) else array)
        if array.dtype.kind == "m":
            array, unit = array / np.timedelta64(1, "s"), "s"
        if array.dtype.kind not in "fiub" or array.ndim != 1:
            self.passed_over[label or name] = _content(array)
            if array.ndim == 1 and self.passed_over[label or name] == "text":
                self.texts[label or name] = [str(cell) for cell in array]
            return
        if self.room is not None:
            self.room.take(8 * array.size)
        numbers = array.astype(np.float64)
        column = loaded_column(numbers, unit=unit, label=label, clock=clock, note=note)
        self.columns[name] = replace(column, number=number)

    def add_array(self, name: str, values: object, unit: str = "") -> None:
        """Take an array of any shape: a vector, or a matrix whose columns are numbered from 1.

        Of a matrix that is wider than long, as Simulink's `To File` writes it, the rows are taken.
        """
        array = np.asarray(values)
        if array.size < _FEWEST or (array.ndim > 2 and array.size > max(array.shape)):
            self.passed_over[name] = _content(array)
        elif array.size == max(array.shape):
            self.add(name, array.ravel(), unit=unit)
        elif array.shape[1] <= array.shape[0]:
            for k, column in enumerate(array.T, 1):
                self.add(f"{name}.{k}", column)
        else:
            for k, row in enumerate(array, 1):
                self.add(f"{name}.{k}", row)
                self.note(f"{name}.{k}", f"{name}: wider than long, so its rows are columns")

    def table(
        self,
        source: str,
        notes: tuple[str, ...] = (),
        missing: str = "",
        warnings: tuple[str, ...] = (),
    ) -> Table:
        """What was gathered."""
        return Table(
            source=source,
            columns=self.columns,
            notes=notes,
            missing=missing,
            passed_over=self.passed_over,
            texts=self.texts,
            warnings=warnings,
        )

    def else_there(self) -> str:
        """What there is that is no column, in parentheses."""
        listed = ", ".join(
            f"{name}: {what}" for name, what in [*self.passed_over.items()][:_LISTED]
        )
        return f" ({listed})" if listed else ""

    def note(self, name: str, text: str) -> None:
        """Say of a column, if it is one, what was assumed."""
        if text and name in self.columns:
            self.columns[name] = replace(self.columns[name], note=text)


def _content(array: np.ndarray[Any, Any]) -> str:
    """What an array holds that is no column."""
    kind = array.dtype.kind
    if kind in "fiubmM":
        shape = " x ".join(str(length) for length in array.shape)
        return f"numbers of the shape {shape}" if array.size >= _FEWEST else "less than two numbers"
    if kind == "c":
        return "complex numbers"
    if kind in "SUT":
        return "text"
    first = next((type(value).__name__ for value in array.ravel() if value is not None), "")
    return {"": "nothing", "str": "text"}.get(first, f"objects ({first or array.dtype})")
