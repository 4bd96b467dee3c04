"""What a file holds before any column has a role: names, units as written, and what was assumed."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

from axisid.support.arrays import Array
from axisid.support.errors import DataError

from .provenance import Repair

_LISTED = 40
_LONGEST = 200  # of what another library says


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
        What was assumed of it, a sentence with its name, told where it is chosen.
    number : int
        Its place in the file from 1, columns that hold no numbers among them; 0 where the places
        are those of the table.
    texts : sequence of str
        Its cells, where it holds text.
    """

    read: Callable[[], Samples]
    unit: str = ""
    label: str = ""
    note: str = ""
    number: int = 0
    texts: Sequence[str] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The columns of a file.

    Attributes
    ----------
    source : str
        The file as it was given, for messages.
    columns : mapping of str to Column
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
    passed_over : mapping of str to str
        What is no column, by its name: what it holds.
    texts : mapping of str to sequence of str
        Cells of the columns that hold text, by name.
    warnings : tuple of str
        What the library that read the file says is wrong with it.
    incomplete : int
        Rows at its end that look cut off, and were not to be left out.
    """

    source: str
    columns: Mapping[str, Column]
    notes: tuple[str, ...] = ()
    repairs: tuple[Repair, ...] = ()
    sha256: str = ""
    path: str = ""
    missing: str = field(default="", repr=False)
    passed_over: Mapping[str, str] = field(default_factory=dict, repr=False)
    texts: Mapping[str, Sequence[str]] = field(default_factory=dict, repr=False)
    warnings: tuple[str, ...] = ()
    incomplete: int = 0

    def find(self, name: str) -> str | None:
        """The column of a name: its own, its label, or the last parts of one dotted name alone."""
        alike = self.alike(name)
        return alike[0] if len(alike) == 1 else None

    def holds(self, name: str) -> str:
        """What has a name like a column's, but holds no numbers; empty if there is nothing."""
        alike = [name] if name in self.passed_over else _ending(name, self.passed_over)
        return self.passed_over[alike[0]] if len(alike) == 1 else ""

    def alike(self, name: str) -> list[str]:
        """The columns that a name may stand for."""
        if name in self.columns:
            return [name]
        labelled = [own for own, column in self.columns.items() if column.label == name]
        return labelled or _ending(name, self.columns) or self._numbered(name)

    def _numbered(self, name: str) -> list[str]:
        """The column of a number such as ``#3``."""
        match = re.fullmatch(r"#([1-9]\d{0,5})", name)
        places = {
            column.number or place: own
            for place, (own, column) in enumerate(self.columns.items() if match else (), 1)
        }
        return [places[int(match[1])]] if match and int(match[1]) in places else []

    def listed(self) -> str:
        """Names of the columns, for messages."""
        names = list(self.columns)
        more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
        return (", ".join(names[:_LISTED]) or "no columns") + more


def _ending(name: str, names: Iterable[str]) -> list[str]:
    """The dotted names that end in a name."""
    return [own for own in names if own.endswith(f".{name}")]


def loaded_column(
    values: Array, *, unit: str = "", label: str = "", clock: Array | None = None, note: str = ""
) -> Column:
    """A column whose values are already in memory."""
    samples = Samples(values=values, clock=clock)
    return Column(read=lambda: samples, unit=unit, label=label, note=note)


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
    said = " ".join(plain.split()).rstrip(".") or type(error).__name__
    return said if len(said) <= _LONGEST else f"{said[:_LONGEST]} ..."
