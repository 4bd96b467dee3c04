"""One check of a result: a figure, its threshold and a finding; and the conclusion from several.

In: a figure, its threshold, a finding. Out: `Check`, `Conclusion`. Knows nothing of the subject of
a check.

`KINDS` has every check of the program: its line of a verdict, and its weight.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Annotated, Literal, Protocol, TypeVar

from msgspec import Meta

from axisid.estimation.findings import (
    FaultOfCheck,
    Finding,
    FindingExceptFor,
    FindingOfRecords,
    ReadFinding,
    Said,
)
from axisid.estimation.thresholds import CHECK_LEVEL, LEAST_SHARE
from axisid.support.checks import is_real
from axisid.support.errors import AxisidError, CandidateError, UsageError, asks_for_tracebacks
from axisid.support.missing import Found, Missing
from axisid.support.wording import quoted

#: How far the estimates of a result can be used.
Belief = Literal["believed", "with care", "not believed"]
Status = Literal["pass", "note", "fail", "not evaluated"]


Else = TypeVar("Else")
WORST_FIRST: tuple[Status, ...] = ("fail", "note", "pass")


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """Thresholds above which a model error is reported.

    Attributes
    ----------
    level : float
        Probability that any error of a correct model is reported, over all hypotheses.
    least_share : float
        Part of the force, or of a parameter's value, from which an error is relevant. A missing
        term is relevant too where it moves a parameter by more than half the width of its interval.

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
        A note is beyond its threshold as well, but the printed numbers allow for it.
    finding : Finding
        Result of the check as data.
    figure : float or None
        The measured quantity.
    threshold : float or None
        Threshold of the figure.
    p_value : float or None
    source : str
        Definition of the figure with its unit, and the condition under which the check fails, or
        the origin of the threshold.
    leaves_open : bool
        Whether the numbers rely on something that this check could not test, in any record.
    """

    name: str
    status: Status
    finding: Finding
    figure: float | None = None
    threshold: float | None = None
    p_value: float | None = None
    source: str = ""
    leaves_open: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.finding, str):  # of a check of the user's own
            object.__setattr__(self, "finding", Said(text=self.finding))

    @property
    def meaning(self) -> str:
        """Return the sentence for the user: the finding and a remedy.

        If the sentence cannot be made because of a fault of the program, the text says so.
        """
        made = unless_faulty(lambda: self.finding.sentence)
        return made.reason if isinstance(made, Missing) else made

    @classmethod
    def not_evaluated(cls, name: str, missing: Missing) -> "Check":
        """Return a check that could not be made, as a verdict lists it; it fails for a fault.

        It leaves a question open if its kind is `needed` and the result uses the subject of the
        check.
        """
        leaves_open = kind_of(name).needed and not isinstance(missing, NotUsed)
        status: Status = "not evaluated"
        finding: Finding = Said(text=missing.reason)
        if isinstance(missing, Fault):
            status, finding = "fail", FaultOfCheck(reason=missing.reason)
        return cls(name=name, status=status, finding=finding, leaves_open=leaves_open)

    @classmethod
    def unless(
        cls,
        name: str,
        fault: Finding | str | None,
        held: Finding | str = "",
        figure: float | None = None,
        most: float | None = None,
        *,
        matters: bool = True,
    ) -> "Check":
        """Return a check that fails if there is a fault, and otherwise passes."""
        found = fault or held
        return cls(
            name=name,
            status=status_of(not fault, matters=matters),
            finding=Said(text=found) if isinstance(found, str) else found,
            figure=figure,
            threshold=most,
        )

    @property
    def line(self) -> str:
        """Line of the verdict that the check belongs to, as in `KINDS`."""
        return kind_of(self.name).line

    @property
    def is_faulty(self) -> bool:
        """True if the check failed because of a fault of the program, not because of a finding."""
        finding = self.finding
        if isinstance(finding, FindingOfRecords):
            finding = finding.finding
        if isinstance(finding, ReadFinding):
            data = finding.data
            if data.get("kind") == FindingOfRecords.__name__:
                data = data["finding"]
            return data.get("kind") == FaultOfCheck.__name__
        return isinstance(finding, FaultOfCheck)


def made(name: str, find: Callable[[], Check | Missing | None]) -> Check | None:
    """Return a check as a verdict lists it, with the reason where it could not be made."""
    found = unless_faulty(find)
    return Check.not_evaluated(name, found) if isinstance(found, Missing) else found


def status_of(good: bool, *, matters: bool = True) -> Status:
    """Return the status of a check that was made; one that does not matter is a note."""
    return "pass" if good else "fail" if matters else "note"


@dataclass(frozen=True, slots=True)
class Fault(Missing):
    """Reason for a missing result that is a fault of the program."""


@dataclass(frozen=True, slots=True)
class NotUsed(Missing):
    """Reason for a missing check of something that the result does not use."""


def unless_faulty(find: Callable[[], Found]) -> Found | Missing:
    """Return the result of a check, or the reason why it could not be made, whatever it raises.

    A fault is raised where tracebacks are requested. Lack of memory is not a fault of a check. A
    user's own candidate that fails counts as a fault, because the other candidates were not
    compared.

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
        return Fault(f"the check could not be made because of a fault ({said}). Please report it")


def value_or(otherwise: Else, find: Callable[[], Found | Missing]) -> Found | Else:
    """Return the result of a measurement, or a default where it could not be made."""
    found = unless_faulty(find)
    return otherwise if isinstance(found, Missing) else found


def joined(found: Sequence[Check | None], records: Sequence[str]) -> Check | None:
    """Return the worst check of several records, with their names; for one record its check.

    Parameters
    ----------
    found : sequence of Check or None
        Checks by record, of one diagnostic.
    records : sequence of str
        Names of the records.
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
        if not unmade:
            return first
        return replace(first, finding=FindingExceptFor(finding=first.finding, unmade=tuple(unmade)))
    same = tuple(name for name, each in worst if each.finding == first.finding)
    others = tuple(name for name, _ in worst if name not in same)
    of_records = FindingOfRecords(
        finding=first.finding, records=same, others=others, fails=status == "fail"
    )
    return replace(first, finding=of_records)


def _distance(check: Check) -> float:
    """Return the ratio of a figure to its threshold, at least 1; 0 where it has none."""
    if check.figure is None or not check.threshold:
        return 0.0
    ratio = abs(check.figure / check.threshold)
    return max(ratio, 1 / ratio) if ratio else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """The place and the weight of checks of one name in every verdict.

    Attributes
    ----------
    line : str
        The question of the verdict that it answers. Law: the control follows the declared law.
        Timing: all signals are logged at the time that they act. Loop: the simulated closed loop
        reproduces the recorded motion. Model: no term is missing. Outliers: there are none.
        Precision: the record shows every parameter. Records: they are of one machine. Method: the
        methods agree.
    rank : int
        Its place among failed checks, a cause before its consequences.
    grave : bool
        Whether the estimates must not be used where it fails.
    needed : bool
        Whether the estimates rely on it, so that they are to be used with care without it.
    """

    line: str
    rank: int = 100
    grave: bool = False
    needed: bool = False


#: By name, line by line.
KINDS: dict[str, Kind] = {
    "control law": Kind(line="law", rank=0, grave=True, needed=True),
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
    "simulation": Kind(line="loop", rank=2, grave=True, needed=True),
    "windows": Kind(line="loop", rank=2, grave=True),
    "measured velocity": Kind(line="loop", rank=1, grave=True),
    "measured acceleration": Kind(line="loop", rank=1, grave=True),
    "control against limit": Kind(line="loop", rank=6, grave=True),
    "noise in the loop": Kind(line="loop", needed=True),
    "samples near rests": Kind(line="loop"),
    "equation error": Kind(line="model", rank=3, grave=True),
    "missing terms": Kind(line="model", rank=8, needed=True),
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
    """Return the kind of a check; a check without a row in `KINDS` has its own line, the last."""
    return KINDS.get(check) or Kind(line=check)


def lines_of(checks: Iterable[str]) -> tuple[str, ...]:
    """Return the lines of checks, each once, in the order of the checks."""
    return tuple(dict.fromkeys(kind_of(check).line for check in checks))


#: Checks that a verdict names where they could not be made.
_NAMED = ("missing terms", "control law", "simulation", "noise in the loop", "method")


@dataclass(frozen=True, slots=True, kw_only=True)
class Conclusion:
    """The conclusion from all checks of a result.

    Attributes
    ----------
    belief : {"believed", "with care", "not believed"}
    first : tuple of str
        Lines of the verdict to be corrected first: up to the first grave check that fails.
    failed : tuple of str
        Lines of the verdict with a failed check, the gravest first.
    decisive : str or None
        Name of the failed check that decides; None where checks of several lines do.
    is_faulty : bool
        Whether the decisive check failed because of a fault of the program.
    unchecked : tuple of str
        Lines of the verdict that were not checked and have to be named.
    left_open : tuple of str
        Names of the checks that were not made although the estimates rely on them.
    """

    belief: Belief
    first: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    decisive: str | None = None
    is_faulty: bool = False
    unchecked: tuple[str, ...] = ()
    left_open: tuple[str, ...] = ()


def conclusion(checks: Sequence[Check]) -> Conclusion:
    """Return the conclusion: how far the estimates can be used, failed and missing checks."""
    how = belief(checks)
    failed = [check for check in by_weight(checks) if check.status == "fail"]
    lines = lines_of(check.name for check in failed)
    # The grave check and those before it, which may be its cause.
    grave = [i for i, check in enumerate(failed) if kind_of(check.name).grave]
    deciding = failed[: min(grave) + 1] if grave else failed
    first = lines_of(check.name for check in deciding)
    decisive = min(deciding, key=lambda check: check.is_faulty) if len(first) == 1 else None
    skipped = {check.name for check in checks if check.status == "not evaluated"}
    left_open = {check.name for check in checks if check.leaves_open}
    # Another check of the same line failed, or nothing simulates a loop next to its law.
    irrelevant = {*lines, "loop"}
    unchecked = lines_of(
        name
        for name in dict.fromkeys((*_NAMED, *left_open))
        if name in left_open or (name in skipped and kind_of(name).line not in irrelevant)
    )
    return Conclusion(
        belief=how,
        first=first,
        failed=lines,
        decisive=None if decisive is None else decisive.name,
        is_faulty=decisive is not None and decisive.is_faulty,
        unchecked=unchecked,
        left_open=tuple(name for name in KINDS if name in left_open),
    )


def belief(checks: Iterable[Check]) -> Belief:
    """Return how far the estimates of a result can be used.

    They must not be used where any grave check fails. They are to be used with care where another
    check fails, or where something that they rely on could not be checked.
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
    """A result with `checks`, which decide whether it can be used."""

    __slots__ = ()

    @property
    def belief(self: _HasChecks) -> Belief:
        """Usability of the estimates: "believed", "with care" or "not believed"."""
        return belief(self.checks)

    @property
    def believed(self: _HasChecks) -> bool:
        """True if no check fails, and everything that the estimates rely on was checked."""
        return belief(self.checks) == "believed"


def by_weight(checks: Sequence[Check]) -> list[Check]:
    """Return checks by the weight of their failure for the estimates, the gravest first."""
    return sorted(checks, key=lambda check: kind_of(check.name).rank)
