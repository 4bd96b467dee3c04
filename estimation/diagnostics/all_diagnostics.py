"""All diagnostics of a result, in the order of the verdict, and their measurements.

A check that could not be made is reported as not evaluated; it never passes silently. Each check
names the source of its threshold, because no threshold holds for every purpose.
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
        Comparison of the recorded control with the declared law; Missing, with the reason, where it
        is unavailable.
    alignment : Alignment or Missing
        Estimated delay of the force; Missing, with the reason, where it cannot be estimated.
    verdict : tuple of Check
        All checks; for one of several records, the checks of that record.
    lack_of_fit : LackOfFit or None
        Split of the residual of the reported estimate into a part that repeats and noise; None
        where there is no reference, or it does not repeat.
    motions : mapping of str to ColumnComparison or Missing
        Comparison of a measured velocity and acceleration with a derivative, by role.
    apart : RecordDifference or Missing
        Difference of the parameters of this record from those of the others; Missing, with the
        reason, for a single record and where the difference is unknown.
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
        Method whose estimate is reported; the checks apply to it.
    instruments : InstrumentTests or None
        Tests of the instruments of `preferred`, or of IDM-IV where `preferred` is output error;
        None without instruments.
    excitation : tuple of Excitation
        Excitation of each physical parameter.
    bands : mapping of str to mapping of str to JackknifeInterval
        Jackknife intervals for the effect of the model error, by method and physical parameter.
    with_missing_terms : mapping of str to tuple of float
        Value of each physical parameter in a model with the missing term, by name. A parameter that
        differs between directions has two values, forward and backward. Empty unless the check
        *missing terms* fails.
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
        Function that makes the check from the inputs of a result or of one record. It returns
        Missing, with the reason, where the check cannot be made, and None where there is nothing to
        check.
    by_record : bool
        Whether the check is made for each record separately; otherwise once for the result.
    several : bool
        Whether the check is made for several records only.
    """

    name: str
    check: Callable[[DiagnosticInputs], Check | Missing | None]
    by_record: bool = False
    several: bool = False


def _method(case: DiagnosticInputs) -> Check | Missing | None:
    """Return the check of the reported estimate against others, and of its bias by noise.

    Only least squares has such a bias. None if the only estimate is by instruments: there is then
    no other estimate to compare with, and no such bias to check.
    """
    if len(case.estimates) == 1 and case.preferred.Z is not None:
        return None
    # None for the law means that some record could not be compared with it.
    law_passed = None if any(isinstance(law, Missing) for law in case.laws) else case.laws_hold
    return method_check(
        case.preferred,
        case.estimates,
        case.compared,
        case.steps,
        case.levels,
        law_passed=law_passed,
    )


def _moved_parameters(case: DiagnosticInputs) -> Check | Missing | None:
    """Return the failed check of a parameter that a missing term changes too much, or None."""
    lacking = value_or((), lambda: case.lacking)
    if not lacking:
        return None
    found = missing_terms_check(lacking, case)
    return moved_parameters_check(found, lacking, case.data.axis, case.data.record)


def _nominal_values(case: DiagnosticInputs) -> Check | None:
    """Return a note on estimates of another order of magnitude than nominal; None without any."""
    found = []
    for parameter in case.preferred.form.declared:
        value = case.preferred.parameters.get(parameter.name)
        if value is not None:
            found.append((parameter, value.corrected, value.interval))
    return nominal_check(found)


def _simulation(case: DiagnosticInputs) -> Check | Missing:
    """Return the check of the simulation error of the reported estimate."""
    # If the law is correct, an incomplete model may be the cause of the simulation error.
    is_misspecified = case.laws_hold and fails(
        unless_faulty(lambda: missing_terms_check(case.lacking, case))
    )
    found = simulation_error_check(case.preferred, case.data.rest, misspecified=is_misspecified)
    return case.if_used(found)


def _fixed_values(case: DiagnosticInputs) -> Check | Missing | None:
    """Return the check of values that are known independently; None if the axis has none."""
    if not case.data.axis.base.known:
        return None
    return fixed_check(case.preferred, case.levels.level)


def _physical_parameters(case: DiagnosticInputs) -> Check | Missing | None:
    """Return the check of restrictions by physical parameters; None if the axis has known values.

    The known values and these restrictions are then checked together, see `_fixed_values`.
    """
    if case.data.axis.base.known:
        return None
    return fixed_check(case.preferred, case.levels.level)


def _recorded_signals(case: DiagnosticInputs) -> Check | Missing | None:
    """Return the check for late or wrongly scaled signals; None for an axis without signals."""
    axis, record = case.data.axis, case.data.record
    if not axis.signals:
        return None
    return misspecification_check(case.lacking, "recorded signals", axis, record, case.levels)


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
        Diagnostic(name=NOMINAL_VALUES, check=_nominal_values),
        Diagnostic(name="simulation", check=_simulation, by_record=True),
        Diagnostic(name="outliers", check=outliers_check, by_record=True),
        Diagnostic(name="alignment", check=lambda case: case.aligned, by_record=True),
        Diagnostic(name="fixed values", check=_fixed_values),
        Diagnostic(name="physical parameters", check=_physical_parameters),
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
        Diagnostic(name="recorded signals", check=_recorded_signals, by_record=True),
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

    Parameters
    ----------
    case : DiagnosticInputs
        The result to be checked.
    """
    # Checks of each record, by name: one for each part of the inputs.
    by_record = {
        d.name: [made(d.name, partial(d.check, part)) for part in case.parts]
        for d in DIAGNOSTICS.values()
        if d.by_record
    }
    # Measurements of each record.
    alike = unless_faulty(lambda: case.alike)
    names = record_labels([data.record for data in case.problem.data])
    records = list[RecordDiagnosis]()
    for i, part in enumerate(case.parts):
        checks_of_record = [found[i] for found in by_record.values()]
        diagnosis = RecordDiagnosis(
            law=unless_faulty(partial(getattr, part, "law")),
            alignment=unless_faulty(partial(getattr, part, "alignment")),
            motions=value_or({}, partial(getattr, part, "motions")),
            lack_of_fit=value_or(None, partial(getattr, part, "lack_of_fit")),
            verdict=tuple(check for check in checks_of_record if check is not None),
            apart=alike if isinstance(alike, Missing) else alike.records[i],
        )
        records.append(diagnosis)
    # Records whose law, alignment and motion are reported.
    law, alignment, velocity = (
        records[_first_failing(by_record[name])]
        for name in ("control law", "alignment", "measured velocity")
    )
    # Measurements of the whole result.
    preferred = case.method
    instruments = value_or(None, lambda: case.instruments)
    excitation = value_or((), lambda: case.excitation)
    # Checks in the order of the verdict.
    verdict = list[Check]()
    for name, diagnostic in DIAGNOSTICS.items():
        if diagnostic.several and len(names) == 1:
            continue
        if diagnostic.by_record:
            check = joined(by_record[name], names)
        else:
            check = made(name, partial(diagnostic.check, case))
        if check is not None:
            verdict.append(check)
    has_missing_terms = fails(by_record["missing terms"][0]) and not case.has_parts
    return Diagnosis(
        preferred=preferred,
        law=law.law,
        instruments=instruments,
        excitation=excitation,
        alignment=alignment.alignment,
        motions=velocity.motions,
        verdict=tuple(verdict),
        lack_of_fit=None if case.has_parts else records[0].lack_of_fit,
        bands={} if case.has_parts else value_or({}, lambda: case.bands),
        with_missing_terms=case.with_missing_terms if has_missing_terms else {},
        records=tuple(records) if len(records) > 1 else (),
        differences=value_or(
            {},
            lambda: {n: e for n, e in case.compared.items() if not isinstance(e, Missing)},
        ),
    )


def _first_failing(found: Sequence[Check | None]) -> int:
    """Return the index of the record shown in the report: the first failed, otherwise the first.

    `found` has the same check of each record, or None. A check that a fault prevented counts as
    failed but has no figure. A failed check with a figure therefore comes first.
    """
    failed = [
        (each.figure is None, i) for i, each in enumerate(found) if each and each.status == "fail"
    ]
    return min(failed, default=(False, 0))[1]
