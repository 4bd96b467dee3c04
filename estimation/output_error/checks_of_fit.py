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
from axisid.support.errors import Missing
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

_MAX_BEYOND_NOISE = 15.0  # % of a recorded output, error beyond noise
# % of a recorded output, error with noise; a loop that does not move has 100, noise with a small
# motion hardly more
_MAX_LEFT = 120.0
_MAX_LAW_SENSITIVITY = 5.0  # % by 1 % of a term of the law; beyond, parameters have the law's error
_MAX_APART = 0.5  # of the searches end higher than the best
_SAME_END = 1e-3  # of the least cost, by which another search that ended there may be higher

_FACTORS = "law's factors"


@in_one_thread
def judged(of: OutputFit) -> tuple[Check, ...]:
    """Return the checks, in the order in which they are reported."""
    checks = (made(name, partial(check, of)) for name, check in _CHECKS.items())
    return tuple(check for check in checks if check is not None)


def control_law_check(of: OutputFit) -> Check | Missing:
    """Compare the declared law with the recorded control, by the moves of the parameters.

    It fails where an explanation of the difference that the record cannot exclude moves a parameter
    beyond its interval. It is a note where the law fails, but no such explanation moves any.
    """
    check, moved = law_check(of.law), _moved_most(of)
    if isinstance(check, Missing):
        return check
    # Of several records one may have passed, and another have nothing to compare.
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
    """The parameter that a difference between law and control moves most.

    Attributes
    ----------
    kind : tuple of str
        What differs, as of an `Explanation`.
    place : int
        Of the parameter.
    parameter : str
        Its name.
    percent : float or None
        Of its value by which it moves; None where that is 0.
    far : float
        By which it moves, in standard errors.
    is_beyond : bool
        Whether that is beyond its interval.
    """

    kind: tuple[str, ...]
    place: int
    parameter: str
    percent: float | None
    far: float
    is_beyond: bool

    def finding(self, correction: LawCorrection | None = None) -> MovedByLaw:
        """Return it as a finding."""
        return MovedByLaw(
            differences=self.kind,
            parameter=self.parameter,
            percent=self.percent,
            distance=self.far,
            correction=correction,
        )


def _moved_most(of: OutputFit) -> _LargestMove | None:
    """Return the largest move by explanations that the records do not exclude; None without any."""
    if isinstance(moves := of.law_moves_by_explanation, Missing):
        return None
    laws = [each for each in of.laws if isinstance(each, LawAgreement)]
    kinds = dict.fromkeys(each.kind for law in laws for each in law.plausible)
    counted = (of.deviations > 0) & ~of.of_start  # a record's own start is no property
    found = []
    for kind in kinds or ((GAINS,),):
        if kind not in moves:
            continue
        shift, shift_deviations = moves[kind]
        claimed, far = (
            np.divide(np.abs(shift), sizes, out=np.zeros(len(shift)), where=counted)
            for sizes in (of.deviations, np.hypot(of.deviations, shift_deviations))
        )
        beyond = far > MAX_LAW_MOVE.value
        j = int(np.argmax(np.where(beyond, claimed, 0.0) if beyond.any() else far))
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
    """Return the check of the moves by the difference between law and recorded control."""
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
        source=f"{MAX_LAW_MOVE.source}; fails too "
        "where the control law fails but no explanation of that moves a parameter beyond its "
        "interval, for which the check of the law is a note",
        finding=moved.finding(None if passed else _correction_of_law(of, moved)),
    )


def _is_explained(of: OutputFit) -> bool:
    """Tell whether a law fails, and each that fails has an explanation."""
    failing = [each for each in of.laws if isinstance(each, LawAgreement) and not each.passed]
    return bool(failing) and all(each.plausible for each in failing)


def _correction_of_law(of: OutputFit, moved: _LargestMove) -> LawCorrection:
    """Return the term of the law whose difference moves a parameter most, if gains differ."""
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
    """Return the check of the parameters' sensitivity to an error of the law."""
    if not of.law_moves:
        return None
    # A gain that is estimated measures the law's error itself.
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
        source="measured: 0.4 where the control is followed, 43 where the position is",
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
    """Return the reason why the bias by noise in the loop is unknown; a known one is corrected."""
    if not isinstance(of.moved, Missing):
        return None
    said = f"the bias of the parameters by noise in the loop is unknown: {of.moved.reason}"
    is_unused = isinstance(of.moved, NotUsed) or of.outputs == (OPEN_LOOP,)
    return NotUsed(said) if is_unused else Missing(said)


def starts_check(of: OutputFit) -> Check | None:
    """Return the check that several searches end at one minimum."""
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
        source="chosen: few searches then find the best minimum",
        finding=EndsOfSearches(at_best=int(at_best), searches=searches),
    )


def windows_check(of: OutputFit) -> Check | None:
    """Return the check that windows of an open loop are enough, and errors do not grow in them."""
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
    """Return the check of the error beyond noise, which may be most of a small or noisy output."""
    # A loop that oscillates takes its oscillation for noise, and has errors above 100 %.
    lost = of.error_percent > _MAX_LEFT
    worst = max(of.of_records, key=lambda each: each.percent if lost else each.percent_beyond_noise)
    beyond, output = worst.percent_beyond_noise, worst.output
    percent = max(each.percent for each in of.of_records if each.output == output)
    good = bool(beyond < _MAX_BEYOND_NOISE and not lost)
    return Check(
        name="simulation",
        status=status_of(good),
        figure=beyond,
        threshold=_MAX_BEYOND_NOISE,
        source="chosen: it is 4.5 on the EMPS record, whose model lacks 6 % of the control",
        finding=SimulatedOutput(
            output=output,
            percent=finite(percent),
            percent_beyond_noise=finite(beyond),
            follows=good,
        ),
    )


def missing_terms_check(of: OutputFit) -> Check | None:
    """Return the check that the residual has no force of the motion, nor of a fixed value."""
    check = joined_check("missing terms", of)
    if check is None or check.status != "fail":
        return check
    # Missing terms move the gains that are estimated with them.
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
    """Return the check that missing terms do not move a parameter so far as to be useless."""
    found = missing_terms_check(of)
    checks = [moved_parameters_check(found, lacks) for lacks in of.lacks]
    return joined(checks, record_labels(of.records))


def joined_check(name: str, of: OutputFit) -> Check | None:
    """Return the check of the misspecification of one name, over all records."""
    checks = [
        made(name, partial(misspecification_check, lacks, name, axis, record, of.levels))
        for lacks, axis, record in zip(of.lacks, of.axes, of.records, strict=True)
    ]
    return joined(checks, record_labels(of.records))


def steps_check(of: OutputFit) -> Check | None:
    """Check each recorded position for sudden steps."""
    checks = [
        sudden_steps_check(each, record) for each, record in zip(of.axes, of.records, strict=True)
    ]
    return joined(checks, record_labels(of.records))


def rests_check(of: OutputFit) -> Check | None:
    """Return a note on samples near rests; None without any."""
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
    """Return the check that each of several records has the parameters of the others."""
    if len(of.records) < 2:
        return None
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


_LEAST_VARIANCE = 1e-2  # of the prior: the least variance of an estimate's distance from it


def known_check(of: OutputFit) -> Check | None:
    """Compare the prior values with the records."""
    if not of.prior:
        return None
    far = dict[str, float]()
    for name, (mean, sd) in of.prior.items():
        alone = of.without_prior.get(name)
        value, deviation = alone or (of[name].value, of[name].deviation)
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
    """Compare every parameter that is searched, and shown, with its standard error."""
    parts = np.abs(of.weighing.weights[:, None] * of.best.jacobian * of.physical)
    whole, peak = (
        np.divide(x, x.max() or 1.0) for x in (np.linalg.norm(parts, axis=0), parts.max(axis=0))
    )
    chosen = (of.deviations > 0) & np.isfinite(of.deviations) & ~of.of_start
    if not chosen.any():
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(chosen, of.deviations / np.abs(of.physical), 0.0)
        times, percent = 1 + 2 * relative, 100 * relative  # of what it may be, by what it is
        small = (whole * times < NEGLIGIBLE_FORCE.value) & (
            peak * times < NEGLIGIBLE_PEAK_FORCE.value
        )
    vague = percent > MAX_RELATIVE_DEVIATION.value
    errors = [relative_error(n, float(p)) for n, p in zip(of.names, percent, strict=True)]
    unidentified = tuple(errors[j] for j in np.flatnonzero(vague & ~small))
    return precision_check(
        float(percent.max()),
        FitPrecision(
            largest_percent=finite(float(np.max(percent[~(vague & small)], initial=0.0))),
            negligible=tuple(errors[j] for j in np.flatnonzero(vague & small)),
            unidentified=unidentified,
        ),
        "relative standard error in percent; not limited for a parameter that changes the output "
        "by less than 1 % of the largest change by a parameter, standard error included",
        passed=not unidentified,
    )


def enough_rows_check(of: OutputFit) -> Check | None:
    """Return a failed check where independent samples are too few; None otherwise.

    As many samples count as `identify` has rows by default.
    """
    sandwich, every = of.judged_sandwich, _samples_of_row(of)
    counted = [np.count_nonzero(sandwich.counted[record_rows(each)]) for each in sandwich.spans]
    return rows_check(
        sum(int(n) // k for n, k in zip(counted, every, strict=True)),
        len(of.names) - len(of.fixed),
        samples_per_row=max(every) // sandwich.outputs,
    )


def _samples_of_row(of: OutputFit) -> list[int]:
    """Return by record the number of samples of the outputs that count as one row of `identify`."""
    sandwich = of.judged_sandwich
    every = (Prefilter().at_rate_of(period).decimate for period in sandwich.periods)
    return [sandwich.outputs * each for each in every]


def bounds_check(of: OutputFit) -> Check:
    """Return the check of parameters at their bounds, by chance or against the record."""
    if of.held:
        return at_bound_check(of.held)
    return Check(name="bounds", status="pass", finding=NoParameterAtBound())


def nominal_values_check(of: OutputFit) -> Check | None:
    """Return a note on values of another order of magnitude than declared; None without any."""
    declared = {p.name: p for p in of.axes[0].axis.parameters}
    return nominal_check(
        (declared[name], each.value, student_interval(each.value, each.deviation, np.inf))
        for name, each in of.parameters.items()
        if name in declared
    )


#: By name, in the order in which they are reported.
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
