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
        An int where something is counted.
    unit : str
        ``"1"`` for a ratio or a share, whose meaning says of what.
    meaning : str
        What is judged by it, as the end of a sentence.
    source : str
        Where the number comes from: a key of the bibliography in brackets, ``"measured: ..."``,
        ``"derived: ..."``, ``"convention"``, or ``"chosen"`` where nothing more is known.
    """

    value: Number
    unit: str
    meaning: str
    source: str
