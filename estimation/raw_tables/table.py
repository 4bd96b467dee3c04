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
