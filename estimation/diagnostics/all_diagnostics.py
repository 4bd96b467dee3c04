"""All diagnostics of a result, in the order of the verdict, and their measurements.

No check passes silently: a check that could not be made is reported as such. None is a universal
gate; each names the source of its threshold.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from axisid.estimation.diagnostics.control_law import (
    NOISE_GAIN,
    LawAgreement,
    noise_gain_check,
)
from axisid.estimation.misspecification import JackknifeInterval, LackOfFit
from axisid.estimation.records import record_labels
from axisid.estimation.verdict_checks import Check, joined, made, unless_faulty, value_or
from axisid.support.arrays import Exact
from axisid.support.missing import Missing
from axisid.support.one_thread import in_one_thread

from .agreement_of_estimates import InstrumentTests, forms_check, method_check
from .alignment import Alignment
from .column_comparison import ColumnComparison, derivative_check, force_check, limit_check
from .diagnostic_inputs import ONE_RECORD, DiagnosticInputs
from .hausman import HausmanTest
from .model_error_checks import (
    fails,
    lack_of_fit_check,
    missing_terms_check,
    misspecification_check,
    moved_parameters_check,
    outliers_check,
    simulation_error_check,
)
from .overlapping_records import repeated_check
from .parameter_checks import (
    NOMINAL_VALUES,
    Excitation,
    fixed_check,
    gain_check,
    nominal_check,
    precision,
    rows_check,
    within_bounds,
)
from .pooling import RecordDifference, pooling_check
from .scale_of_control import control_law_check
from .sudden_steps import SUDDEN_STEPS, sudden_steps_check


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordDiagnosis(Exact):
    """Measurements of the diagnostics of one record.

    Attributes
    ----------
    law : LawAgreement or Missing
        Agreement of the recorded control with the declared law, or why it cannot be checked.
    alignment : Alignment or Missing
        The delay of the force, or why it cannot be measured.
    verdict : tuple of Check
        All checks; for one of several records those of that record.
    lack_of_fit : LackOfFit or None
        Split of the residual of the reported estimate into a part that repeats and noise; None
        where the reference does not repeat, or there is none.
    motions : mapping of str to ColumnComparison or Missing
        Comparison of a measured velocity and acceleration with a derivative, by role.
    apart : RecordDifference or Missing
        Difference of the parameters of this record from those of the others; Missing for a single
        record, and where it is unknown.
    """

    law: LawAgreement | Missing
    alignment: Alignment | Missing
    verdict: tuple[Check, ...]
    lack_of_fit: LackOfFit | None = None
    motions: Mapping[str, ColumnComparison | Missing] = field(default_factory=dict)
    apart: RecordDifference | Missing = ONE_RECORD


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Diagnosis(RecordDiagnosis):
    """Measurements of the diagnostics of a result.

    For several records, the members of `RecordDiagnosis` are those of the first record with a
    failed check, otherwise of the first record.

    Attributes
    ----------
    preferred : str
        Method whose estimate the checks apply to.
    instruments : InstrumentTests or None
        Tests of the instruments of `preferred`, or of IDM-IV where `preferred` is output error;
        None without instruments.
    excitation : tuple of Excitation
        Excitation of each physical parameter.
    bands : mapping of str to mapping of str to JackknifeInterval
        Jackknife intervals for the effect of the model error, by method and physical parameter.
    with_missing_terms : mapping of str to tuple of float
        Value of each physical parameter in a model with the missing term, by name. It has two
        values, forward and backward, where these differ. Empty unless *missing terms* fails.
    differences : mapping of str to mapping of str to HausmanTest
        Tests of the difference between two estimates, by pair of methods and physical parameter.
        The pair ``idm-iv less didim`` is IDM-IV minus DIDIM.
    records : tuple of RecordDiagnosis
        Measurements of each record; empty for a single record.
    """

    preferred: str
    instruments: InstrumentTests | None
    excitation: tuple[Excitation, ...]
    bands: Mapping[str, Mapping[str, JackknifeInterval]] = field(default_factory=dict)
    with_missing_terms: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    differences: Mapping[str, Mapping[str, HausmanTest]] = field(default_factory=dict)
    records: tuple[RecordDiagnosis, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostic:
    """One check of the verdict, with the function that makes it.

    Attributes
    ----------
    name : str
        Name of the check.
    check : callable
        Returns the check of a result, or why it cannot be made; None where there is nothing to
        check.
    by_record : bool
        Whether it checks a single record. Each of several records is then checked.
    several : bool
        Whether it applies to several records only.
    """

    name: str
    check: Callable[[DiagnosticInputs], Check | Missing | None]
    by_record: bool = False
    several: bool = False


def _method(case: DiagnosticInputs) -> Check | Missing | None:
    """Return the check of the reported estimate against others, and of its bias by noise.

    Only least squares has such a bias. None if the only estimate is by instruments: it has no other
    estimate to compare with, and no such bias to check.
    """
    if len(case.estimates) == 1 and case.preferred.Z is not None:
        return None  # no other estimate, and no bias of least squares
    return method_check(
        case.preferred,
        case.estimates,
        case.compared,
        case.steps,
        case.levels,
        law_passed=None if any(isinstance(law, Missing) for law in case.laws) else case.laws_hold,
    )


def _moved_parameters(case: DiagnosticInputs) -> Check | Missing | None:
    """Return the failed check of a parameter that a missing term moves too far; None otherwise."""
    lacking = value_or((), lambda: case.lacking)
    if not lacking:
        return None
    return moved_parameters_check(missing_terms_check(lacking, case), lacking)


#: All diagnostics by name, in the order of the verdict.
DIAGNOSTICS: dict[str, Diagnostic] = {
    row.name: row
    for row in (
        Diagnostic(
            name=SUDDEN_STEPS,
            check=lambda case: sudden_steps_check(case.data.axis, case.data.record),
            by_record=True,
        ),
        Diagnostic(name="control law", check=control_law_check, by_record=True),
        Diagnostic(
            name=NOISE_GAIN,
            check=lambda case: noise_gain_check(case.data.axis, case.data.record),
            by_record=True,
        ),
        Diagnostic(
            name="instrument strength",
            check=lambda case: case.strength if {"idm-iv", "ddm-iv"} & {*case.estimates} else None,
        ),
        Diagnostic(name="method", check=_method),
        Diagnostic(
            name="inverse against direct",
            check=lambda case: forms_check(case.compared, case.estimates, case.levels),
        ),
        Diagnostic(
            name="rows",
            check=lambda case: rows_check(len(case.preferred.y), len(case.preferred.theta)),
        ),
        Diagnostic(name="precision", check=lambda case: precision(case.preferred, case.excitation)),
        Diagnostic(
            name="bounds",
            check=lambda case: within_bounds(case.preferred, case.problem.rest, case.problem.held),
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
            check=lambda case: case.if_used(
                simulation_error_check(
                    case.preferred,
                    case.data.rest,
                    misspecified=case.laws_hold
                    and fails(unless_faulty(lambda: missing_terms_check(case.lacking, case))),
                )
            ),
            by_record=True,
        ),
        Diagnostic(name="outliers", check=outliers_check, by_record=True),
        Diagnostic(name="alignment", check=lambda case: case.aligned, by_record=True),
        Diagnostic(
            name="fixed values",
            check=lambda case: (
                fixed_check(case.preferred, case.levels.level)
                if case.data.axis.base.known
                else None
            ),
        ),
        Diagnostic(
            name="physical parameters",
            check=lambda case: (
                None
                if case.data.axis.base.known
                else fixed_check(case.preferred, case.levels.level)
            ),
        ),
        Diagnostic(
            name="force against control",
            check=lambda case: force_check(case.data.axis, case.data.record),
            by_record=True,
        ),
        Diagnostic(
            name="measured velocity",
            check=lambda case: derivative_check(
                case.data.axis, case.data.record, "velocity", case.motions.get("velocity")
            ),
            by_record=True,
        ),
        Diagnostic(
            name="measured acceleration",
            check=lambda case: derivative_check(
                case.data.axis, case.data.record, "acceleration", case.motions.get("acceleration")
            ),
            by_record=True,
        ),
        Diagnostic(
            name="recorded signals",
            check=lambda case: (
                misspecification_check(
                    case.lacking,
                    "recorded signals",
                    case.data.axis,
                    case.data.record,
                    case.levels,
                )
                if case.data.axis.signals
                else None
            ),
            by_record=True,
        ),
        Diagnostic(
            name="control against limit",
            check=lambda case: limit_check(case.data.axis, case.data.record),
            by_record=True,
        ),
        Diagnostic(
            name="missing terms",
            check=lambda case: missing_terms_check(case.lacking, case),
            by_record=True,
        ),
        Diagnostic(
            name="moved parameters",
            check=_moved_parameters,
            by_record=True,
        ),
        Diagnostic(
            name="lack of fit",
            check=lambda case: lack_of_fit_check(case.lack_of_fit, case.preferred),
            by_record=True,
        ),
        Diagnostic(
            name="drive gain",
            check=lambda case: gain_check(case.preferred, case.problem.axis.drive),
            several=True,
        ),
        Diagnostic(
            name="records alike",
            check=lambda case: pooling_check(
                case.alike, record_labels([data.record for data in case.problem.data]), case.levels
            ),
            several=True,
        ),
        Diagnostic(
            name="repeated records",
            check=lambda case: repeated_check([data.record for data in case.problem.data]),
            several=True,
        ),
    )
}


@in_one_thread
def diagnose(case: DiagnosticInputs) -> Diagnosis:
    """Return the measurements and checks of all diagnostics of a result.

    Checks of single records are made for each record, and joined into one for the verdict. Law,
    alignment and motion of the result are those of the first record whose check of them fails.
    """
    by_record = {
        d.name: [made(d.name, partial(d.check, part)) for part in case.parts]
        for d in DIAGNOSTICS.values()
        if d.by_record
    }
    alike = unless_faulty(lambda: case.alike)
    names = record_labels([data.record for data in case.problem.data])
    records = [
        RecordDiagnosis(
            law=unless_faulty(partial(getattr, part, "law")),
            alignment=unless_faulty(partial(getattr, part, "alignment")),
            motions=value_or({}, partial(getattr, part, "motions")),
            lack_of_fit=value_or(None, partial(getattr, part, "lack_of_fit")),
            verdict=tuple(check for found in by_record.values() if (check := found[i]) is not None),
            apart=alike if isinstance(alike, Missing) else alike.records[i],
        )
        for i, part in enumerate(case.parts)
    ]
    checks = (
        joined(by_record[name], names) if d.by_record else made(name, partial(d.check, case))
        for name, d in DIAGNOSTICS.items()
        if not (d.several and len(names) == 1)
    )
    are_named = fails(by_record["missing terms"][0])
    law, alignment, velocity = (
        records[_first_failing(by_record[name])]
        for name in ("control law", "alignment", "measured velocity")
    )
    return Diagnosis(
        preferred=case.method,
        law=law.law,
        instruments=value_or(None, lambda: case.instruments),
        excitation=value_or((), lambda: case.excitation),
        alignment=alignment.alignment,
        motions=velocity.motions,
        verdict=tuple(check for check in checks if check is not None),
        lack_of_fit=None if case.has_parts else records[0].lack_of_fit,
        bands={} if case.has_parts else value_or({}, lambda: case.bands),
        with_missing_terms=case.with_missing_terms if are_named and not case.has_parts else {},
        records=tuple(records) if len(records) > 1 else (),
        differences=value_or(
            {},
            lambda: {n: e for n, e in case.compared.items() if not isinstance(e, Missing)},
        ),
    )


def _first_failing(found: Sequence[Check | None]) -> int:
    """Return the index of the record shown in the report: the first failed, otherwise the first.

    `found` has the same check of each record, or None. A check that raised an error counts as
    failed but has no figure: a failed check with a figure comes first.
    """
    fails = (
        (each.figure is None, i) for i, each in enumerate(found) if each and each.status == "fail"
    )
    return min(fails, default=(False, 0))[1]
