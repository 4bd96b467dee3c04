"""One check of a result: a figure held against a threshold, and what it means."""

from dataclasses import dataclass
from typing import Literal

Status = Literal["pass", "note", "fail", "not evaluated"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One check of a result.

    Attributes
    ----------
    name : str
    status : {"pass", "note", "fail", "not evaluated"}
        A note is beyond its threshold as well, but what is printed allows for it.
    meaning : str
        One sentence for the user.
    figure : float or None
        What was measured.
    threshold : float or None
        What it is held against.
    p_value : float or None
    source : str
        Where the threshold comes from.
    """

    name: str
    status: Status
    meaning: str
    figure: float | None = None
    threshold: float | None = None
    p_value: float | None = None
    source: str = ""

    @classmethod
    def missing(cls, name: str, why: str) -> "Check":
        """A check that could not be made."""
        return cls(name=name, status="not evaluated", meaning=why)


def passed(good: bool, *, matters: bool = True) -> Status:
    """Status of a check that was made; `matters` tells whether the numbers suffer."""
    return "pass" if good else "fail" if matters else "note"
