"""Checks of columns of several formats: unique names, and no truth values among numbers."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from axisid.estimation.raw_tables import twice


def once(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Return the values by name, from pairs of a name and a value; refuse a repeated name.

    Raises
    ------
    DataError
        A name occurs twice.
    """
    listed = [*pairs]
    found = dict(listed)
    if len(found) < len(listed):
        counts = Counter(name for name, _ in listed)
        raise twice(next(name for name, count in counts.items() if count > 1))
    return found


#: Content of a column with truth values among its numbers, which cannot be used; for messages.
MIXED_TRUTHS = "true or false among numbers"


def has_mixed_truths(cells: Sequence[Any]) -> bool:
    """Return True if some cells of a column, but not all, are true or false."""
    there = [cell for cell in cells if cell is not None]
    truths = sum(isinstance(cell, (bool, np.bool_)) for cell in there)
    return 0 < truths < len(there)
