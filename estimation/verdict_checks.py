"""One check of a result: a figure, its threshold and a finding; and the conclusion from several.

In: a figure, its threshold, a finding. Out: `Check`, `Conclusion`. Knows nothing of the subject of
a check.

A verdict groups checks by the question that they answer: its lines. `KINDS` has the line and the
weight of every check of the program.
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
#: Status of a check, see `Check`.
Status = Literal["pass", "note", "fail", "not evaluated"]


Else = TypeVar("Else")
#: Statuses of a check that was made, the worst first.
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
        term is also relevant if it changes a parameter by more than half the width of its interval.

    Raises
    ------
    UsageError
        A threshold is not a number between 0 and 1.
    """

    level: Annotated[float, Meta(gt=0, lt=1)] = CHECK_LEVEL.value
    least_share: Annotated[float, Meta(gt=0, lt=1)] = LEAST_SHARE.value

    def __post_init__(self) -> None:
        for each in fields(self):
            given = getattr(self, each.name)
            if not (is_real(given) and 0 < float(given) < 1):
                raise UsageError(
                    f"the {each.name.replace('_', ' ')} is {quoted(given)}, which is not a number "
                    f"between 0 and 1. Give a number such as {each.default:g}.",
                    code="method",
                )


DEFAULT_LEVELS = Levels()


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One check of a result.

    Attributes
    ----------
    name : str
        Name of the check, as in `KINDS`.
    status : {"pass", "note", "fail", "not evaluated"}
        A note is beyond the threshold as well, but the estimates remain usable: they already take
        it into account, or another check reports the same cause.
    finding : Finding
        Result of the check as data. A text becomes `Said`, for a user's own check.
    figure : float or None
        The measured quantity; None without one.
    threshold : float or None
        Threshold of the figure; None without one.
    p_value : float or None
        P-value of the test behind the check; None for a check without a test.
    source : str
        Definition of the figure with its unit, and the condition under which the check fails, or
        the origin of the threshold.
    leaves_open : bool
        Whether the estimates rely on something that this check could not test, in any record.
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
        if isinstance(self.finding, str):  # the text of a user's own check
            object.__setattr__(self, "finding", Said(text=self.finding))

    @property
    def meaning(self) -> str:
        """Return the sentence for the user: the finding and a remedy.

        If a fault of the program prevents the sentence, the text reports that fault.
        """
        made = unless_faulty(lambda: self.finding.sentence)
        return made.reason if isinstance(made, Missing) else made

    @classmethod
    def not_evaluated(cls, name: str, missing: Missing) -> "Check":
        """Return the check for a missing result: not evaluated, or failed because of a fault.

        The check leaves a question open if its kind is `needed` and the result uses the subject of
        the check.

        Parameters
        ----------
        name : str
            Name of the check.
        missing : Missing
            Reason why there is no result: `Fault` for a fault of the program or of a user's own
            candidate, `NotUsed` for a subject that the result does not use.
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
        """Return a check that fails if there is a fault, and otherwise passes.

        Parameters
        ----------
        name : str
            Name of the check.
        fault : Finding or str or None
            Finding of a failed check; None or an empty text if there is no fault.
        held : Finding or str
            Finding of a check that passes.
        figure, most : float or None
            Measured quantity and its threshold; None without one.
        matters : bool
            Whether a fault fails the check; otherwise the check is a note.
        """
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
        """Line of the verdict that the check belongs to, see `Kind`."""
        return kind_of(self.name).line

    @property
    def is_faulty(self) -> bool:
        """True if a fault of the program, or of a user's own candidate, prevented the check."""
        # The finding itself, or its members if it was read from a file; of the worst record if
        # there are several.
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
    """Return the check that a function makes; None where there is nothing to check.

    If the function returns `Missing` or raises an error, the check is that of
    `Check.not_evaluated`, with the reason.
    """
    found = unless_faulty(find)
    return Check.not_evaluated(name, found) if isinstance(found, Missing) else found


def status_of(good: bool, *, matters: bool = True) -> Status:
    """Return the status of a check that was made: "pass" if it is good, otherwise "fail".

    A check that is not good is a "note" if that does not matter for the estimates.
    """
    if good:
        return "pass"
    return "fail" if matters else "note"


@dataclass(frozen=True, slots=True)
class Fault(Missing):
    """Reason for a missing result that is a fault of the program."""


@dataclass(frozen=True, slots=True)
class NotUsed(Missing):
    """Reason for a missing check of something that the result does not use."""


def unless_faulty(find: Callable[[], Found]) -> Found | Missing:
    """Return the result of a function, or the reason why there is none if it raises an error.

    An error of axisid, such as unsuitable data, becomes `Missing`. A user's own candidate that
    fails becomes `Fault`, because the other candidates were not compared. Any other exception
    becomes `Fault` too; if the user asks for tracebacks, it is raised instead. Lack of memory is
    always raised.

    Parameters
    ----------
    find : callable
        Function without arguments that makes a check or a measurement.
    """
    try:
        return find()
    except CandidateError as error:
        return Fault(str(error))
    except AxisidError as error:
        return Missing(str(error))
    except MemoryError:
        raise
    except Exception as fault:
        if asks_for_tracebacks():
            raise
        error_text = f"{type(fault).__name__}: {fault}".rstrip(": ")
        return Fault(
            f"the check could not be made because of a fault of the program ({error_text}). Report "
            "this fault"
        )


def value_or(otherwise: Else, find: Callable[[], Found | Missing]) -> Found | Else:
    """Return the result of a measurement, or the default `otherwise` where it is missing."""
    found = unless_faulty(find)
    return otherwise if isinstance(found, Missing) else found


def joined(found: Sequence[Check | None], records: Sequence[str]) -> Check | None:
    """Return one check for several records: the worst, with the names of its records.

    Of the checks with the worst status, it is the one whose figure is farthest from its threshold.
    The check of a single record is returned unchanged. None where no record has anything to check.

    Parameters
    ----------
    found : sequence of Check or None
        The same check of each record; None for a record with nothing to check.
    records : sequence of str
        Names of the records.
    """
    if len(records) == 1:
        return found[0]
    every = [(name, each) for name, each in zip(records, found, strict=True) if each is not None]
    unmade = [name for name, each in every if each.status == "not evaluated"]
    leaves_open = any(each.leaves_open for _, each in every)
    # The check could be made for no record.
    if len(unmade) == len(every):
        return replace(every[0][1], leaves_open=leaves_open) if every else None
    # The worst status, and of its checks the one that is farthest from the threshold.
    statuses = {each.status for _, each in every}
    status = next(each for each in WORST_FIRST if each in statuses)
    worst = [(name, each) for name, each in every if each.status == status]
    first = replace(max((each for _, each in worst), key=_distance), leaves_open=leaves_open)
    if status == "pass":
        if not unmade:
            return first
        return replace(first, finding=FindingExceptFor(finding=first.finding, unmade=tuple(unmade)))
    # Records with this status, with the same finding and with another.
    same = tuple(name for name, each in worst if each.finding == first.finding)
    others = tuple(name for name, _ in worst if name not in same)
    of_records = FindingOfRecords(
        finding=first.finding, records=same, others=others, fails=status == "fail"
    )
    return replace(first, finding=of_records)


def _distance(check: Check) -> float:
    """Return the factor, at least 1, between the figure of a check and its threshold.

    It is 0 where the figure or the threshold is missing or 0.
    """
    if check.figure is None or not check.threshold:
        return 0.0
    ratio = abs(check.figure / check.threshold)
    return max(ratio, 1 / ratio) if ratio else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """Line and weight of the checks of one name in every verdict.

    Attributes
    ----------
    line : str
        Line of the verdict. Each line states one thing if its checks pass. Law: the control follows
        the declared law. Timing: all signals are logged at the time at which they act. Loop: the
        simulated closed loop reproduces the recorded motion. Model: no term is missing. Outliers:
        the record has none. Precision: the record shows every parameter. Records: all records are
        of one machine. Method: the methods agree.
    rank : int
        Order among failed checks; a cause has a lower rank than its consequences.
    grave : bool
        Whether the estimates must not be used if the check fails.
    needed : bool
        Whether the estimates rely on the check, so that they are to be used with care without it.
    """

    line: str
    rank: int = 100
    grave: bool = False
    needed: bool = False


#: Kinds of checks by the name of the check, line by line.
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
    """Return the kind of a check by its name; a name that is not in `KINDS` is its own line."""
    return KINDS.get(check) or Kind(line=check)


def lines_of(checks: Iterable[str]) -> tuple[str, ...]:
    """Return the lines of checks, given by name: each line once, in the order of the checks."""
    return tuple(dict.fromkeys(kind_of(check).line for check in checks))


#: Checks that a verdict names if they could not be made.
_NAMED = ("missing terms", "control law", "simulation", "noise in the loop", "method")


@dataclass(frozen=True, slots=True, kw_only=True)
class Conclusion:
    """The conclusion from all checks of a result.

    Attributes
    ----------
    belief : {"believed", "with care", "not believed"}
    first : tuple of str
        Lines of the verdict to be corrected first: those of the failed checks up to the first grave
        one, in the order of rank; those of all failed checks if none is grave.
    failed : tuple of str
        Lines of the verdict with a failed check, in the order of rank.
    decisive : str or None
        Name of the failed check that decides: the first grave one, otherwise the first in the order
        of rank. None where no check fails, or checks of several lines decide.
    is_faulty : bool
        Whether a fault of the program, or of a user's own candidate, prevented the decisive check.
    unchecked : tuple of str
        Lines of the verdict that were not checked and that the headline has to name.
    left_open : tuple of str
        Names of the checks that were not made although the estimates rely on them.
    finding : Finding or None
        Finding of the decisive check.
    """

    belief: Belief
    first: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    decisive: str | None = None
    is_faulty: bool = False
    unchecked: tuple[str, ...] = ()
    left_open: tuple[str, ...] = ()
    finding: Finding | None = None


def conclusion(checks: Sequence[Check]) -> Conclusion:
    """Return the conclusion: how far the estimates can be used, failed and missing checks."""
    # Failed checks and their lines, in the order of rank.
    failed = [check for check in by_weight(checks) if check.status == "fail"]
    lines = lines_of(check.name for check in failed)
    # The first grave check and those before it, which may be its cause.
    grave = [i for i, check in enumerate(failed) if kind_of(check.name).grave]
    deciding = failed[: min(grave) + 1] if grave else failed
    first = lines_of(check.name for check in deciding)
    # Of several checks of one line, one that was made decides, and a grave one before others.
    decisive = None
    if len(first) == 1:
        by_gravity = deciding[::-1] if grave else deciding
        decisive = min(by_gravity, key=lambda check: check.is_faulty)
    # Lines to name because a check was not made. A line with a failed check is named already. A
    # loop that was not simulated is named only if the estimates rely on it.
    skipped = {check.name for check in checks if check.status == "not evaluated"}
    left_open = [check.name for check in checks if check.leaves_open]
    irrelevant = {*lines, "loop"}
    unchecked = lines_of(
        name
        for name in dict.fromkeys((*_NAMED, *left_open))
        if name in left_open or (name in skipped and kind_of(name).line not in irrelevant)
    )
    return Conclusion(
        belief=belief(checks),
        first=first,
        failed=lines,
        decisive=None if decisive is None else decisive.name,
        is_faulty=decisive is not None and decisive.is_faulty,
        unchecked=unchecked,
        left_open=tuple(name for name in KINDS if name in left_open),
        finding=None if decisive is None else decisive.finding,
    )


def belief(checks: Iterable[Check]) -> Belief:
    """Return how far the estimates of a result can be used.

    They must not be used ("not believed") if a grave check fails. They are to be used with care if
    another check fails, or if something that they rely on could not be checked.
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
    """Return checks in the order of their rank in `KINDS`, a cause before its consequences."""
    return sorted(checks, key=lambda check: kind_of(check.name).rank)
