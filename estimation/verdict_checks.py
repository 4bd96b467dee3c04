"""One check of a result: a figure held against a threshold, and what it means; what several do.

In: a figure, what it is held against, what that means. Out: `Check`. Knows nothing of what is
checked.

`KINDS` has every check of the program: the line of a verdict that it is told under, and its weight.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Annotated, Literal, Protocol, TypeVar

from msgspec import Meta

from axisid.estimation.thresholds import CHECK_LEVEL, LEAST_SHARE
from axisid.support.errors import (
    AxisidError,
    CandidateError,
    Found,
    Missing,
    UsageError,
    asks_for_tracebacks,
    first_case,
    is_real,
    plain_numbers,
    quoted,
)

#: How far the numbers of a result can be believed.
Belief = Literal["believed", "with care", "not believed"]
Status = Literal["pass", "note", "fail", "not evaluated"]


Else = TypeVar("Else")
WORST_FIRST: tuple[Status, ...] = ("fail", "note", "pass")


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """From when on a check tells something of a model.

    Attributes
    ----------
    level : float
        Chance that anything is told of a right one, over all that is looked for.
    least_share : float
        Part of the force, or of a parameter's value, from which it matters; what is missing does
        too where it moves a parameter by more than its interval.

    Raises
    ------
    UsageError
        One of them is not between 0 and 1.
    """

    level: Annotated[float, Meta(gt=0, lt=1)] = CHECK_LEVEL.value
    least_share: Annotated[float, Meta(gt=0, lt=1)] = LEAST_SHARE.value

    def __post_init__(self) -> None:
        for each in fields(self):
            given = getattr(self, each.name)
            if not (is_real(given) and 0 < float(given) < 1):
                raise UsageError(
                    f"the {each.name.replace('_', ' ')} is {quoted(given)}; give a number between "
                    f"0 and 1, such as {each.default:g}.",
                    code="method",
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
        One sentence for the user: what is found, and what can be done about it.
    figure : float or None
        What was measured.
    threshold : float or None
        What it is held against.
    p_value : float or None
    source : str
        Where the threshold comes from.
    leaves_open : bool
        Whether the numbers rest on something that this check could not test, in any record.
    """

    name: str
    status: Status
    meaning: str
    figure: float | None = None
    threshold: float | None = None
    p_value: float | None = None
    source: str = ""
    leaves_open: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "meaning", plain_numbers(self.meaning))

    @classmethod
    def not_evaluated(cls, name: str, missing: Missing) -> "Check":
        """A check that could not be made, as a verdict lists it; by a fault it fails.

        It leaves something open where its kind has a `remedy`, unless the result does not use what
        the check is of.
        """
        status: Status = "fail" if isinstance(missing, Fault) else "not evaluated"
        leaves_open = bool(kind_of(name).remedy) and not isinstance(missing, NotUsed)
        return cls(name=name, status=status, meaning=missing.reason, leaves_open=leaves_open)

    @classmethod
    def unless(
        cls,
        name: str,
        fault: str | None,
        held: str = "",
        figure: float | None = None,
        most: float | None = None,
        *,
        matters: bool = True,
    ) -> "Check":
        """A check that fails by a fault, where there is one; else it says what holds."""
        return cls(
            name=name,
            status=status_of(not fault, matters=matters),
            meaning=fault or held,
            figure=figure,
            threshold=most,
        )

    @property
    def line(self) -> str:
        """The line of a verdict that it is of, as `KINDS` has it."""
        return kind_of(self.name).line


def made(name: str, find: Callable[[], Check | Missing | None]) -> Check | None:
    """A check as a verdict lists it: what is found, why it could not be made, or nothing."""
    found = unless_faulty(find)
    return Check.not_evaluated(name, found) if isinstance(found, Missing) else found


def status_of(good: bool, *, matters: bool = True) -> Status:
    """Status of a check that was made; `matters` tells whether the numbers suffer."""
    return "pass" if good else "fail" if matters else "note"


@dataclass(frozen=True, slots=True)
class Fault(Missing):
    """What stands in place of something by whose search the program faulted."""


@dataclass(frozen=True, slots=True)
class NotUsed(Missing):
    """Why something was not checked that the result does not use, as a law without a loop."""


def unless_faulty(find: Callable[[], Found]) -> Found | Missing:
    """What a check finds, or why it could not be made, whatever it raises.

    A fault is raised where tracebacks are asked for; want of memory is no fault of a check. A
    user's own candidate that fails leaves open what the others would find, as a fault does.

    Parameters
    ----------
    find : callable
    """
    try:
        return find()
    except AxisidError as error:
        return (Fault if isinstance(error, CandidateError) else Missing)(str(error))
    except MemoryError:
        raise
    except Exception as fault:
        if asks_for_tracebacks():
            raise
        said = f"{type(fault).__name__}: {fault}".rstrip(": ")
        return Fault(f"it could not be made, by a fault ({said}): please report it")


def value_or(otherwise: Else, find: Callable[[], Found | Missing]) -> Found | Else:
    """What a check measures, or what stands for nothing where it could not be measured."""
    found = unless_faulty(find)
    return otherwise if isinstance(found, Missing) else found


def joined(found: Sequence[Check | None], records: Sequence[str]) -> Check | None:
    """The worst of the checks, with the records that it is of; that of one record as it is.

    Parameters
    ----------
    found : sequence of Check or None
        By record, as a diagnostic gives them.
    records : sequence of str
        Their names.
    """
    if len(records) == 1:
        return found[0]
    every = [(name, each) for name, each in zip(records, found, strict=True) if each is not None]
    unmade = [name for name, each in every if each.status == "not evaluated"]
    leaves_open = any(each.leaves_open for _, each in every)
    if len(unmade) == len(every):
        return replace(every[0][1], leaves_open=leaves_open) if every else None
    status = next(s for s in WORST_FIRST if any(each.status == s for _, each in every))
    worst = [(name, each) for name, each in every if each.status == status]
    first = replace(max((each for _, each in worst), key=_distance), leaves_open=leaves_open)
    if status == "pass":
        more = f" (not evaluated of {_listed(unmade)})" * bool(unmade)
        return replace(first, meaning=first.meaning + more)
    same = [name for name, each in worst if each.meaning == first.meaning]
    others = _listed([name for name, _ in worst if name not in same])
    more = f"; it {'fails' if status == 'fail' else 'is noted'} of {others} too" * bool(others)
    return replace(first, meaning=f"{' and '.join(same)}: {first.meaning}{more}")


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def _distance(check: Check) -> float:
    """How far a figure is beyond its threshold, whichever side is bad; 0 where it has none."""
    if check.figure is None or not check.threshold:
        return 0.0
    ratio = abs(check.figure / check.threshold)
    return max(ratio, 1 / ratio) if ratio else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """What a check of one name is in every verdict that has it.

    Attributes
    ----------
    line : str
        What a verdict answers by it: is the control the declared law's; is everything logged at
        its time; does the simulated loop do what the record does; is something missing in the
        model; are there outliers; does the record show every parameter; are the records of one
        machine; and do the methods agree.
    rank : int
        Its place among those that fail, the cause before what follows from it.
    grave : bool
        Whether the numbers may mean something else than what they are called where it fails.
    remedy : str
        What makes it possible where it could not be made, as an instruction; empty where numbers
        can be relied on without it.
    """

    line: str
    rank: int = 100
    grave: bool = False
    remedy: str = ""


#: By name, line by line.
KINDS: dict[str, Kind] = {
    "control law": Kind(
        line="law",
        rank=0,
        grave=True,
        remedy="log the reference, the position and the control at each evaluation of the control "
        "law, with all their digits, during a motion within the drive's limit",
    ),
    "law's factors": Kind(line="law"),
    "exact law": Kind(line="law"),
    "noise gain": Kind(line="law", rank=1, grave=True),
    "force against control": Kind(line="law", rank=5, grave=True),
    "drive gain": Kind(line="law"),
    "time base": Kind(line="timing", rank=0, grave=True),
    "sudden steps": Kind(line="timing", rank=0, grave=True),
    "sample period": Kind(line="timing"),
    "alignment": Kind(line="timing", rank=8),
    "recorded signals": Kind(line="timing", rank=2, grave=True),
    "simulation": Kind(line="loop", rank=2, grave=True, remedy="log the reference"),
    "windows": Kind(line="loop", rank=2, grave=True),
    "measured velocity": Kind(line="loop", rank=1, grave=True),
    "measured acceleration": Kind(line="loop", rank=1, grave=True),
    "control against limit": Kind(line="loop", rank=6, grave=True),
    "noise in the loop": Kind(
        line="loop",
        remedy="log the control or the force, and record a longer motion",
    ),
    "samples near rests": Kind(line="loop"),
    "equation error": Kind(line="model", rank=3, grave=True),
    "missing terms": Kind(
        line="model",
        rank=8,
        remedy="log the control or the force during a longer motion, or validate the result with "
        "another record",
    ),
    "fixed values": Kind(line="model", rank=4, grave=True),
    "what was known": Kind(line="model", rank=4, grave=True),
    "moved parameters": Kind(line="model", rank=9, grave=True),
    "lack of fit": Kind(line="model"),
    "outliers": Kind(line="outliers", rank=1),
    "parameters shown": Kind(line="precision", rank=3, grave=True),
    "bounds": Kind(line="precision", rank=3, grave=True),
    "rows": Kind(line="precision"),
    "convergence": Kind(line="precision"),
    "starts": Kind(line="precision"),
    "precision": Kind(line="precision", rank=13),
    "nominal values": Kind(line="precision"),
    "physical parameters": Kind(line="precision", rank=10),
    "records alike": Kind(line="records", rank=8, grave=True),
    "repeated records": Kind(line="records", rank=10),
    "instrument strength": Kind(line="method", rank=12),
    "method": Kind(line="method", rank=14),
    "inverse against direct": Kind(line="method", rank=5, grave=True),
    "validation": Kind(line="validation", rank=7),
    "result": Kind(line="result", rank=0, grave=True),
}


def kind_of(check: str) -> Kind:
    """What a check is; one that no row names is told by itself, and last."""
    return KINDS.get(check) or Kind(line=check)


def lines_of(checks: Iterable[str]) -> tuple[str, ...]:
    """The lines of checks, each once, in the order of the checks."""
    return tuple(dict.fromkeys(kind_of(check).line for check in checks))


#: Checks that a verdict names where they could not be made.
_NAMED = ("missing terms", "control law", "simulation", "noise in the loop", "method")


def conclusion(checks: Sequence[Check]) -> str:
    """Whether the numbers can be used, what speaks against them, and what was not checked.

    What the numbers rest on and was not checked is named with what makes it possible to check.
    """
    failed = [check for check in by_weight(checks) if check.status == "fail"]
    lines = lines_of(check.name for check in failed)
    # What is serious, and what comes before it, of which it may be a consequence.
    grave = [i for i, check in enumerate(failed) if kind_of(check.name).grave]
    first = lines_of(check.name for check in failed[: min(grave, default=0) + 1])
    skipped = {check.name for check in checks if check.status == "not evaluated"}
    left_open = {check.name for check in checks if check.leaves_open}
    # Another check of the same line failed, or nothing simulates a loop beside its law.
    of_no_matter = {*lines, "loop"}
    unchecked = lines_of(
        name
        for name in dict.fromkeys((*_NAMED, *left_open))
        if name in left_open or (name in skipped and kind_of(name).line not in of_no_matter)
    )
    how = belief(checks)
    said = first_case(
        (
            how == "not believed",
            f"Do not use these numbers. Correct this first: {', '.join(first)}.",
        ),
        (failed, f"Use with care. Failed checks: {', '.join(lines)}."),
        (how == "with care", "Use with care."),
        (unchecked, "All checks that were made passed."),
        (True, "All checks passed."),
    )
    if how == "not believed" or not unchecked:
        return said
    remedies = [
        f" To check the {kind.line}, {kind.remedy}."
        for name, kind in KINDS.items()
        if name in left_open
    ]
    return f"{said} Not checked: {', '.join(unchecked)}.{''.join(remedies)}"


def belief(checks: Iterable[Check]) -> Belief:
    """How far the numbers of a result can be believed.

    They are not believed where any serious check fails, whatever else fails. They are to be used
    with care where another check fails, or where something that they rest on could not be checked.
    """
    found: Belief = "believed"
    for check in checks:
        failed = check.status == "fail"
        if failed and kind_of(check.name).grave:
            return "not believed"
        if failed or check.leaves_open:
            found = "with care"
    return found


class _HasChecks(Protocol):
    @property
    def checks(self) -> tuple[Check, ...]: ...


class Checked:
    """A result with `checks`, which say what it is worth."""

    __slots__ = ()

    @property
    def belief(self: _HasChecks) -> Belief:
        """How far the numbers can be believed: "believed", "with care", "not believed"."""
        return belief(self.checks)

    @property
    def believed(self: _HasChecks) -> bool:
        """Whether no check fails, and nothing that the numbers rest on was left unchecked."""
        return belief(self.checks) == "believed"


def by_weight(checks: Sequence[Check]) -> list[Check]:
    """Checks by what it means for the numbers that they fail, the gravest first."""
    return sorted(checks, key=lambda check: kind_of(check.name).rank)
