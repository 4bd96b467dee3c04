"""What is pickled of objects that compute some of what they tell when it is asked for."""

from dataclasses import fields
from typing import Any


class Uncached:
    """A dataclass that is pickled by its fields, without what was computed of them."""

    __slots__ = ()

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]
