"""Every diagnostic, in the order of the verdict, and checks of what a model leaves.

No check passes silently: one that could not be made says so. None is a universal gate; each names
where its threshold comes from.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostic_checks import (
    DEFAULT_LEVELS,
    Check,
    Levels,
    joined,
    made,
    status_of,
    told_or,
    unless_faulty,
)
from axisid.estimation.diagnostics.control_law import law_check
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.lack_of_fit import LackOfFit
from axisid.estimation.misspecification import Misspecification, sentence
from axisid.estimation.records import Record, advised_shift, record_labels
from axisid.estimation.records.columns import scale_remedy
from axisid.estimation.signals import advice_on_rests
from axisid.estimation.thresholds import (
    MAX_SIMULATION_ERROR,
    MIN_DISTANCE_FROM_NOISE,
    MIN_MODEL_SHARE,
)
from axisid.support.errors import Missing, unless_missing

from .alignment import declared_lateness
from .column_comparison import derivative_check, force_check, limit_check
from .diagnosis import Case, Diagnosis, RecordDiagnosis
from .estimator_checks import forms_check, method_check
from .excitation import (
    NOMINAL_VALUES,
    fixed_check,
    gain_check,
    nominal_check,
    precision,
    rows_check,
    within_bounds,
)
from .records_alike import pooling_check, repeated_check

#: By check of what is lacking: what is said where there is nothing.
_NOTHING: Mapping[str, str] = {
    "missing terms": "nothing that was looked for is in the residuals",
    "recorded signals": "the recorded signals are in time with the forces that they make, and of "
    "their size",
    "outliers": "no single sample leaves its course",
}


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
    return method_check(
        case.preferred,
        case.estimates,
        case.compared,
        case.steps,
        case.levels,
        law_passed=None if any(isinstance(law, Missing) for law in case.laws) else case.laws_hold,
    )


def _outliers(case: Case) -> Check | Missing:
    if not isinstance(case.lacking, Missing) and not case.preferred.inference.chains:
        # HAC takes their size from the samples themselves.
        return Missing(
            "single samples are held against twins of the record, of which there are none"
        )
    return lacks_check(
        case.lacking,
        "outliers",
        case.data.axis,
        case.data.record,
        case.levels,
        bounded=case.preferred.counts is not None,
    )


@unless_missing
def _missing_terms(lacking: Sequence[Misspecification], case: Case) -> Check | Missing:
    aligned = case.aligned  # which says how late, where it fails
    terms = [lack for lack in lacking if not (lack.kind == "delay" and _fails(aligned))]
    found = lacks_check(terms, "missing terms", case.data.axis, case.data.record, case.levels)
    if isinstance(found, Missing) or found.status != "fail":
        return found
    if _fails(method_check(case.preferred, {}, {}, case.steps, case.levels, law_passed=None)):
        return replace(found, status="note")  # what the steps move is left, and counts once
    early = isinstance(aligned, Check) and _fails(aligned) and (aligned.figure or 0.0) < 0
    if early and declared_lateness(case.data) > 0:  # friction is wrong at low speed then
        return replace(
            found,
            status="note",
            meaning=f"{found.meaning}; the delay or lag that is declared too long, see alignment, "
            "may make it: mend that first",
        )
    return found


def _fails(found: Check | Missing | None) -> bool:
    return isinstance(found, Check) and found.status == "fail"


@unless_missing
def lacks_check(
    found: Sequence[Misspecification],
    name: str,
    axis: GeneratedAxis,
    record: Record,
    levels: Levels = DEFAULT_LEVELS,
    *,
    bounded: bool = False,
) -> Check:
    """Whether something of a kind is in the residuals that the model lacks.

    Parameters
    ----------
    found : sequence of Misspecification
        Of any kind.
    name : {"missing terms", "recorded signals", "outliers"}
        A term or a parameter that changes; a recorded signal that is late or of another size; or a
        single sample of what was measured that leaves its course.
    axis : GeneratedAxis
    record : Record
    levels : Levels
    bounded : bool
        Whether the loss has bounded what outliers do, which are no more than a note then.
    """
    own = [lack for lack in found if lack.check == name]
    meaning = "; ".join(sentence(lack, axis, record) for lack in own) or _NOTHING[name]
    if own and name == "recorded signals":
        meaning += f": {_advice(axis, record, own[0])}"
    elif own and name == "outliers" and not bounded:
        meaning += (
            '; empty such cells and read with resample="auto", or let such rows count for '
            'less, loss="huber"'
        )
    return Check(
        name=name,
        status=status_of(not own, matters=not bounded),
        figure=100 * max((lack.own_share for lack in own), default=0.0),
        threshold=100 * levels.least_share,
        p_value=min((lack.p_value for lack in own), default=None),
        source="percent of the force, root mean square; fails where the residuals hold more of it "
        f"than those of twins (Hotelling's test, {100 * levels.level:g} % over all that is looked "
        f"for, by Holm's rule) and it is more than {100 * levels.least_share:g} % of the force "
        "beside what the parameters make of it, or moves one by more than its interval",
        meaning=meaning,
    )


def _advice(axis: GeneratedAxis, record: Record, found: Misspecification) -> str:
    value, deviation, name = found.values[0], found.deviation, found.parameter
    if found.kind == "late signal":
        return advised_shift(name, value, max(MIN_DISTANCE_FROM_NOISE.value * deviation, 0.5))
    column = record.provenance.columns.get(name, "NAME")
    (declared,) = (s for s in axis.axis.signals if s.name == name)
    # A factor within 2 % of that of another unit is that.
    vague = 0.02 + MIN_DISTANCE_FROM_NOISE.value * deviation / abs(value)
    return scale_remedy(name, column, str(declared.unit), 1 / value, vague) or (
        f"check its unit and its scale (columns {name}={column}:UNIT*{value:.4g}), and what is "
        "declared as known of its force"
    )


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
        Diagnostic(
            name="rows",
            check=lambda case: rows_check(
                len(case.preferred.y), len(case.preferred.theta), "record longer, or decimate less"
            ),
        ),
        Diagnostic(name="precision", check=lambda case: precision(case.preferred, case.excitation)),
        Diagnostic(
            name="bounds",
            check=lambda case: within_bounds(
                case.preferred, advice_on_rests(case.problem.rest), case.problem.held
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
            check=lambda case: simulation_error_check(
                case.preferred,
                case.data.rest,
                lacks=case.laws_hold
                and _fails(unless_faulty(lambda: _missing_terms(case.lacking, case))),
            ),
            by_record=True,
        ),
        Diagnostic(name="outliers", check=_outliers, by_record=True),
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
                lacks_check(
                    case.lacking,
                    "recorded signals",
                    case.data.axis,
                    case.data.record,
                    case.levels,
                )
                if case.data.axis.axis.signals
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
            check=lambda case: _missing_terms(case.lacking, case),
            by_record=True,
        ),
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


def diagnose(case: Case) -> Diagnosis:
    """What every diagnostic finds in a result."""
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
            motions=told_or({}, partial(getattr, part, "motions")),
            lack_of_fit=told_or(None, partial(getattr, part, "lack_of_fit")),
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
    fails = ((each.figure is None, i) for i, each in enumerate(found) if each and _fails(each))
    return min(fails, default=(False, 0))[1]


def lack_of_fit_check(found: LackOfFit | None, preferred: Estimate) -> Check | None:
    """How much of what is left is the model's, by what is left again where the motion repeats."""
    if found is None:
        return None
    coordinate = preferred.form.axis.axis.coordinate
    unit = coordinate.acceleration_unit if preferred.is_direct else coordinate.force_unit
    noise = f"{found.noise:.2g} {unit} is noise"
    again = "repeats" if found.period is None else f"repeats every {found.period:.4g} s"
    return Check(
        name="lack of fit",
        status=status_of(not found.is_mostly_model, matters=False),
        figure=100 * found.share,
        threshold=100 * MIN_MODEL_SHARE.value,
        source="percent of the residuals' power that is left again where the reference repeats, "
        "from the products of residuals of different repeats; it counts where noise "
        "repeats as much but for a chance of 1e-3 (HAC over the phases), and where it goes on from "
        "row to row",
        meaning=f"{100 * found.share:.0f} % of what the model leaves is the model: "
        f"{found.repeated:.2g} {unit} ({100 * found.repeated / found.left:.2g} % of the "
        f"{preferred.form.left}) {again}, {noise}"
        if found.is_mostly_model
        else f"{found.repeated:.2g} {unit} of what the model leaves {again} but jumps from "
        f"row to row, as the steps of an encoder do, {noise}"
        if found.is_there and not found.is_smooth
        else f"most of what the model leaves is noise: {found.repeated:.2g} {unit} {again}, {noise}"
        if found.is_there
        else f"what the model leaves is noise: nothing of it {again}, {noise}",
    )


def simulation_error_check(
    preferred: Estimate, rest: float, *, lacks: bool = False
) -> Check | Missing:
    """The simulation error of an estimate.

    Parameters
    ----------
    preferred : Estimate
    rest : float
        Part of the record's samples at which the axis stands.
    lacks : bool
        Whether the model lacks something under a law that is right, from which this follows.
    """
    simulated, form = preferred.simulated, preferred.form
    cause = "mend first what the model lacks, which may make it" * lacks
    if isinstance(simulated, NotSimulated):
        failed = Check(
            name="simulation",
            status="fail",
            source="an axis that was recorded can be simulated",
            meaning="the loop cannot be simulated with the estimate, as that of an axis that was "
            f"recorded can: {str(simulated).removesuffix('.')}{f'; {cause}' * lacks}",
        )
        return failed if simulated.by_estimate else simulated
    error = preferred.simulation_error_percent or 0.0  # none but where nothing was simulated
    good = error < MAX_SIMULATION_ERROR.value
    but = f" but for {error:.2g} %" * (error >= 10.0)  # less is not said
    units = form.axis.axis.coordinate.unit, form.axis.axis.drive.unit
    noise = "".join(f" ({chain.told(*units)})" for chain in preferred.inference.chains[:1])
    blamed = (
        advice_on_rests(rest)
        or cause
        or f"check the law, signs and units, or see whether the record is noise{noise}, or a "
        "motion that the model does not have"
    )
    return Check(
        name="simulation",
        status=status_of(good),
        figure=error,
        threshold=MAX_SIMULATION_ERROR.value,
        source="simulation error in percent of the left side; at 50 the loop explains three "
        "quarters of its power, at 100 nothing",
        meaning=f"the simulated loop follows the record{but}"
        if good
        else f"the simulated loop leaves {error:.3g} % of the {form.left} unexplained; {blamed}",
    )
