"""Builder of a table, to which the columns of a file are added while the file is read."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.memory import Room

from .table import RawColumn, Samples, Table

#: Content of arrays without real numbers, by NumPy's kind of their type, for messages.
_NO_NUMBERS = {"c": "complex numbers", **dict.fromkeys("SUT", "text")}


@dataclass(slots=True)
class TableBuilder:
    """Builder of the table of a file.

    Attributes
    ----------
    columns : dict of str to RawColumn
        Columns that have been added, by name.
    room : Room
        Memory for the columns; unlimited for columns that are in memory already.
    """

    columns: dict[str, RawColumn] = field(default_factory=dict)
    room: Room = field(default_factory=lambda: Room("", math.inf))

    def add(
        self,
        name: str,
        values: object,
        *,
        unit: str = "",
        label: str = "",
        clock: Array | None = None,
        note: str = "",
    ) -> None:
        """Add a vector of numbers, or of time stamps or durations, which are converted to s.

        Time stamps are relative to the first time stamp. Any other array is added as a column that
        cannot be used.

        Parameters
        ----------
        name : str
            Name of the column.
        values : array_like
            Values of the column.
        unit : str
            Unit as in the file; empty for none.
        label : str
            Name and unit as in the file, if the name was taken from them; otherwise empty.
        clock : (N,) array, optional
            Times of the samples, s, if the file has times for each column.
        note : str
            Assumption about the column; empty for none.

        Raises
        ------
        DataError
            There is a column of this name already, or the memory is exceeded.
        """
        array = np.asarray(values)
        if array.dtype.kind == "M" and array.ndim == 1:
            note = f"{name}: time stamps, relative to the first"
            stamps = array[~np.isnat(array)]
            array = array - (stamps[0] if len(stamps) else array)
        if array.dtype.kind == "m":
            array, unit = array / np.timedelta64(1, "s"), "s"
        if array.dtype.kind not in "fiub" or array.ndim != 1:
            self.pass_over(label or name, _content(array))
            return
        self.room.take(8 * array.size)
        self._put(
            name,
            RawColumn(
                samples=Samples(values=array.astype(np.float64), clock=clock),
                unit=unit,
                label=label,
                note=note,
            ),
        )

    def pass_over(self, name: str, what: str) -> None:
        """Add a column that cannot be used, with a description of its content (`what`).

        Raises
        ------
        DataError
            There is a column of this name already.
        """
        error = DataError(
            f"the column {name!r} contains {what}. Choose another column.", code="columns"
        )
        self._put(name, RawColumn(samples=error, holds=what))

    def _put(self, name: str, column: RawColumn) -> None:
        """Add a column; refuse a second column of the same name, which would be ambiguous.

        Raises
        ------
        DataError
        """
        if name in self.columns:
            raise twice(name)
        self.columns[name] = column

    def add_array(self, name: str, values: object, unit: str = "") -> None:
        """Add an array of any shape: a vector, or a matrix whose columns are numbered from 1.

        The rows of a matrix that is wider than long are its columns, as in Simulink's `To File`. A
        single number, or an array of more dimensions, is added as a column that cannot be used.

        Raises
        ------
        DataError
            There is a column of the same name already, or the memory is exceeded.
        """
        array = np.asarray(values)
        if array.size < 2 or (array.ndim > 2 and array.size > max(array.shape)):
            self.pass_over(name, _content(array))
        elif array.size == max(array.shape):
            self.add(name, array.ravel(), unit=unit)
        else:
            wide = array.shape[1] > array.shape[0]
            note = f"{name}: wider than long, so its rows are read as columns" if wide else ""
            for k, column in enumerate(array if wide else array.T, 1):
                self.add(f"{name}.{k}", column, note=note)

    def table(
        self,
        source: str,
        notes: tuple[str, ...] = (),
        missing: str = "",
        warnings: tuple[str, ...] = (),
        *,
        advice: str = "",
    ) -> Table:
        """Return the table of the added columns.

        Parameters
        ----------
        source, notes, missing, warnings
            Attributes of the `Table`.
        advice : str
            Instruction for a file without columns of numbers, without a full stop.

        Raises
        ------
        DataError
            There is no column of numbers, and advice is given.
        """
        if advice and all(column.holds for column in self.columns.values()):
            listed = ", ".join(f"{n}: {c.holds}" for n, c in [*self.columns.items()][:8])
            found = f" ({listed})" if listed else ""
            raise DataError(
                f"{source} has no columns of numbers{found}. {advice[:1].upper()}{advice[1:]}.",
                code="columns",
            )
        return Table(
            source=source,
            columns=self.columns,
            notes=notes,
            missing=missing,
            warnings=warnings,
        )


def twice(name: str) -> DataError:
    """Return the error of a file in which two columns have the same name."""
    return DataError(
        f"The name {name!r} occurs twice in the log, so it is ambiguous. Rename one of the two "
        "columns in the file.",
        code="columns",
    )


def _content(array: np.ndarray[Any, Any]) -> str:
    """Return the content of an array that is not a vector of numbers, for messages."""
    if array.dtype.kind in "fiubmM":
        if array.size == 1:
            return f"one number, {array.ravel()[0]}"
        return f"numbers of the shape {' x '.join(map(str, array.shape))}"
    if array.dtype.kind in _NO_NUMBERS:
        return _NO_NUMBERS[array.dtype.kind]
    first = next((type(value).__name__ for value in array.ravel() if value is not None), "")
    return {"": "nothing", "str": "text"}.get(first, f"objects ({first})")
