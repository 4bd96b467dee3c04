"""What is worked out once for each record that is alive, and asked for in every iteration."""

import weakref
from collections.abc import Hashable
from functools import partial
from typing import Generic, TypeVar

from axisid.estimation.records import Record

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class KeptByRecord(Generic[K, V]):
    """What is known of records, by their identity, as long as they live."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[weakref.ref[Record], dict[K, V]]] = {}

    def of(self, record: Record) -> dict[K, V]:
        """What is known of a record, to be added to."""
        found = self._known.get(id(record))
        if found is None:
            alive = weakref.ref(record, partial(self._forget, id(record)))
            found = self._known[id(record)] = (alive, {})
        return found[1]

    def __len__(self) -> int:
        return len(self._known)

    def _forget(self, record: int, _: object) -> None:
        self._known.pop(record, None)
