"""Checks of a fit: its control law, its residual, and the precision of its parameters."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from axisid.estimation.choices import OPEN_LOOP, POSITION
from axisid.estimation.diagnostics import (
    NOMINAL_VALUES,
    SUDDEN_STEPS,
    RecordRegressor,
    at_bound_check,
    finite,
    misspecification_check,
    moved_parameters_check,
    nominal_check,
    pooling_check,
    pooling_test_of,
    precision_check,
    relative_error,
    repeated_check,
    rows_check,
    sudden_steps_check,
)
from axisid.estimation.diagnostics.control_law import (
    GAINS,
    LawAgreement,
    law_check,
)
from axisid.estimation.estimates import student_interval
from axisid.estimation.findings import SeveralFindings
from axisid.estimation.nonlinear_least_squares import MOST_STEPS
from axisid.estimation.output_residuals import MultipleShootingResiduals, record_rows
from axisid.estimation.records import record_labels
from axisid.estimation.signals import Prefilter
from axisid.estimation.thresholds import (
    ADVISED_WINDOWS,
    MAX_GROWTH,
    MAX_LAW_MOVE,
    MAX_RELATIVE_DEVIATION,
    MIN_DISTANCE_FROM_NOISE,
    MIN_SHOWN,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)
from axisid.estimation.unknowns import GAIN
from axisid.estimation.verdict_checks import Check, NotUsed, joined, made, status_of
from axisid.support.missing import Missing
from axisid.support.one_thread import in_one_thread

from .covariance import UnseenDirection
from .fit_findings import (
    EndOfSearch,
    EndsOfSearches,
    FitPrecision,
    LawCorrection,
    LawSensitivity,
    MovedByLaw,
    NoParameterAtBound,
    OpenLoopWindows,
    OtherCauseOfMissingTerms,
    PriorAndRecord,
    SamplesNearRests,
    ShownParameters,
    SimulatedOutput,
)
from .result import OutputFit

_MAX_BEYOND_NOISE = 15.0  # % of a recorded output: error beyond noise
# % of a recorded output: error including noise; a loop that does not move has 100 %, noise of a
# small motion hardly more
_MAX_ERROR = 120.0
# %, change of a parameter by an error of 1 % in a term of the law; beyond this change, the
# parameters need an exact law
_MAX_LAW_SENSITIVITY = 5.0
_MAX_APART = 0.5  # share of the searches that end above the lowest cost
_SAME_END = 1e-3  # relative difference of costs up to which two searches end at the same minimum

_FACTORS = "law's factors"


@in_one_thread
def judged(of: OutputFit) -> tuple[Check, ...]:
    """Return the checks of a fit that apply, in the order in which they are reported."""
    checks = (made(name, partial(check, of)) for name, check in _CHECKS.items())
    return tuple(check for check in checks if check is not None)


def control_law_check(of: OutputFit) -> Check | Missing:
    """Return the check that the recorded control follows the declared law.

    It is the check of the first record that fails, or of the first record if none fails, with two
    exceptions. The check fails if a plausible explanation of the difference changes a parameter
    beyond its interval. It is a note if the law fails, but each failure has a plausible explanation
    and none changes a parameter so much. Missing if the law cannot be compared.
    """
    check, moved = law_check(of.law), _moved_most(of)
    if isinstance(check, Missing):
        return check
    # One of several records may have passed, and another may have nothing to compare.
    check = replace(check, leaves_open=any(isinstance(law, Missing) for law in of.laws))
    if moved is None:
        return check
    if _is_explained(of) and not moved.is_beyond:
        return replace(check, status="note")
    if moved.is_beyond and check.status != "fail":
        both = SeveralFindings(findings=(check.finding, moved.finding()))
        return replace(check, status="fail", finding=both)
    return check


@dataclass(frozen=True, slots=True, kw_only=True)
class _LargestMove:
    """The parameter that a difference between law and control changes most.

    Attributes
    ----------
    kind : tuple of str
        Kind of the difference, as in `Explanation`.
    place : int
        Index of the parameter.
    parameter : str
        Name of the parameter.
    percent : float or None
        Change relative to the value, %; None for a value of 0.
    far : float
        Change in standard errors.
    is_beyond : bool
        True if the change is beyond the interval.
    """

    kind: tuple[str, ...]
    place: int
    parameter: str
    percent: float | None
    far: float
    is_beyond: bool

    def finding(self, correction: LawCorrection | None = None) -> MovedByLaw:
        """Return the change as a finding, with the correction of the law, if one is advised."""
        return MovedByLaw(
            differences=self.kind,
            parameter=self.parameter,
            percent=self.percent,
            distance=self.far,
            correction=correction,
        )


def _moved_most(of: OutputFit) -> _LargestMove | None:
    """Return the parameter that a plausible explanation of the recorded control changes most.

    Without a plausible explanation, the changes by other gains are used. Changes beyond the
    interval of a parameter come first. None if no change could be calculated, or if no record shows
    a change.
    """
    if isinstance(moves := of.law_moves_by_explanation, Missing):
        return None
    laws = [each for each in of.laws if isinstance(each, LawAgreement)]
    kinds = dict.fromkeys(each.kind for law in laws for each in law.plausible)
    counted = (of.deviations > 0) & ~of.of_start  # an initial state is no property of the axis
    found = []
    for kind in kinds or ((GAINS,),):
        if kind not in moves:
            continue
        # Change in standard errors of the parameter (`claimed`), and in standard errors of the
        # difference between parameter and change (`far`).
        shift, shift_deviations = moves[kind]
        both = np.hypot(of.deviations, shift_deviations)
        claimed = np.divide(np.abs(shift), of.deviations, out=np.zeros(len(shift)), where=counted)
        far = np.divide(np.abs(shift), both, out=np.zeros(len(shift)), where=counted)
        # Of several changes beyond the interval, the largest in standard errors of the parameter.
        beyond = far > MAX_LAW_MOVE.value
        sizes = np.where(beyond, claimed, 0.0) if beyond.any() else far
        j = int(np.argmax(sizes))
        value = of.physical[j]
        found.append(
            _LargestMove(
                kind=kind,
                place=j,
                parameter=of.names[j],
                percent=100 * float(abs(shift[j] / value)) if value else None,
                far=float(far[j]),
                is_beyond=bool(beyond.any()),
            )
        )
    return max(found, key=lambda each: (each.is_beyond, each.far), default=None)


def law_factors_check(of: OutputFit) -> Check | Missing | None:
    """Return the check that the difference between law and control changes no parameter too much.

    The check also fails if each law that fails has a plausible explanation, because the check of
    the law may then be a note. Missing if the changes could not be calculated; None if no record
    shows a difference.
    """
    if isinstance(of.law_moves_by_explanation, Missing):
        return of.law_moves_by_explanation
    moved = _moved_most(of)
    if moved is None:
        return None
    passed = not (moved.is_beyond or _is_explained(of))
    return Check(
        name=_FACTORS,
        status=status_of(passed),
        figure=moved.far,
        threshold=MAX_LAW_MOVE.value,
        source=f"{MAX_LAW_MOVE.source}; also fails if the control law fails but no explanation of "
        "the difference changes a parameter beyond its interval: the check of the law is then a "
        "note",
        finding=moved.finding(None if passed else _correction_of_law(of, moved)),
    )


def _is_explained(of: OutputFit) -> bool:
    """Return True if a law fails and each law that fails has a plausible explanation."""
    failing = [each for each in of.laws if isinstance(each, LawAgreement) and not each.passed]
    return bool(failing) and all(each.plausible for each in failing)


def _correction_of_law(of: OutputFit, moved: _LargestMove) -> LawCorrection:
    """Return the correction of the law: the term that changes the parameter of `moved` most.

    The correction also has the factor of the term in the recorded control. Term and factor are None
    if other gains are not the cause.
    """
    term = factor = None
    if GAINS in moved.kind:
        parts = {
            (name, law.factors[name]): abs(move[moved.place] * (law.factors[name] - 1))
            for law in of.laws
            if isinstance(law, LawAgreement)
            for name, move in of.law_moves.items()
            if name in law.factors
        }
        term, factor = max(parts, key=lambda each: parts[each])
        factor = float(factor)
    return LawCorrection(term=term, factor=factor, follows_position_alone=of.outputs == (POSITION,))


def exact_law_check(of: OutputFit) -> Check | None:
    """Return the check of the parameters' sensitivity to an error of 1 % in a term of the law.

    None if the sensitivity is unknown.
    """
    if not of.law_moves:
        return None
    # Estimated gains are left out: they include the error of the law.
    counted = (of.physical != 0) & ~of.of_start & ~np.isin(of.names, of.estimated_gains.names)
    sizes = np.where(counted, np.abs(of.physical), np.inf)
    shares = {term: 100 * np.abs(move) / sizes for term, move in of.law_moves.items()}
    every = ((float(each.max()), term, int(each.argmax())) for term, each in shares.items())
    share, term, j = max(every, key=lambda each: each[0])
    is_large = share > _MAX_LAW_SENSITIVITY
    return Check(
        name="exact law",
        status=status_of(not is_large, matters=False),
        figure=share,
        threshold=_MAX_LAW_SENSITIVITY,
        source="measured: 0.4 for a fit of the control, 43 for a fit of the position",
        finding=LawSensitivity(term=term, parameter=of.names[j], percent=share, is_large=is_large),
    )


def convergence_check(of: OutputFit) -> Check:
    """Return the check that the search converged."""
    best = of.best
    state: Literal["interrupted", "converged", "not converged"] = "not converged"
    if best.converged:
        state = "converged"
    if of.interrupted:
        state = "interrupted"
    return Check(
        name="convergence",
        status=status_of(state == "converged"),
        figure=float(len(best.steps)),
        threshold=float(MOST_STEPS),
        finding=EndOfSearch(steps=len(best.steps), state=state),
    )


def noise_in_loop_check(of: OutputFit) -> Missing | None:
    """Return the reason why the bias by noise in the loop is unknown, as Missing or NotUsed.

    None if the bias is corrected, or if no replicas were requested. NotUsed if replicas do not
    apply to this fit, or if the output is that of an open loop.
    """
    if not isinstance(of.moved, Missing):
        return None
    reason = f"the bias of the parameters by noise in the loop is unknown: {of.moved.reason}"
    is_unused = isinstance(of.moved, NotUsed) or of.outputs == (OPEN_LOOP,)
    return NotUsed(reason) if is_unused else Missing(reason)


def starts_check(of: OutputFit) -> Check | None:
    """Return the check that several searches end at one minimum; None for a single search."""
    if len(of.searches) < 2:
        return None
    searches = len(of.searches)
    at_best = sum(each.cost <= of.best.cost * (1 + _SAME_END) for each in of.searches)
    share = 1 - at_best / searches
    return Check(
        name="starts",
        status=status_of(share <= _MAX_APART, matters=False),
        figure=share,
        threshold=_MAX_APART,
        source="chosen: above this share, few searches find the lowest minimum",
        finding=EndsOfSearches(at_best=int(at_best), searches=searches),
    )


def windows_check(of: OutputFit) -> Check | None:
    """Return the check that an open loop has enough windows, and that errors do not grow in them.

    None for a closed loop.
    """
    if not isinstance(of.predictions, MultipleShootingResiduals) or of.horizon is None:
        return None
    steady = of.predictions.steady_horizon(of.physical)
    windows, advised = sum(map(len, of.predictions.spans)), ADVISED_WINDOWS.value
    state: Literal["good", "few", "growing"] = "good"
    if windows < advised:
        state = "few"
    if steady < of.horizon:
        state = "growing"
    return Check(
        name="windows",
        status=status_of(state == "good"),
        figure=of.horizon,
        threshold=steady,
        source=MAX_GROWTH.source,
        finding=OpenLoopWindows(
            horizon=float(of.horizon),
            steady_horizon=float(steady),
            max_growth=MAX_GROWTH.value,
            windows=windows,
            advised_windows=int(advised),
            state=state,
        ),
    )


def simulation_check(of: OutputFit) -> Check:
    """Return the check that the simulated output follows the recorded one, except for noise.

    The error beyond noise is limited, because noise may be most of a small output. The error
    including noise has a larger limit, because the oscillation of an unstable loop looks like
    noise.
    """
    is_lost = of.error_percent > _MAX_ERROR
    if is_lost:
        worst = max(of.of_records, key=lambda each: each.percent)
    else:
        worst = max(of.of_records, key=lambda each: each.percent_beyond_noise)
    beyond, output = worst.percent_beyond_noise, worst.output
    percent = max(each.percent for each in of.of_records if each.output == output)
    good = bool(beyond < _MAX_BEYOND_NOISE and not is_lost)
    return Check(
        name="simulation",
        status=status_of(good),
        figure=beyond,
        threshold=_MAX_BEYOND_NOISE,
        source="chosen: the error beyond noise is 4.5 % on the EMPS record, whose model does not "
        "explain 6 % of the control",
        finding=SimulatedOutput(
            output=output,
            percent=finite(percent),
            percent_beyond_noise=finite(beyond),
            follows=good,
        ),
    )


def missing_terms_check(of: OutputFit) -> Check | None:
    """Return the check that no missing term and no fixed value explains part of the residual.

    A failed check becomes a note if a wrong control law, or a bound that the record contradicts, is
    another possible cause. None if the check applies to no record.
    """
    check = joined_check("missing terms", of)
    if check is None or check.status != "fail":
        return check
    # Missing terms bias the gains that are estimated with the parameters.
    law, most = control_law_check(of), MIN_DISTANCE_FROM_NOISE.value
    refuted = [each.name for each in of.held if each.distance > most]
    found_apart = isinstance(of.law, LawAgreement) and of.law.found_apart
    if isinstance(law, Check) and law.status == "fail" and not found_apart:
        cause = OtherCauseOfMissingTerms()
    elif refuted:
        cause = OtherCauseOfMissingTerms(bounds=tuple(refuted))
    else:
        return check
    return replace(check, status="note", finding=SeveralFindings(findings=(check.finding, cause)))


def moved_check(of: OutputFit) -> Check | None:
    """Return the check that missing terms do not bias a parameter too much for its use.

    None if the check applies to no record.
    """
    found = missing_terms_check(of)
    checks = [
        moved_parameters_check(found, lacks, axis, record)
        for lacks, axis, record in zip(of.lacks, of.axes, of.records, strict=True)
    ]
    return joined(checks, record_labels(of.records))


def joined_check(name: str, of: OutputFit) -> Check | None:
    """Return one misspecification check, joined over all records; None if it applies to no record.

    `name` is a name of `misspecification_check`, such as ``missing terms`` or ``outliers``.
    """
    checks = [
        made(name, partial(misspecification_check, lacks, name, axis, record, of.levels))
        for lacks, axis, record in zip(of.lacks, of.axes, of.records, strict=True)
    ]
    return joined(checks, record_labels(of.records))


def steps_check(of: OutputFit) -> Check | None:
    """Return the check that no recorded position has sudden steps; None if it applies nowhere."""
    checks = [
        sudden_steps_check(each, record) for each, record in zip(of.axes, of.records, strict=True)
    ]
    return joined(checks, record_labels(of.records))


def rests_check(of: OutputFit) -> Check | None:
    """Return a note on samples near standstill or velocity reversals; None without such samples."""
    counted, measured = of.judged_sandwich.counted, of.predictions.counted
    share = 1 - np.count_nonzero(counted) / np.count_nonzero(measured)
    if not (share or of.rests_count):
        return None
    return Check(
        name="samples near rests",
        status="note",
        figure=share,
        finding=SamplesNearRests(percent_left_out=100 * float(share)),
    )


def records_alike_check(of: OutputFit) -> Check | Missing | None:
    """Return the check that several records have the same parameters; None for one record.

    The parameters of each record alone are compared with the common parameters, to first order.
    Missing if no record can be tested.
    """
    if len(of.records) < 2:
        return None
    # Parameters that all records must share; then the derivatives of each record's errors by them.
    shared = np.isfinite(of.deviations) & (of.deviations > 0) & ~of.of_start
    shared &= ~np.isin(of.names, (*of.estimated_gains.names, GAIN))
    sandwich, places = of.judged_sandwich, np.flatnonzero(of.unknowns.free & (of.sides == 0))
    records = []
    for spans, every in zip(sandwich.spans, _samples_of_row(of), strict=True):
        span = slice(spans[0].start, spans[-1].stop)
        J = sandwich.jacobian[span]
        # Columns of other records' local parameters are 0 here.
        chosen = np.flatnonzero(shared[places] & J.any(axis=0))
        effects = np.linalg.norm(J * of.physical[places], axis=0)
        records.append(
            RecordRegressor(
                names=tuple(of.names[j] for j in places[chosen]),
                units=tuple(of.unknowns.quantities[j].unit for j in places[chosen]),
                values=of.physical[places[chosen]],
                slopes=np.eye(len(places))[chosen],
                span=span,
                columns=J[:, chosen],
                instruments=J[:, chosen],
                size=float(effects.max(initial=0.0)),
                every=every,
            )
        )
    comparison = pooling_test_of(
        sandwich.jacobian,
        records,
        lambda _, columns: sandwich.extended(columns, clustered=of.horizon is not None),
        of.levels,
    )
    return pooling_check(comparison, record_labels(of.records), of.levels, "output")


# Least variance of the distance from the prior value, relative to the variance of the prior value.
_LEAST_VARIANCE = 1e-2


def known_check(of: OutputFit) -> Check | None:
    """Return the check that prior values agree with the records; None without prior values.

    The distance between prior value and estimate is in standard errors of their difference; the
    parameter with the largest distance is reported.
    """
    if not of.prior:
        return None
    far = dict[str, float]()
    for name, (mean, sd) in of.prior.items():
        alone = of.without_prior.get(name)
        value, deviation = alone or (of[name].value, of[name].deviation)
        # Prior value and estimate are independent without the prior in the estimate; with it, the
        # variance of the difference is the difference of the variances.
        variance = sd**2 + deviation**2 if alone else sd**2 - deviation**2
        far[name] = abs(value - mean) / float(np.sqrt(max(variance, _LEAST_VARIANCE * sd**2)))
    worst, most = max(far, key=far.__getitem__), MIN_DISTANCE_FROM_NOISE.value
    good, (mean, sd) = bool(far[worst] <= most), of.prior[worst]
    of_record, standard_error = of.without_prior.get(worst, (None, None))
    return Check(
        name="what was known",
        status=status_of(good),
        figure=far[worst],
        threshold=most,
        source=MIN_DISTANCE_FROM_NOISE.source,
        finding=PriorAndRecord(
            parameter=worst,
            unit=of[worst].unit,
            prior=mean,
            standard_error=sd,
            of_record=of_record,
            standard_error_of_record=standard_error,
            distance=float(far[worst]),
            agree=good,
        ),
    )


def shown_check(of: OutputFit) -> Check:
    """Return the check that the outputs show every parameter."""
    named = {of.names[j] for j in np.flatnonzero(of.not_shown[1].any(axis=0))}
    lost = [name for name, d in zip(of.names, of.deviations, strict=True) if np.isinf(d)]
    alone = [UnseenDirection(parameters=(name,)) for name in lost if name not in named]
    unseen = (*of.unseen, *alone)
    return Check(
        name="parameters shown",
        status=status_of(not unseen),
        threshold=MIN_SHOWN.value,
        source=MIN_SHOWN.source,
        finding=ShownParameters(outputs=of.outputs, unseen=unseen),
    )


def precise_check(of: OutputFit) -> Check | None:
    """Return the check of the relative standard errors of the free parameters.

    The standard error of a parameter is not limited if the parameter changes the output negligibly,
    also with twice its standard error added. None without free parameters.
    """
    # Effect of each parameter on the output (norm and largest value), relative to the largest.
    parts = np.abs(of.weighing.weights[:, None] * of.best.jacobian * of.physical)
    whole, peak = (
        np.divide(x, x.max() or 1.0) for x in (np.linalg.norm(parts, axis=0), parts.max(axis=0))
    )
    chosen = (of.deviations > 0) & np.isfinite(of.deviations) & ~of.of_start
    if not chosen.any():
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(chosen, of.deviations / np.abs(of.physical), 0.0)
        # `times` is the largest likely value of a parameter, relative to its value.
        times, percent = 1 + 2 * relative, 100 * relative
        small = (whole * times < NEGLIGIBLE_FORCE.value) & (
            peak * times < NEGLIGIBLE_PEAK_FORCE.value
        )
    vague = percent > MAX_RELATIVE_DEVIATION.value
    errors = [relative_error(n, float(p)) for n, p in zip(of.names, percent, strict=True)]
    unidentified = tuple(errors[j] for j in np.flatnonzero(vague & ~small))
    others = percent[~(vague & small)]
    return precision_check(
        float(percent.max()),
        FitPrecision(
            largest_percent=finite(float(np.max(others))) if len(others) else None,
            has_others=bool(len(others)),
            negligible=tuple(errors[j] for j in np.flatnonzero(vague & small)),
            unidentified=unidentified,
        ),
        "relative standard error in percent; not limited for a parameter that changes the output "
        "by less than 1 % of the largest change by a parameter, standard error included",
        passed=not unidentified,
    )


def enough_rows_check(of: OutputFit) -> Check | None:
    """Return a failed check if there are too few independent samples; None otherwise.

    The number of independent samples is the number of rows that `identify` has by default.
    """
    sandwich, every = of.judged_sandwich, _samples_of_row(of)
    counted = [np.count_nonzero(sandwich.counted[record_rows(each)]) for each in sandwich.spans]
    return rows_check(
        sum(int(n) // k for n, k in zip(counted, every, strict=True)),
        len(of.names) - len(of.fixed),
        samples_per_row=max(every) // sandwich.outputs,
    )


def _samples_of_row(of: OutputFit) -> list[int]:
    """Return the number of samples of the outputs that make one row of `identify`, by record."""
    sandwich = of.judged_sandwich
    every = (Prefilter().at_rate_of(period).decimate for period in sandwich.periods)
    return [sandwich.outputs * each for each in every]


def bounds_check(of: OutputFit) -> Check:
    """Return the check that the record does not contradict the bounds at which parameters are."""
    if of.held:
        return at_bound_check(of.held)
    return Check(name="bounds", status="pass", finding=NoParameterAtBound())


def nominal_values_check(of: OutputFit) -> Check | None:
    """Return a note on values of another order of magnitude than declared; None if none is."""
    declared = {p.name: p for p in of.axes[0].axis.parameters}
    return nominal_check(
        (declared[name], each.value, student_interval(each.value, each.deviation, np.inf))
        for name, each in of.parameters.items()
        if name in declared
    )


#: Checks by name, in the order in which they are reported.
_CHECKS: dict[str, Callable[[OutputFit], Check | Missing | None]] = {
    SUDDEN_STEPS: steps_check,
    "control law": control_law_check,
    "windows": windows_check,
    _FACTORS: law_factors_check,
    "exact law": exact_law_check,
    "simulation": simulation_check,
    "missing terms": missing_terms_check,
    "moved parameters": moved_check,
    "outliers": partial(joined_check, "outliers"),
    "what was known": known_check,
    "rows": enough_rows_check,
    "samples near rests": rests_check,
    "repeated records": lambda of: repeated_check(of.records),
    "records alike": records_alike_check,
    "convergence": convergence_check,
    "parameters shown": shown_check,
    "precision": precise_check,
    "bounds": bounds_check,
    NOMINAL_VALUES: nominal_values_check,
    "starts": starts_check,
    "noise in the loop": noise_in_loop_check,
}
