"""Content of a file before columns have roles: names, units as written, assumptions."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array
from axisid.support.errors import DataError

from .provenance import Repair


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Values of a column, with its sampling times if the log has times for each column.

    Attributes
    ----------
    values : (N,) array
        Values in the unit of the file, in SI for a column with a role; NaN for an empty cell.
    clock : (N,) array or None
        Sampling times, s. Columns with the same times share one array. None if the log has no times
        for this column, or has a time column.
    """

    values: Array
    clock: Array | None = None

    @property
    def times(self) -> Array:
        """Sampling times, s, or the numbers of the samples from 0 without times, (N,)."""
        return np.arange(float(len(self.values))) if self.clock is None else self.clock

    def taken(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> "Samples":
        """Return some of the samples with their times; `rows` are their numbers, or a mask."""
        clock = None if self.clock is None else self.clock[rows]
        return Samples(values=self.values[rows], clock=clock)


@dataclass(frozen=True, slots=True, kw_only=True)
class RawColumn:
    """A column of a file.

    Attributes
    ----------
    samples : Samples or DataError
        Samples, or the error of a column without numbers, which is raised when it is used.
    unit : str
        Unit as in the file; empty for none.
    label : str
        Name and unit as in the file, if the name was taken from them; otherwise empty.
    note : str
        Assumption about the column with the name of the column, reported if the column is used;
        empty for none.
    holds : str
        Content of a column that cannot be used, such as ``text``; otherwise empty.
    """

    samples: Samples | DataError
    unit: str = ""
    label: str = ""
    note: str = ""
    holds: str = ""

    def read(self) -> Samples:
        """Return the samples; raise the `DataError` of a column without numbers."""
        if isinstance(self.samples, DataError):
            raise self.samples
        return self.samples


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Columns of a log by name.

    Attributes
    ----------
    source : str
        File as the user gave it, or a description of a log in memory, for messages.
    columns : mapping of str to RawColumn
        Columns by unique names, in the order of the log.
    notes : tuple of str
        Assumptions about the file: separator, encoding, ignored lines.
    repairs : tuple of Repair
        Reports of lines at the end that were left out: a line that is truncated in its last number,
        and incomplete lines on request.
    sha256 : str
        SHA-256 of the file; empty without a file.
    path : str
        Absolute path of the file; empty without a file.
    missing : str
        Advice if a column is not found, such as how to save variables that cannot be read; empty
        for none.
    warnings : tuple of str
        Faults of the file that the library reported while reading it.
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
        """Return the column that a name stands for, see `alike`; None for no or several columns."""
        alike = self.alike(name)
        return alike[0] if len(alike) == 1 else None

    def alike(self, name: str) -> list[str]:
        """Return the names of the columns that a name may stand for.

        That is the column of this name. If there is none, the columns with this label; or else the
        columns whose dotted names end with this name; or else the column of this number (``#3``).
        """
        if name in self.columns:
            return [name]
        labelled = [key for key, column in self.columns.items() if column.label == name]
        ending = [key for key in self.columns if key.endswith(f".{name}")]
        place = re.fullmatch(r"#([1-9]\d{0,5})", name)
        numbered = [*self.columns][int(place[1]) - 1 : int(place[1])] if place else []
        return labelled or ending or numbered

    def listed(self) -> str:
        """Return a text with the names of the first 40 columns that have numbers, for messages."""
        names = [name for name, column in self.columns.items() if not column.holds]
        more = f" and {len(names) - 40} more" if len(names) > 40 else ""
        return (", ".join(names[:40]) or "no columns") + more


def numbered(names: Sequence[str]) -> list[str]:
    """Return unique names of columns; repeated names are numbered from 1: ``Time.1``, ``Time.2``.

    A repeated name without a number is ambiguous, and is refused when a column is looked for.
    """
    times, seen, unique = Counter(names), Counter[str](), []
    for name in names:
        unique_name = name
        while name and times[name] > 1 and unique_name in times:
            seen[name] += 1
            unique_name = f"{name}.{seen[name]}"
        unique.append(unique_name)
    return unique
