"""One check of a result: a figure held against a threshold, and what it means."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from axisid.support.missing import Missing
from axisid.support.number_text import plain_numbers
from axisid.support.remedy import Note, Remedy

from .faults import Fault, unless_faulty
from .kinds import kind_of

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
        One sentence for the user, up to the remedy where there is one.
    remedy : Remedy or None
        How it goes on, where something can be set about it.
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
    remedy: Remedy | None = None
    figure: float | None = None
    threshold: float | None = None
    p_value: float | None = None
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "meaning", plain_numbers(self.meaning))

    @classmethod
    def not_evaluated(cls, name: str, missing: Missing) -> "Check":
        """A check that could not be made, as a verdict lists it; by a fault it fails."""
        status: Status = "fail" if isinstance(missing, Fault) else "not evaluated"
        return cls(name=name, status=status, meaning=missing.reason, remedy=missing.remedy)

    @classmethod
    def unless(
        cls,
        name: str,
        fault: Note | str | None,
        held: str = "",
        figure: float | None = None,
        most: float | None = None,
        *,
        matters: bool = True,
    ) -> "Check":
        """A check that fails by a fault, where there is one; else it says what holds."""
        said = Note.of(fault or held)
        return cls(
            name=name,
            status=passed(not fault, matters=matters),
            meaning=said.text,
            remedy=said.remedy,
            figure=figure,
            threshold=most,
        )

    @property
    def line(self) -> str:
        """The line of a verdict that it is of, as `KINDS` has it."""
        return kind_of(self.name).line

    @property
    def note(self) -> Note:
        """The whole sentence, to be worded later."""
        return Note(self.meaning, self.remedy)


def made(name: str, find: Callable[[], Check | Missing | None]) -> Check | None:
    """A check as a verdict lists it: what is found, why it could not be made, or nothing."""
    found = unless_faulty(find)
    return Check.not_evaluated(name, found) if isinstance(found, Missing) else found


def passed(good: bool, *, matters: bool = True) -> Status:
    """Status of a check that was made; `matters` tells whether the numbers suffer."""
    return "pass" if good else "fail" if matters else "note"
