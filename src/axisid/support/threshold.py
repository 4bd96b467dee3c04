"""A number by which something is judged, with its unit and its source."""

from dataclasses import dataclass
from typing import Generic, TypeVar

Number = TypeVar("Number", int, float)


@dataclass(frozen=True, slots=True)
class Threshold(Generic[Number]):
    """A number by which a check passes, a note is written, or a log or a program is refused.

    Attributes
    ----------
    value : int or float
        An int if something is counted.
    unit : str
        ``"1"`` for a ratio or a share; `meaning` then states of what.
    meaning : str
        What is judged by the number, as the end of a sentence.
    source : str
        Where the number comes from: a key of the bibliography in brackets, ``"measured: ..."``,
        ``"derived: ..."``, ``"convention"``, or ``"chosen"`` if nothing more is known.
    """

    value: Number
    unit: str
    meaning: str
    source: str
