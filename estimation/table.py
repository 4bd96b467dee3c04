"""What a file holds before any column has a role: names, units as written, and what was assumed."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import numpy as np

from .arrays import Array
from .errors import DataError
from .provenance import Repair

_LISTED = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Values of a column, (N,), with the times at which they were taken, if it has its own.

    Attributes
    ----------
    values : (N,) array
        In the unit of the file.
    clock : (N,) array or None
        s. Columns of one clock share one array.
    """

    values: Array
    clock: Array | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column, read when it is asked for.

    Attributes
    ----------
    read : callable
        Gives the samples, or raises `DataError` for a column that holds no numbers.
    unit : str
        As the file writes it; empty where it writes none.
    label : str
        Name and unit as they stand in the file, where the name was cut out of it.
    note : str
        What was assumed of this column, told where it is used.
    """

    read: Callable[[], Samples]
    unit: str = ""
    label: str = ""
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The columns of a file.

    Attributes
    ----------
    source : str
        File name, for messages.
    columns : mapping of str to Column
    notes : tuple of str
        What was assumed of the file: separator, encoding, rows that were passed over.
    repairs : tuple of Repair
        What was done to the file on request, before its columns were read.
    sha256 : str
        Of the file; empty if there is none.
    missing : str
        More to say where a column is not found, such as how to save what cannot be read.
    """

    source: str
    columns: Mapping[str, Column]
    notes: tuple[str, ...] = ()
    repairs: tuple[Repair, ...] = ()
    sha256: str = ""
    missing: str = field(default="", repr=False)

    def find(self, name: str) -> str | None:
        """The column of a name: its own, its label, or the last part of one dotted name alone."""
        alike = self.alike(name)
        return alike[0] if len(alike) == 1 else None

    def alike(self, name: str) -> list[str]:
        """The columns that a name may stand for."""
        if name in self.columns:
            return [name]
        labelled = [own for own, column in self.columns.items() if column.label == name]
        return labelled or [own for own in self.columns if own.rpartition(".")[2] == name]

    def listed(self) -> str:
        """Names of the columns, for messages."""
        names = list(self.columns)
        more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
        return (", ".join(names[:_LISTED]) or "no columns") + more


def at_hand(
    values: Array, *, unit: str = "", label: str = "", clock: Array | None = None, note: str = ""
) -> Column:
    """A column whose values are already in memory."""
    samples = Samples(values=values, clock=clock)
    return Column(read=lambda: samples, unit=unit, label=label, note=note)


def vector_columns(name: str, values: object, unit: str = "") -> dict[str, Column]:
    """Columns of an array: itself, or one for each column of a matrix, numbered from 1.

    What holds no numbers, or fewer than two, gives none.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "fiub" or array.size < 2 or array.ndim > 2:
        return {}
    if array.size == max(array.shape):
        return {name: at_hand(array.ravel().astype(np.float64), unit=unit)}
    return {
        f"{name}.{k}": at_hand(column.astype(np.float64), unit=unit)
        for k, column in enumerate(array.T, 1)
    }


def numbered(names: Sequence[str]) -> list[str]:
    """Names of columns, those that occur more than once numbered from 1: ``Time.1``, ``Time.2``.

    The name alone then stands for none of them, and is refused where it is asked for.
    """
    times, seen = Counter(names), Counter[str]()
    taken, apart = set(names), []
    for name in names:
        if name and times[name] > 1:
            seen[name] += 1
            while f"{name}.{seen[name]}" in taken:
                seen[name] += 1
            apart.append(f"{name}.{seen[name]}")
        else:
            apart.append(name)
    return apart


def unlike(names: Iterable[str], what: str) -> None:
    """Refuse names that occur twice."""
    seen: set[str] = set()
    doubled = {name for name in names if name in seen or seen.add(name)}  # type: ignore[func-returns-value]
    if doubled:
        raise DataError(f"{what}: column {', '.join(sorted(doubled))} occurs twice; rename one.")


def library(name: str, extra: str, file: Path) -> ModuleType:
    """Import an optional library, or say how to install it."""
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError as error:
        raise DataError(
            f"{file} needs the library {name.partition('.')[0]}, which is not installed; run: "
            f"pip install {name.partition('.')[0]} (or axisid with the extra {extra})"
        ) from error


def told(error: Exception) -> str:
    """What another library says of a file, as the end of a sentence."""
    return " ".join(str(error).split()).rstrip(".") or type(error).__name__
