"""Every diagnostic, in the order of the verdict, and what it is worth.

No check passes silently: one that could not be made says so. None is a universal gate; each names
where its threshold comes from.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, Protocol

from axisid.estimation.checks import (
    Check,
    first_case,
    joined,
    kind_of,
    lines_of,
    made,
    told_or,
    unless_faulty,
)
from axisid.estimation.diagnostics.law import law_check
from axisid.estimation.misspecification import Misspecification
from axisid.estimation.signals import rests_first
from axisid.support.errors import Missing

from .alignment import alignment_check, declared_lateness
from .column_comparison import force_check, limit_check, motion_check
from .diagnosis import Case, Diagnosis, RecordDiagnosis
from .excitation import (
    NOMINAL_VALUES,
    fixed_check,
    gain_check,
    nominal_check,
    precision,
    within_bounds,
)
from .method import forms_check, method_check
from .misfit_checks import following, lack_of_fit_check, lacks_check
from .records_alike import alike_check, repeated_check

#: How far the numbers of a result can be believed.
Belief = Literal["believed", "with care", "not believed"]

#: What is told where it could not be asked: of what an axis declares, and what noise does.
_OF_THE_MODEL = ("missing terms", "control law", "method")


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostic:
    """One thing that is held against a result.

    Attributes
    ----------
    name : str
        Of its check.
    check : callable
        Check of a case, or why it cannot be made; None where the case has nothing to check.
    by_record : bool
        Whether it looks at one record, so that of several it looks at each.
    several : bool
        Whether it is of several records alone.
    """

    name: str
    check: Callable[[Case], Check | Missing | None]
    by_record: bool = False
    several: bool = False


def _method(case: Case) -> Check | Missing | None:
    if len(case.estimates) == 1 and case.preferred.Z is not None:
        return None  # nothing is beside it
    laws = [part.law for part in case.parts]
    checked = [law for law in laws if not isinstance(law, Missing)]
    law_passed = all(law.passed for law in checked) if len(checked) == len(laws) else None
    return method_check(
        case.preferred,
        case.estimates,
        case.compared,
        case.steps,
        case.levels,
        law_passed=law_passed,
    )


def _outliers(case: Case) -> Check | Missing:
    if not isinstance(case.lacking, Missing) and not case.preferred.inference.chains:
        # HAC takes their size from the samples themselves.
        return Missing(
            "single samples are held against twins of the record, of which there are none"
        )
    return _lacks("outliers", case, bounded=case.preferred.counts is not None)


def _lacks(name: str, case: Case, *, bounded: bool = False) -> Check | Missing:
    data = case.data
    return lacks_check(case.lacking, name, data.axis, data.record, case.levels, bounded=bounded)


def _alignment(case: Case) -> Check | Missing:
    if case.weak:
        return Missing("the instruments are too weak to measure a delay")
    return alignment_check(
        case.alignment, case.data, late=_delay(case), law=case.law, timing=case.timing
    )


def _delay(case: Case) -> Misspecification | Missing | None:
    """The delay that the model lacks, which twins tell from noise."""
    if isinstance(case.lacking, Missing):
        return case.lacking
    if isinstance(case.scores, Missing) or not case.scores.twins:
        return Missing("there are no twins")
    return next((lack for lack in case.lacking if lack.kind == "delay"), None)


def _measured(role: str, case: Case) -> Check | Missing | None:
    return motion_check(case.data.axis, case.data.record, role, case.motions.get(role))


def _missing_terms(case: Case) -> Check | Missing:
    lacking = case.lacking
    if isinstance(lacking, Missing):
        return lacking
    aligned = _alignment(case)  # which says how late, where it fails
    told = [lack for lack in lacking if not (lack.kind == "delay" and _fails(aligned))]
    found = lacks_check(told, "missing terms", case.data.axis, case.data.record, case.levels)
    if isinstance(found, Missing) or found.status != "fail":
        return found
    if _fails(method_check(case.preferred, {}, {}, case.steps, case.levels, law_passed=None)):
        return replace(found, status="note")  # what the steps move is left, and counts once
    early = isinstance(aligned, Check) and _fails(aligned) and (aligned.figure or 0.0) < 0
    if early and declared_lateness(case.data) > 0:  # friction is wrong at low speed then
        said = "the delay or lag that is declared too long, see alignment, may make it"
        return replace(found, status="note", meaning=f"{found.meaning}; {said}: mend that first")
    return found


def _fixed(case: Case) -> Check | Missing | None:
    return fixed_check(case.preferred, case.levels.level)


def _fails(found: Check | Missing | None) -> bool:
    return isinstance(found, Check) and found.status == "fail"


#: By name, in the order of the verdict.
DIAGNOSTICS: dict[str, Diagnostic] = {
    row.name: row
    for row in (
        Diagnostic(name="control law", check=lambda case: law_check(case.law), by_record=True),
        Diagnostic(
            name="instrument strength",
            check=lambda case: case.strength if {"idm-iv", "ddm-iv"} & {*case.estimates} else None,
        ),
        Diagnostic(name="method", check=_method),
        Diagnostic(
            name="inverse against direct",
            check=lambda case: forms_check(case.compared, case.estimates, case.levels),
        ),
        Diagnostic(name="precision", check=lambda case: precision(case.preferred, case.excitation)),
        Diagnostic(
            name="bounds",
            check=lambda case: within_bounds(
                case.preferred, rests_first(case.problem.rest), case.problem.held
            ),
        ),
        Diagnostic(
            name=NOMINAL_VALUES,
            check=lambda case: nominal_check(
                (
                    p,
                    case.preferred.parameters[p.name].corrected,
                    case.preferred.parameters[p.name].interval,
                )
                for p in case.preferred.form.declared
                if p.name in case.preferred.parameters
            ),
        ),
        Diagnostic(
            name="simulation",
            check=lambda case: following(case.preferred, case.data.rest),
            by_record=True,
        ),
        Diagnostic(name="outliers", check=_outliers, by_record=True),
        Diagnostic(name="alignment", check=_alignment, by_record=True),
        Diagnostic(
            name="fixed values",
            check=lambda case: _fixed(case) if case.data.axis.base.known else None,
        ),
        Diagnostic(
            name="physical parameters",
            check=lambda case: None if case.data.axis.base.known else _fixed(case),
        ),
        Diagnostic(
            name="force against control",
            check=lambda case: force_check(case.data.axis, case.data.record),
            by_record=True,
        ),
        Diagnostic(name="measured velocity", check=partial(_measured, "velocity"), by_record=True),
        Diagnostic(
            name="measured acceleration", check=partial(_measured, "acceleration"), by_record=True
        ),
        Diagnostic(
            name="recorded signals",
            check=lambda case: (
                _lacks("recorded signals", case) if case.data.axis.axis.signals else None
            ),
            by_record=True,
        ),
        Diagnostic(
            name="control against limit",
            check=lambda case: limit_check(case.data.axis, case.data.record),
            by_record=True,
        ),
        Diagnostic(name="missing terms", check=_missing_terms, by_record=True),
        Diagnostic(
            name="lack of fit",
            check=lambda case: lack_of_fit_check(case.lack_of_fit, case.preferred),
            by_record=True,
        ),
        Diagnostic(
            name="drive gain",
            check=lambda case: gain_check(case.preferred, case.problem.axis.axis.drive),
            several=True,
        ),
        Diagnostic(
            name="records alike",
            check=lambda case: alike_check(case.alike, case.names, case.levels),
            several=True,
        ),
        Diagnostic(
            name="repeated records",
            check=lambda case: repeated_check([data.record for data in case.problem.data]),
            several=True,
        ),
    )
}


def diagnose(case: Case) -> Diagnosis:
    """What every diagnostic finds in a result."""
    by_record = {
        d.name: [made(d.name, partial(d.check, part)) for part in case.parts]
        for d in DIAGNOSTICS.values()
        if d.by_record
    }
    alike = unless_faulty(lambda: case.alike)
    records = [
        RecordDiagnosis(
            law=unless_faulty(partial(getattr, part, "law")),
            alignment=unless_faulty(partial(getattr, part, "alignment")),
            motions=told_or({}, partial(getattr, part, "motions")),
            lack_of_fit=told_or(None, partial(getattr, part, "lack_of_fit")),
            verdict=tuple(check for found in by_record.values() if (check := found[i]) is not None),
            apart=alike if isinstance(alike, Missing) else alike.records[i],
        )
        for i, part in enumerate(case.parts)
    ]
    alone = len(case.names) == 1
    checks = (
        joined(by_record[name], case.names) if d.by_record else made(name, partial(d.check, case))
        for name, d in DIAGNOSTICS.items()
        if not (d.several and alone)
    )
    law, alignment, velocity = (
        records[_first_failing(by_record[name])]
        for name in ("control law", "alignment", "measured velocity")
    )
    return Diagnosis(
        preferred=case.method,
        law=law.law,
        instruments=told_or(None, lambda: case.instruments),
        excitation=told_or((), lambda: case.excitation),
        alignment=alignment.alignment,
        motions=velocity.motions,
        verdict=tuple(check for check in checks if check is not None),
        lack_of_fit=None if case.has_parts else records[0].lack_of_fit,
        bands={} if case.has_parts else told_or({}, lambda: case.bands),
        records=tuple(records) if len(records) > 1 else (),
        differences=told_or(
            {},
            lambda: {n: e for n, e in case.compared.items() if not isinstance(e, Missing)},
        ),
    )


def _first_failing(found: Sequence[Check | None]) -> int:
    """The record whose law or alignment is told of: the first that fails, else the first.

    A check that faults fails too, and measures nothing: one that does comes before it.
    """
    fails = [(each.figure is None, i) for i, each in enumerate(found) if each and _fails(each)]
    return min(fails, default=(False, 0))[1]


def conclusion(checks: Sequence[Check]) -> str:
    """Whether the numbers can be believed, from the checks of a result."""
    failed = [check.name for check in by_weight(checks) if check.status == "fail"]
    # What could not be asked of the model: what it lacks, and whether the law is the drive's.
    skipped = [check.name for check in checks if check.status == "not evaluated"]
    names = lines_of(name for name in _OF_THE_MODEL if name in skipped)
    unchecked = f"; not checked: {', '.join(names)}" if names else ""
    lines, how = lines_of(failed), belief(failed)
    return first_case(
        (
            how == "believed",
            f"Nothing that was checked speaks against these numbers{unchecked}.",
        ),
        (
            how == "not believed",
            f"Do not believe these numbers before this is mended: {''.join(lines[:1])}.",
        ),
        (True, f"Believe these numbers with care; to look at: {', '.join(lines)}{unchecked}."),
    )


def belief(failing: Iterable[str]) -> Belief:
    """How far the numbers of a result can be believed of which checks of these names fail."""
    first = min(map(kind_of, failing), key=lambda kind: kind.rank, default=None)
    return "believed" if first is None else "not believed" if first.grave else "with care"


class _HasChecks(Protocol):
    @property
    def checks(self) -> tuple[Check, ...]: ...


class Checked:
    """A result with `checks`, which say what it is worth."""

    __slots__ = ()

    @property
    def belief(self: _HasChecks) -> Belief:
        """How far the numbers can be believed: "believed", "with care", "not believed"."""
        return belief(check.name for check in self.checks if check.status == "fail")

    @property
    def believed(self: _HasChecks) -> bool:
        """Whether no check fails."""
        return all(check.status != "fail" for check in self.checks)


def by_weight(checks: Sequence[Check]) -> list[Check]:
    """Checks by what it means for the numbers that they fail, the gravest first."""
    return sorted(checks, key=lambda check: kind_of(check.name).rank)
