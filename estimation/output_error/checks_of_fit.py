"""Checks of a fit: its law, what it leaves, how surely it shows what it says."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from axisid.estimation.choices import OPEN_LOOP, POSITION
from axisid.estimation.diagnostics import (
    NOMINAL_VALUES,
    SUDDEN_STEPS,
    RecordRegressor,
    at_bound_check,
    misspecification_check,
    moved_parameters_check,
    nominal_check,
    pooling_check,
    pooling_test_of,
    precision_check,
    repeated_check,
    rows_check,
    sudden_steps_check,
)
from axisid.estimation.diagnostics.control_law import (
    CONSTANT,
    DRIFT,
    GAINS,
    SCALE,
    LawAgreement,
    law_check,
)
from axisid.estimation.estimates import student_interval
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

from .result import OutputFit

_MAX_BEYOND_NOISE = 15.0  # % of a recorded output, left beyond noise
# % of a recorded output left with noise; a loop that does nothing leaves 100, noise beside a
# small motion hardly more
_MAX_LEFT = 120.0
_MAX_LAW_SENSITIVITY = 5.0  # % by 1 % of a term of the law; beyond, its error is the numbers'
_MAX_APART = 0.5  # of the searches end higher than the best
_SAME_END = 1e-3  # of the least cost, by which another search that ended there may be higher

_FACTORS = "law's factors"
#: What may differ between the recorded control and the law, and what to do about it.
_DIFFERENCES = {
    GAINS: "other gains of the law",
    SCALE: "another scale of the control",
    CONSTANT: "a constant on the control",
    DRIFT: "a drift of the control",
}
_REMEDIES = {
    SCALE: "check the unit and the scaling of the recorded control",
    CONSTANT: "check the offset of the recorded control, and the zero of the position",
    DRIFT: "check whether the recorded control drifts",
}


@in_one_thread
def judged(of: OutputFit) -> tuple[Check, ...]:
    """The checks, in the order in which they are told."""
    checks = (made(name, partial(check, of)) for name, check in _CHECKS.items())
    return tuple(check for check in checks if check is not None)


def control_law_check(of: OutputFit) -> Check | Missing:
    """The declared law against the recorded control, by what each explanation of it moves.

    It fails where one that the record cannot exclude moves a parameter beyond its interval. It is a
    note where the law fails, but no such explanation moves any.
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
        return replace(check, status="fail", meaning=f"{check.meaning}; but {moved.said}")
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
    far : float
        By how many deviations it moves.
    is_beyond : bool
        Whether that is beyond its interval.
    said : str
        In words.
    """

    kind: tuple[str, ...]
    place: int
    far: float
    is_beyond: bool
    said: str


def _moved_most(of: OutputFit) -> _LargestMove | None:
    """The largest move of the explanations that the records cannot tell apart; None without any."""
    if isinstance(moves := of.law_moves_by_explanation, Missing):
        return None
    laws = [each for each in of.laws if isinstance(each, LawAgreement)]
    kinds = dict.fromkeys(each.kind for law in laws for each in law.plausible)
    counted = (of.deviations > 0) & ~of.of_start  # a record's own start is no property
    found = []
    for kind in kinds or {(GAINS,): None}:
        if kind not in moves:
            continue
        shift, shift_deviations = moves[kind]
        claimed, far = (
            np.divide(np.abs(shift), sizes, out=np.zeros(len(shift)), where=counted)
            for sizes in (of.deviations, np.hypot(of.deviations, shift_deviations))
        )
        beyond = far > MAX_LAW_MOVE.value
        j = int(np.argmax(np.where(beyond, claimed, 0.0) if beyond.any() else far))
        name, value = of.names[j], of.physical[j]
        share = 100 * abs(shift[j] / value) if value else np.inf
        said = (
            f"{' and '.join(_DIFFERENCES[each] for each in kind)}, as the control is recorded, "
            f"moves {name} by {share:.2g} % ({far[j]:.2g} deviations)"
        )
        worst = _LargestMove(
            kind=kind, place=j, far=float(far[j]), is_beyond=bool(beyond.any()), said=said
        )
        found.append(worst)
    return max(found, key=lambda each: (each.is_beyond, each.far), default=None)


def law_factors_check(of: OutputFit) -> Check | Missing | None:
    """What the difference between the law and the recorded control moves the parameters by."""
    if isinstance(of.law_moves_by_explanation, Missing):
        return of.law_moves_by_explanation
    moved = _moved_most(of)
    if moved is None:
        return None
    is_explained = _is_explained(of)
    advice = f": {_advice_on_law(of, moved)}" * (moved.is_beyond or is_explained)
    return Check(
        name=_FACTORS,
        status=status_of(not (moved.is_beyond or is_explained)),
        figure=moved.far,
        threshold=MAX_LAW_MOVE.value,
        source=f"{MAX_LAW_MOVE.source}; fails too "
        "where the control law fails but what explains that moves no parameter beyond its "
        "interval, for which the check of the law is a note",
        meaning=moved.said + advice,
    )


def _is_explained(of: OutputFit) -> bool:
    """Whether a law fails, and each that does has an explanation."""
    failing = [each for each in of.laws if isinstance(each, LawAgreement) and not each.passed]
    return bool(failing) and all(each.plausible for each in failing)


def _advice_on_law(of: OutputFit, moved: _LargestMove) -> str:
    """What to do about what moves a parameter most."""
    advice = [_REMEDIES[each] for each in moved.kind if each != GAINS]
    if GAINS in moved.kind:
        parts = {
            (term, law.factors[term]): abs(move[moved.place] * (law.factors[term] - 1))
            for law in of.laws
            if isinstance(law, LawAgreement)
            for term, move in of.law_moves.items()
            if term in law.factors
        }
        term, factor = max(parts, key=lambda each: parts[each])
        instead = ", follow the control" if of.outputs == (POSITION,) else ""
        advice.append(
            f"most by {term} ({factor:.5g} times the declared in the record): correct that, free "
            f"the law's gains{instead}, or identify by instruments, which ask for no exact law"
        )
    return "; ".join(advice)


def exact_law_check(of: OutputFit) -> Check | None:
    """How exact the law has to be."""
    if not of.law_moves:
        return None
    # A gain that is found is what the law's error is told by.
    counted = (of.physical != 0) & ~of.of_start & ~np.isin(of.names, of.estimated_gains.names)
    sizes = np.where(counted, np.abs(of.physical), np.inf)
    shares = {term: 100 * np.abs(move) / sizes for term, move in of.law_moves.items()}
    every = ((float(each.max()), term, int(each.argmax())) for term, each in shares.items())
    share, term, j = max(every, key=lambda each: each[0])
    said = f"a law whose {term} is 1 % other than declared moves {of.names[j]} by {share:.2g} %"
    if share > _MAX_LAW_SENSITIVITY:
        said += ": the law must be right, or the numbers are its error"
    return Check(
        name="exact law",
        status=status_of(share <= _MAX_LAW_SENSITIVITY, matters=False),
        figure=share,
        threshold=_MAX_LAW_SENSITIVITY,
        source="measured: 0.4 where the control is followed, 43 where the position is",
        meaning=said,
    )


def convergence_check(of: OutputFit) -> Check:
    """Whether the search came to an end."""
    best = of.best
    if of.interrupted:
        said = (
            f"the search was interrupted after {len(best.steps)} steps, and these are the best "
            "values so far; to go on, fit again and start from them"
        )
    elif best.converged:
        said = f"the search stands still after {len(best.steps)} steps"
    else:
        said = (
            f"the search still moves after {len(best.steps)} steps; start elsewhere, or leave out "
            "what the record does not show"
        )
    return Check(
        name="convergence",
        status=status_of(best.converged and not of.interrupted),
        figure=float(len(best.steps)),
        threshold=float(MOST_STEPS),
        meaning=said,
    )


def noise_in_loop_check(of: OutputFit) -> Missing | None:
    """Why it is not known what noise in the loop moves; what is known is taken off."""
    if not isinstance(of.moved, Missing):
        return None
    said = f"what noise makes of the parameters is not known: {of.moved.reason}"
    is_unused = isinstance(of.moved, NotUsed) or of.outputs == (OPEN_LOOP,)
    return NotUsed(said) if is_unused else Missing(said)


def starts_check(of: OutputFit) -> Check | None:
    """Whether several searches end at one place."""
    if len(of.searches) < 2:
        return None
    ended = sum(each.cost <= of.best.cost * (1 + _SAME_END) for each in of.searches)
    share = 1 - ended / len(of.searches)
    return Check(
        name="starts",
        status=status_of(share <= _MAX_APART, matters=False),
        figure=share,
        threshold=_MAX_APART,
        source="chosen: the lowest end is then found by few",
        meaning=f"{ended} of {len(of.searches)} searches ended here, the others higher",
    )


def windows_check(of: OutputFit) -> Check | None:
    """Whether nothing drives the axis away in the windows of an open loop, and they are enough."""
    if not isinstance(of.predictions, MultipleShootingResiduals) or of.horizon is None:
        return None
    steady = of.predictions.steady_horizon(of.physical)
    windows, advised = sum(map(len, of.predictions.spans)), ADVISED_WINDOWS.value
    said = f"windows of {of.horizon:g} s are short enough that errors do not grow in them"
    if windows < advised:
        several = "1 window is" if windows == 1 else f"{windows} windows are"
        said = (
            f"{several} too few to tell deviations, or what the model lacks; follow a longer "
            "record, or shorter windows (horizon=SECONDS)"
        )
    if steady < of.horizon:
        said = (
            f"errors grow more than {MAX_GROWTH.value:g} times in windows of {of.horizon:g} s, as "
            f"where friction falls with the velocity; use horizon={steady:g}"
        )
    return Check(
        name="windows",
        status=status_of(steady >= of.horizon and windows >= advised),
        figure=of.horizon,
        threshold=steady,
        source=MAX_GROWTH.source,
        meaning=said,
    )


def simulation_check(of: OutputFit) -> Check:
    """What is left beyond noise: noise may be most of an output that is small, or noisy."""
    # A loop that swings by itself takes its swinging for noise, and leaves more than there is.
    lost = of.error_percent > _MAX_LEFT
    worst = max(of.of_records, key=lambda each: each.percent if lost else each.percent_beyond_noise)
    beyond, output = worst.percent_beyond_noise, worst.output
    percent = max(each.percent for each in of.of_records if each.output == output)
    good = beyond < _MAX_BEYOND_NOISE and not lost
    more = "" if good else ": it does not follow it; check the model, the law, units and signs"
    return Check(
        name="simulation",
        status=status_of(good),
        figure=beyond,
        threshold=_MAX_BEYOND_NOISE,
        source="chosen: it is 4.5 on the EMPS record, whose model lacks 6 % of the control",
        meaning=f"the simulated {output} leaves {percent:.3g} % of the recorded one, "
        f"{beyond:.2g} % beyond noise{more}",
    )


def missing_terms_check(of: OutputFit) -> Check | None:
    """Whether what is left goes with a force of the motion, or with a value that is held."""
    check = joined_check("missing terms", of)
    if check is None or check.status != "fail":
        return check
    # What the model lacks moves the gains that are found with it.
    law, most = control_law_check(of), MIN_DISTANCE_FROM_NOISE.value
    refuted = [each.name for each in of.held if each.distance > most]
    found_apart = isinstance(of.law, LawAgreement) and of.law.found_apart
    if isinstance(law, Check) and law.status == "fail" and not found_apart:
        more = ". The law is not the record's, which asks for such forces too"
    elif refuted:
        more = f". The bound of {' and '.join(refuted)} leaves such forces too: mend that first"
    else:
        return check
    return replace(check, status="note", meaning=check.meaning + more)


def moved_check(of: OutputFit) -> Check | None:
    """Whether what the model lacks moves a parameter so far that its value means nothing."""
    found = missing_terms_check(of)
    checks = [moved_parameters_check(found, lacks) for lacks in of.lacks]
    return joined(checks, record_labels(of.records))


def joined_check(name: str, of: OutputFit) -> Check | None:
    """What is checked of what the model lacks, over all records."""
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
    """How many samples have no weight, as they are near rests."""
    counted, measured = of.judged_sandwich.counted, of.predictions.counted
    share = 1 - np.count_nonzero(counted) / np.count_nonzero(measured)
    if not (share or of.rests_count):
        return None
    said = (
        f"{100 * share:.2g} % of the samples have no weight: they are near rests or reversals "
        "of the record or of its loop, where friction takes any force"
        if share
        else "samples near rests and reversals count, as without them a parameter is hardly shown; "
        "behind an encoder they mislead: record longer or faster moves"
    )
    return Check(name="samples near rests", status="note", figure=share, meaning=said)


def records_alike_check(of: OutputFit) -> Check | Missing | None:
    """Whether each of several records has the parameters of the others."""
    if len(of.records) < 2:
        return None
    shared = np.isfinite(of.deviations) & (of.deviations > 0) & ~of.of_start
    shared &= ~np.isin(of.names, (*of.estimated_gains.names, GAIN))
    sandwich, places = of.judged_sandwich, np.flatnonzero(of.unknowns.free & (of.sides == 0))
    records = []
    for spans, every in zip(sandwich.spans, _samples_of_row(of), strict=True):
        span = slice(spans[0].start, spans[-1].stop)
        J = sandwich.jacobian[span]
        # Others' local ones are nothing here.
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


_LEAST_VARIANCE = 1e-2  # of what was known: the least of how far an estimate may be from it


def known_check(of: OutputFit) -> Check | None:
    """What was known before against what the records tell."""
    if not of.prior:
        return None
    far = dict[str, float]()
    for name, (mean, sd) in of.prior.items():
        alone = of.without_prior.get(name)
        value, deviation = alone or (of[name].value, of[name].deviation)
        variance = sd**2 + deviation**2 if alone else sd**2 - deviation**2
        far[name] = abs(value - mean) / float(np.sqrt(max(variance, _LEAST_VARIANCE * sd**2)))
    worst, most = max(far, key=far.__getitem__), MIN_DISTANCE_FROM_NOISE.value
    good, (mean, sd), record = far[worst] <= most, of.prior[worst], "the record"
    if worst in of.without_prior:
        value, deviation = of.without_prior[worst]
        record = f"what the record alone says, {value:.6g} +- {deviation:.2g},"
    return Check(
        name="what was known",
        status=status_of(good),
        figure=far[worst],
        threshold=most,
        source=MIN_DISTANCE_FROM_NOISE.source,
        meaning=f"what was known of {worst}, {mean:.6g} +- {sd:.2g}, and {record} are "
        f"{far[worst]:.2g} deviations apart"
        + ("" if good else ": they contradict each other; one is wrong, or the model"),
    )


def shown_check(of: OutputFit) -> Check:
    """Whether the outputs show every parameter."""
    several = len(of.outputs) > 1
    named = {of.names[j] for j in np.flatnonzero(of.not_shown[1].any(axis=0))}
    lost = [name for name, d in zip(of.names, of.deviations, strict=True) if np.isinf(d)]
    unseen = [*of.unseen, *(f"{name} at all" for name in lost if name not in named)]
    said = (
        f"the {of.output} {'do' if several else 'does'} not show {'; nor '.join(unseen)}; hold one "
        f"with fix {unseen[0].split()[0]}=VALUE, or record another motion."
        if unseen
        else f"the {of.output} show{'' if several else 's'} every parameter"
    )
    return Check(
        name="parameters shown",
        status=status_of(not unseen),
        threshold=MIN_SHOWN.value,
        source=MIN_SHOWN.source,
        meaning=said,
    )


def precise_check(of: OutputFit) -> Check | None:
    """Every parameter that is searched, and shown, against its own deviation."""
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
    every = [*zip(of.names, map(float, percent), vague, small, strict=True)]
    return precision_check(
        float(percent.max()),
        [
            f"{name} is not identified by what is followed: its deviation is {share:.3g} % of it"
            for name, share, is_vague, is_small in every
            if is_vague and not is_small
        ],
        [name for name, _, is_vague, is_small in every if is_vague and is_small],
        "largest part that a parameter has of the output",
        "relative deviation in percent; a parameter that changes the output by less than 1 % of "
        "what the largest does, deviation included, may be as vague as it is",
    )


def enough_rows_check(of: OutputFit) -> Check | None:
    """Whether samples are enough, of which as many count as `identify` has rows by default."""
    sandwich, every = of.judged_sandwich, _samples_of_row(of)
    counted = [np.count_nonzero(sandwich.counted[record_rows(each)]) for each in sandwich.spans]
    return rows_check(
        sum(int(n) // k for n, k in zip(counted, every, strict=True)),
        len(of.names) - len(of.fixed),
        f"one sample in {max(every) // sandwich.outputs} counts, as its neighbours say little "
        "more; follow a longer part of the record",
    )


def _samples_of_row(of: OutputFit) -> list[int]:
    """How many samples of the outputs count as one row of `identify`, by record."""
    sandwich = of.judged_sandwich
    every = (Prefilter().at_rate_of(period).decimate for period in sandwich.periods)
    return [sandwich.outputs * each for each in every]


def bounds_check(of: OutputFit) -> Check:
    """Parameters at their bounds: what chance takes there, or what contradicts the bound."""
    if of.held:
        return at_bound_check(of.held)
    return Check(name="bounds", status="pass", meaning="no parameter is driven to a bound")


def nominal_values_check(of: OutputFit) -> Check | None:
    """Values of another order of size than declared."""
    declared = {p.name: p for p in of.axes[0].axis.parameters}
    return nominal_check(
        (declared[name], each.value, student_interval(each.value, each.deviation, np.inf))
        for name, each in of.parameters.items()
        if name in declared
    )


#: By name, in the order in which they are told.
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
