"""One log of a fleet, before it is read, and the name of its result."""

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

Condition = str | float


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetItem:
    """A log and what is said of it; never its samples, so that it can be sent anywhere.

    Attributes
    ----------
    log : str
        Path of the file.
    axis : str
        Name in the library, or file that declares it; empty for the fleet's.
    serial : str
        Which machine it is of; empty where nothing says so.
    columns : mapping of str to str
        Columns of this log by role, in place of those of all.
    conditions : mapping of str to str or float
        What else is known of the log: a temperature, a date. It goes on into the table.
    """

    log: str
    axis: str = ""
    serial: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, Condition] = field(default_factory=dict)

    @property
    def columns_text(self) -> str:
        """The columns in an order of their own, the same where they are the same."""
        return ",".join(f"{role}={name}" for role, name in sorted(self.columns.items()))


def result_names(items: Sequence[FleetItem]) -> list[str]:
    """Names of the items' results: those of the logs, with a mark where two have the same."""
    plain = [Path(item.log).name.partition(".")[0] or "log" for item in items]
    times = Counter(name.lower() for name in plain)  # some file systems know no case
    marked = [
        name if times[name.lower()] == 1 else f"{name}-{_mark(item)}"
        for name, item in zip(plain, items, strict=True)
    ]
    return list(_apart(marked))


def _mark(item: FleetItem) -> str:
    """Of a log, its axis and its columns, the same in every run."""
    told = "\0".join(filter(None, (f"{item.log}\0{item.axis}", item.columns_text)))
    return hashlib.sha256(told.encode(errors="replace")).hexdigest()[:8]


def _apart(names: list[str]) -> list[str]:
    """Names with a number where the same log stands there again."""
    seen: Counter[str] = Counter()
    told = []
    for name in names:
        seen[name.lower()] += 1
        number = seen[name.lower()]
        told.append(name if number == 1 else f"{name}-{number}")
    return told
