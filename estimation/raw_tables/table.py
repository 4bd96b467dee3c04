"""What a file holds before any column has a role: names, units as written, what was assumed.

And where what became of it comes from, and how it was repaired.
"""

import io
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import shorten
from types import ModuleType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, DataError
from axisid.support.memory import Room

#: What arrays hold, by the kind of their cells.
_NO_NUMBERS = {"c": "complex numbers", **dict.fromkeys("SUT", "text")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Values of a column, (N,), with the times at which they were taken, if it has its own.

    Attributes
    ----------
    values : (N,) array
        In the unit of the file, nan where it has no value.
    clock : (N,) array or None
        s. Columns of one clock share one array.
    """

    values: Array
    clock: Array | None = None

    @property
    def times(self) -> Array:
        """The clock, or where there is none the numbers of the samples, (N,)."""
        return np.arange(float(len(self.values))) if self.clock is None else self.clock

    def taken(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> "Samples":
        """Some of the samples, by their numbers or as a mask, with their times."""
        clock = None if self.clock is None else self.clock[rows]
        return Samples(values=self.values[rows], clock=clock)


@dataclass(frozen=True, slots=True, kw_only=True)
class RawColumn:
    """A column of a file.

    Attributes
    ----------
    samples : Samples or DataError
        What is wrong with a column that holds no numbers.
    unit : str
        As the file writes it; empty where it writes none.
    label : str
        Name and unit as they stand in the file, where the name was cut out of it.
    note : str
        What was assumed of it, a sentence with its name, told where it is chosen.
    holds : str
        What it holds, where that is no numbers: it cannot be read.
    """

    samples: Samples | DataError
    unit: str = ""
    label: str = ""
    note: str = ""
    holds: str = ""

    def read(self) -> Samples:
        """The samples, or `DataError` of a column that holds no numbers."""
        if isinstance(self.samples, DataError):
            raise self.samples
        return self.samples


@dataclass(frozen=True, slots=True, kw_only=True)
class Repair:
    """One repair of a record.

    Attributes
    ----------
    kind : str
    count : int
        How often it was made: lines or samples left out, samples moved, jumps undone, samples
        masked, rows made, values drawn between others, gaps.
    text : str
        The same for the user, with the method.
    """

    kind: Literal[
        "tail",
        "wrap",
        "clipped",
        "empty",
        "clock",
        "resample",
        "gaps",
        "shift",
        "window",
        "between",
    ]
    count: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodSource:
    """Whose word the sampling period of a record is.

    Attributes
    ----------
    step : float
        Sampling period of the log itself, in periods of the record: 1 unless it was resampled.
    uncertainty : float
        Relative, of that: what jitter and lost samples leave open.
    counted : bool
        The log has no times: its samples were counted by the period that was given.
    stated : bool
        The user gave the log's period, beside its times or in place of them.
    """

    step: float = 1.0
    uncertainty: float = 0.0
    counted: bool = False
    stated: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Where a record comes from.

    Attributes
    ----------
    source : str
        File name, or how the record was made.
    sha256 : str
        Of the file, or of the files of a folder in the order of their names: of the very bytes that
        were used. Empty if there is none.
    given, path : str
        The file as it was named, and absolute; empty if there is none.
    columns : dict of str to str
        Column name by role.
    truth : dict of str to float
        Parameters of a simulated record, SI; empty for a measured one.
    assumed : tuple of str
        What was taken of the file: separator, encoding, units and their conversion.
    doubts : tuple of str
        What may be wrong with the data, and was taken as it is, with what to do about it.
    repairs : tuple of Repair
        What was done to the data, in this order; only on request, but for a last row that is cut.
    clock : PeriodSource or None
        Of a log that was read.
    """

    source: str = "arrays"
    sha256: str = ""
    given: str = ""
    path: str = ""
    columns: dict[str, str] = field(default_factory=dict)
    truth: dict[str, float] = field(default_factory=dict)
    assumed: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    repairs: tuple[Repair, ...] = ()
    clock: PeriodSource | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The columns of a file.

    Attributes
    ----------
    source : str
        The file as it was given, for messages.
    columns : mapping of str to RawColumn
    notes : tuple of str
        What was assumed of the file: separator, encoding, rows that were passed over.
    repairs : tuple of Repair
        Rows at its end that were left out: one that ends inside its last number, more on request.
    sha256 : str
        Of the file; empty if there is none.
    path : str
        Of the file, absolute; empty if there is none.
    missing : str
        More to say where a column is not found, such as how to save what cannot be read.
    warnings : tuple of str
        What the library that read the file says is wrong with it.
    """

    source: str
    columns: Mapping[str, RawColumn]
    notes: tuple[str, ...] = ()
    repairs: tuple[Repair, ...] = ()
    sha256: str = ""
    path: str = ""
    missing: str = field(default="", repr=False)
    warnings: tuple[str, ...] = ()

    def find(self, name: str) -> str | None:
        """The column of a name: its own, its label, or the last parts of one dotted name alone."""
        alike = self.alike(name)
        return alike[0] if len(alike) == 1 else None

    def alike(self, name: str) -> list[str]:
        """The columns that a name may stand for."""
        if name in self.columns:
            return [name]
        labelled = [own for own, column in self.columns.items() if column.label == name]
        ending = [own for own in self.columns if own.endswith(f".{name}")]
        place = re.fullmatch(r"#([1-9]\d{0,5})", name)
        numbered = [*self.columns][int(place[1]) - 1 : int(place[1])] if place else []
        return labelled or ending or numbered

    def listed(self) -> str:
        """Names of the columns, for messages."""
        names = [name for name, column in self.columns.items() if not column.holds]
        more = f" and {len(names) - 40} more" if len(names) > 40 else ""
        return (", ".join(names[:40]) or "no columns") + more


def numbered(names: Sequence[str]) -> list[str]:
    """Names of columns, those that occur more than once numbered from 1: ``Time.1``, ``Time.2``.

    The name alone then stands for none of them, and is refused where it is asked for.
    """
    times, seen, unique = Counter(names), Counter[str](), []
    for name in names:
        unique_name = name
        while name and times[name] > 1 and unique_name in times:
            seen[name] += 1
            unique_name = f"{name}.{seen[name]}"
        unique.append(unique_name)
    return unique


def library(name: str, extra: str, file: Path) -> ModuleType:
    """Import an optional library, or say how to install it."""
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError as error:
        raise DataError(
            f"{file} needs the library {name.partition('.')[0]}, which is not installed; run: "
            f"pip install {name.partition('.')[0]} (or axisid with the extra {extra})",
            code="missing-library",
        ) from error


def one_line(error: Exception) -> str:
    """A third-party error message on one line, shortened."""
    if isinstance(error, MemoryError):
        return "there is not enough memory for what it claims to hold"
    plain = "".join(letter if letter.isprintable() else " " for letter in str(error))
    return shorten(plain.rstrip(". "), 200, placeholder=" ...") or type(error).__name__


@contextmanager
def refusing(damaged: str) -> Iterator[None]:
    """Refuse what a library cannot read, by its own words after a sentence.

    Damaged files raise errors of all kinds: of zip, zlib, struct, memory, index and name.
    """
    try:
        yield
    except AxisidError:
        raise
    except Exception as error:
        raise DataError(f"{damaged}: {one_line(error)}.", code="log-file") from error


@dataclass(slots=True)
class TableBuilder:
    """The columns of a file while it is read, and what in it is none.

    Attributes
    ----------
    columns : dict
        As in `Table`.
    room : Room
        The memory that there is for the columns; any where they are in memory already.
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
        """Take an array: numbers, or time stamps and durations, counted in s.

        Time stamps count from the first.
        """
        array = np.asarray(values)
        if array.dtype.kind == "M" and array.ndim == 1:
            note = f"{name}: time stamps counted from the first"
            stamps = array[~np.isnat(array)]
            array = array - (stamps[0] if len(stamps) else array)
        if array.dtype.kind == "m":
            array, unit = array / np.timedelta64(1, "s"), "s"
        if array.dtype.kind not in "fiub" or array.ndim != 1:
            self.pass_over(label or name, _content(array))
            return
        self.room.take(8 * array.size)
        self.columns[name] = RawColumn(
            samples=Samples(values=array.astype(np.float64), clock=clock),
            unit=unit,
            label=label,
            note=note,
        )

    def pass_over(self, name: str, what: str) -> None:
        """Take a column that holds no numbers but something else."""
        self.columns[name] = RawColumn(
            samples=DataError(
                f"the column {name!r} holds {what}; choose another column.", code="columns"
            ),
            holds=what,
        )

    def add_array(self, name: str, values: object, unit: str = "") -> None:
        """Take an array of any shape: a vector, or a matrix whose columns are numbered from 1.

        Of a matrix that is wider than long, as Simulink's `To File` writes it, the rows are taken.
        """
        array = np.asarray(values)
        if array.size < 2 or (array.ndim > 2 and array.size > max(array.shape)):
            self.pass_over(name, _content(array))
        elif array.size == max(array.shape):
            self.add(name, array.ravel(), unit=unit)
        else:
            wide = array.shape[1] > array.shape[0]
            note = f"{name}: wider than long, so its rows are columns" if wide else ""
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
        """What was gathered.

        Raises
        ------
        DataError
            That is no column, and there is advice on it.
        """
        if advice and all(column.holds for column in self.columns.values()):
            listed = ", ".join(f"{n}: {c.holds}" for n, c in [*self.columns.items()][:8])
            raise DataError(
                f"{source} holds no columns of numbers{f' ({listed})' * bool(listed)}; {advice}.",
                code="columns",
            )
        return Table(
            source=source,
            columns=self.columns,
            notes=notes,
            missing=missing,
            warnings=warnings,
        )


def _content(array: np.ndarray[Any, Any]) -> str:
    if array.dtype.kind in "fiubmM":
        if array.size == 1:
            return f"one number, {array.ravel()[0]}"
        return f"numbers of the shape {' x '.join(map(str, array.shape))}"
    if array.dtype.kind in _NO_NUMBERS:
        return _NO_NUMBERS[array.dtype.kind]
    first = next((type(value).__name__ for value in array.ravel() if value is not None), "")
    return {"": "nothing", "str": "text"}.get(first, f"objects ({first})")


def npz_bytes(arrays: Mapping[str, Any]) -> bytes:
    """The content of a NumPy archive."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def parquet_bytes(
    columns: Mapping[str, Any], units: Mapping[str, str], about: Mapping[str, str], file: Path
) -> bytes:
    """The content of a Parquet file.

    Parameters
    ----------
    columns : mapping of str to array_like
    units : mapping of str to str
        Of the columns that have one, the metadata ``unit`` of the field.
    about : mapping of str to str
        What the file says of itself, in the metadata of its schema.
    file : Path
        For messages.

    Raises
    ------
    DataError
        pyarrow is not installed.
    """
    arrow = library("pyarrow", "parquet", file)
    parquet = library("pyarrow.parquet", "parquet", file)
    arrays = {name: arrow.array(values) for name, values in columns.items()}
    fields = [
        arrow.field(name, values.type, metadata={"unit": units[name]} if units.get(name) else None)
        for name, values in arrays.items()
    ]
    schema = arrow.schema(fields, metadata=dict(about))
    buffer = io.BytesIO()
    parquet.write_table(arrow.Table.from_arrays([*arrays.values()], schema=schema), buffer)
    return buffer.getvalue()
