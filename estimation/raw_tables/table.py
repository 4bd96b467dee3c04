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
    """Values of a column, (N,), with their sampling times, if the column has its own.

    Attributes
    ----------
    values : (N,) array
        Values in the unit of the file; NaN for an empty cell.
    clock : (N,) array or None
        Sampling times, s. Columns with the same times share one array.
    """

    values: Array
    clock: Array | None = None

    @property
    def times(self) -> Array:
        """The sampling times, or the numbers of the samples if there are none, (N,)."""
        return np.arange(float(len(self.values))) if self.clock is None else self.clock

    def taken(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> "Samples":
        """Return some of the samples, by their numbers or a mask, with their times."""
        clock = None if self.clock is None else self.clock[rows]
        return Samples(values=self.values[rows], clock=clock)


@dataclass(frozen=True, slots=True, kw_only=True)
class RawColumn:
    """A column of a file.

    Attributes
    ----------
    samples : Samples or DataError
        The samples, or the error of a column without numbers.
    unit : str
        Unit as in the file; empty for none.
    label : str
        Name and unit as in the file, if the name was taken from them; otherwise empty.
    note : str
        Assumption about the column, a sentence with its name, reported if the column is used.
    holds : str
        Content of a column without numbers, which cannot be used; otherwise empty.
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
    """The columns of a file.

    Attributes
    ----------
    source : str
        The file as it was given, for messages.
    columns : mapping of str to RawColumn
    notes : tuple of str
        What was assumed of the file: separator, encoding, rows that were passed over.
    repairs : tuple of Repair
        Rows at the end that were left out: one that ends inside its last number, more on request.
    sha256 : str
        SHA-256 of the file; empty without a file.
    path : str
        Absolute path of the file; empty without a file.
    missing : str
        Advice if a column is not found, such as how to save variables that cannot be read.
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
        """Return the only column that a name may stand for, see `alike`; None otherwise."""
        alike = self.alike(name)
        return alike[0] if len(alike) == 1 else None

    def alike(self, name: str) -> list[str]:
        """Return the columns that a name may stand for.

        By its name; or else its label, the last parts of its dotted name, or its number (``#3``).
        """
        if name in self.columns:
            return [name]
        labelled = [own for own, column in self.columns.items() if column.label == name]
        ending = [own for own in self.columns if own.endswith(f".{name}")]
        place = re.fullmatch(r"#([1-9]\d{0,5})", name)
        numbered = [*self.columns][int(place[1]) - 1 : int(place[1])] if place else []
        return labelled or ending or numbered

    def listed(self) -> str:
        """Return the names of the columns, for messages."""
        names = [name for name, column in self.columns.items() if not column.holds]
        more = f" and {len(names) - 40} more" if len(names) > 40 else ""
        return (", ".join(names[:40]) or "no columns") + more


def numbered(names: Sequence[str]) -> list[str]:
    """Return names of columns, with repeated ones numbered from 1: ``Time.1``, ``Time.2``.

    The name without a number is then ambiguous and refused.
    """
    times, seen, unique = Counter(names), Counter[str](), []
    for name in names:
        unique_name = name
        while name and times[name] > 1 and unique_name in times:
            seen[name] += 1
            unique_name = f"{name}.{seen[name]}"
        unique.append(unique_name)
    return unique
