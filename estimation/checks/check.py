"""One check of a result: a figure held against a threshold, and what it means; its two levels."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Literal, TypeVar

from axisid.estimation.thresholds import LEAST_SHARE, LEVEL
from axisid.support.errors import AxisidError, UsageError, asks_for_tracebacks
from axisid.support.missing import Missing
from axisid.support.number_text import plain_numbers
from axisid.support.real_numbers import is_real
from axisid.support.remedy import Note, Remedy
from axisid.support.user_values import quoted

from .kinds import kind_of

Status = Literal["pass", "note", "fail", "not evaluated"]

Found = TypeVar("Found")
Else = TypeVar("Else")
_WORST: tuple[Status, ...] = ("fail", "note", "pass")
_UNMADE: Status = "not evaluated"


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """From when on a check tells something of a model.

    Attributes
    ----------
    level : float
        Chance that it does of a right model, over all that it looks for.
    least_share : float
        Part of the force, or of a parameter's value, from which it matters; what is missing does
        too where it moves a parameter by more than its interval.

    Raises
    ------
    UsageError
        One of them is not between 0 and 1.
    """

    level: float = LEVEL.value
    least_share: float = LEAST_SHARE.value

    def __post_init__(self) -> None:
        for each in fields(self):
            given = getattr(self, each.name)
            if not (is_real(given) and 0 < float(given) < 1):
                raise UsageError(
                    f"the {each.name.replace('_', ' ')} is {quoted(given)}; give a number between "
                    f"0 and 1, such as {each.default:g}.",
                    code="level",
                )


DEFAULT_LEVELS = Levels()


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


@dataclass(frozen=True, slots=True)
class Fault(Missing):
    """What stands in place of something by whose search the program faulted."""


def unless_faulty(find: Callable[[], Found]) -> Found | Missing:
    """What a check finds, or why it could not be made, whatever it raises.

    A fault is raised where tracebacks are asked for; want of memory is no fault of a check.

    Parameters
    ----------
    find : callable
    """
    try:
        return find()
    except AxisidError as error:
        return Missing.of(error.note)
    except MemoryError:
        raise
    except Exception as fault:
        if asks_for_tracebacks():
            raise
        said = f"{type(fault).__name__}: {fault}".rstrip(": ")
        return Fault(f"it could not be made, by a fault ({said}): please report it")


def told_or(otherwise: Else, find: Callable[[], Found | Missing]) -> Found | Else:
    """What a check measures, or what stands for nothing where it could not be measured."""
    found = unless_faulty(find)
    return otherwise if isinstance(found, Missing) else found


def joined(found: Sequence[Check | None], records: Sequence[str]) -> Check | None:
    """The worst of the checks, with the records that it is of.

    Parameters
    ----------
    found : sequence of Check or None
        By record, as a diagnostic gives them.
    records : sequence of str
        Their names.
    """
    every = [(name, each) for name, each in zip(records, found, strict=True) if each is not None]
    made = [(name, each) for name, each in every if each.status != _UNMADE]
    if not made:
        return every[0][1] if every else None
    status = next(s for s in _WORST if any(each.status == s for _, each in made))
    worst = [(n, each) for n, each in made if each.status == status]
    first = max((each for _, each in worst), key=_distance)
    if status == "pass":
        unmade = [name for name, each in every if each.status == _UNMADE]
        return _worded(first, "", f" (not evaluated of {_listed(unmade)})") if unmade else first
    same = [n for n, each in worst if each.meaning == first.meaning]
    others = [n for n, each in worst if n not in same]
    also = "fails" if status == "fail" else "is noted"
    more = f"; it {also} of {_listed(others)} too" if others else ""
    return _worded(first, f"{' and '.join(same)}: ", more)


def _worded(check: Check, before: str, after: str) -> Check:
    note = check.note
    remedy = note.remedy
    if after:
        remedy = None if remedy is None else Remedy.of(remedy, after)
    said = Note(before + note.text + ("" if remedy else after), remedy)
    return replace(check, meaning=said.text, remedy=said.remedy)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _distance(check: Check) -> float:
    """How far a figure is beyond its threshold, whichever side is bad; 0 where it has none."""
    if check.figure is None or not check.threshold:
        return 0.0
    ratio = abs(check.figure / check.threshold)
    return max(ratio, 1 / ratio) if ratio else 0.0
