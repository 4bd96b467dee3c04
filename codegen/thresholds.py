"""The numbers by which generated code is refused: each once, with its unit and its source.

In: nothing. Out: `Threshold` and rows of it; the documentation prints them with those of
`axisid.estimation.thresholds`, which are rows of the same. Knows nothing of who judges by them.
"""

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


MAX_CONTROL_DIFFERENCE = Threshold(
    1e-9,
    "1",
    "difference of a control from what a drive's inverse makes of its force, as a share of the "
    "largest control, up to which the inverse undoes the force",
    "chosen: an inverse may cancel",
)
