"""A threshold of a decision, with its unit and its source."""

from dataclasses import dataclass
from typing import Generic, TypeVar

Number = TypeVar("Number", int, float)


@dataclass(frozen=True, slots=True)
class Threshold(Generic[Number]):
    """Threshold that decides whether a check passes, a note is written or an input is refused.

    Attributes
    ----------
    value : int or float
        An int for a count.
    unit : str
        ``"1"`` for a ratio or a share; `meaning` then names the reference quantity.
    meaning : str
        Decision that depends on the value, as the end of a sentence.
    source : str
        Origin of the value: a key of the bibliography in brackets, ``"measured: ..."``,
        ``"derived: ..."``, ``"convention"``, or ``"chosen"`` if nothing more is known.
    """

    value: Number
    unit: str
    meaning: str
    source: str
