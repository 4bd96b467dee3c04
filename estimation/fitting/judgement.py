"""Whether a fit is to be believed."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import Check, passed
from axisid.estimation.choices.outputs import POSITION
from axisid.estimation.diagnostics import repeated_check
from axisid.estimation.diagnostics.estimates import precision_check
from axisid.estimation.diagnostics.law import LawCheck, law_check
from axisid.estimation.estimates import few_rows
from axisid.estimation.freed import START
from axisid.estimation.joint import GAIN
from axisid.estimation.predictions import WindowPredictions
from axisid.estimation.records import Record
from axisid.estimation.thresholds.diagnostics import (
    MAX_RELATIVE_DEVIATION,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)
from axisid.estimation.thresholds.estimates import (
    MIN_DISTANCE_FROM_NOISE,
    MIN_ROWS_PER_PARAMETER,
)
from axisid.estimation.thresholds.fitting import (
    ADVISED_WINDOWS,
    LACKING_LEVEL,
    MAX_APART,
    MAX_BEYOND_NOISE,
    MAX_FAR,
    MAX_GROWTH,
    MAX_LAW_SENSITIVITY,
    MAX_LAW_SHIFT,
    MAX_LEFT,
    MIN_FAR,
    MIN_MOVED_BY_NOISE,
    MIN_MOVED_BY_START,
    MIN_SHOWN,
    SAME_END,
)
from axisid.estimation.told_by_outputs import Lack, alike_by_outputs, others_in_records
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Note, Remedy, Setting

from .basis import FitBasis
from .search import MOST_STEPS

_SURE = 1e-2  # of a variance: the least by which what was known is moved


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """What a fit is judged by."""

    outputs: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    physical: Array
    deviations: Array
    basis: FitBasis
    at_bound: Mapping[str, str]
    unseen: tuple[str, ...]
    law: LawCheck | Missing
    found_gains: tuple[str, ...]  # of the law
    law_moves: Mapping[str, Array]
    law_move: tuple[Array, Array] | None
    percents: tuple[float, ...]
    beyond_noise: tuple[float, ...]
    followed: tuple[str, ...]
    lacks: tuple[Lack, ...] | Missing
    prior: Mapping[str, tuple[float, float]]
    records: tuple[Record, ...]
    horizon: float | None
    searched: int  # parameters that are free


def judged(of: Judged) -> tuple[Check, ...]:
    """The checks, in the order in which they are told."""
    return (
        _law(of),
        *_steady(of),
        *_moved(of),
        *_sensitive(of),
        _follows(of),
        _lacking(of),
        *_known(of),
        *_rows(of),
        *_repeated(of),
        *_alike(of),
        _ended(of),
        _shown(of),
        *_none_shown(of),
        *_as_low(of),
        *_precise(of),
        _bounds(of),
        *_starts(of),
        *_begun(of),
        *_shaken(of),
    )


def _law(of: Judged) -> Check:
    found = law_check(of.law)
    return found if isinstance(found, Check) else Check.not_evaluated("control law", found)


def _steady(of: Judged) -> Iterator[Check]:
    """Whether windows of an open loop are so short that nothing drives the axis away in them."""
    if not isinstance(of.basis.predictions, WindowPredictions) or of.horizon is None:
        return
    try:
        steady = of.basis.predictions.steady_horizon(of.physical)
    except EstimationError as lost:
        yield Check.not_evaluated("windows", Missing.of(lost.note))
        return
    good, remedy = steady >= of.horizon, None
    said = f"windows of {of.horizon:g} s are short enough that errors do not grow in them"
    if not good:
        said = (
            f"errors grow more than {MAX_GROWTH.value:g} times in windows of {of.horizon:g} s, as "
            "where friction falls with the velocity; "
        )
        remedy = Remedy.of("use ", Setting("horizon", f"{steady:g}"), ".")
    yield Check(
        name="windows",
        status=passed(good),
        figure=of.horizon,
        threshold=steady,
        source=MAX_GROWTH.source,
        meaning=said,
        remedy=remedy,
    )


def _moved(of: Judged) -> Iterator[Check]:
    """What the law as it is in the record moves the parameters by."""
    if of.law_move is None:
        return
    moved, sure = of.law_move
    with np.errstate(divide="ignore", invalid="ignore"):
        claimed = np.nan_to_num(np.abs(moved) / of.deviations, posinf=np.inf)
        far = np.nan_to_num(np.abs(moved) / np.hypot(of.deviations, sure), posinf=np.inf)
    counted = (of.deviations > 0) & ~of.basis.of_start  # a record's own start is no property
    claimed, far = (np.where(counted, each, 0.0) for each in (claimed, far))
    most = MAX_LAW_SHIFT.value
    worst = int(np.argmax(np.where(far > most, claimed, 0.0) if np.any(far > most) else far))
    name, value = of.names[worst], of.physical[worst]
    share = 100 * abs(moved[worst] / value) if value else np.inf
    beyond = far[worst] > most
    said = (
        f"the law as its control is recorded, in place of the declared one, moves {name} by "
        f"{share:.2g} % ({far[worst]:.2g} deviations)"
    )
    if beyond:
        instead = ", follow the control" if of.outputs == (POSITION,) else ""
        said += (
            f": correct the gains of the declared law, free them{instead}, or identify by "
            "instruments, which ask for no exact law"
        )
    yield Check(
        name="law's factors",
        status=passed(not beyond),
        figure=float(far[worst]),
        threshold=most,
        source=MAX_LAW_SHIFT.source,
        meaning=said,
    )


def _sensitive(of: Judged) -> Iterator[Check]:
    """How exact the law has to be."""
    if not of.law_moves:
        return
    sizes = np.abs(of.physical)
    # A gain that is found is what the law's error is told by.
    found = np.isin(of.names, of.found_gains)
    counted = (sizes > 0) & ~of.basis.of_start & ~found
    sizes = np.where(counted, sizes, np.inf)
    shares = {name: 100 * np.abs(move) / sizes for name, move in of.law_moves.items()}
    term = max(shares, key=lambda name: float(shares[name].max()))
    j = int(np.argmax(shares[term]))
    share, most = float(shares[term][j]), MAX_LAW_SENSITIVITY.value
    said = f"a law whose {term} is 1 % other than declared moves {of.names[j]} by {share:.2g} %"
    if share > most:
        exact = "the law must be exact" if of.outputs == (POSITION,) else "the law must be right"
        moved = abs(float(of.law_moves[term][j]))
        if 0 < of.deviations[j] < moved:
            enough = float(f"{of.deviations[j] / moved:.2g}")
            said += f", and {enough:g} % by its whole deviation, which supposes the declared law"
        said += f": {exact}, or the numbers are its error"
    yield Check(
        name="exact law",
        status=passed(share <= most, matters=False),
        figure=share,
        threshold=most,
        source=MAX_LAW_SENSITIVITY.source,
        meaning=said,
    )


def _follows(of: Judged) -> Check:
    """What is left beyond noise: noise may be most of an output that is small, or noisy."""
    most = MAX_BEYOND_NOISE.value
    # A loop that swings by itself takes its swinging for noise, and leaves more than there is.
    lost = max(of.percents) > MAX_LEFT.value
    worst = int(np.argmax(of.percents if lost else of.beyond_noise))
    beyond, output = of.beyond_noise[worst], of.followed[worst]
    percent = max(p for p, name in zip(of.percents, of.followed, strict=True) if name == output)
    good = beyond < most and not lost
    said = (
        f"the simulated {output} leaves {percent:.3g} % of the recorded one, "
        f"{beyond:.2g} % beyond noise"
    )
    more = "" if good else ": it does not follow it; check the model, the law, units and signs"
    return Check(
        name="simulation",
        status=passed(good),
        figure=beyond,
        threshold=most,
        source=MAX_BEYOND_NOISE.source,
        meaning=said + more,
    )


def _lacking(of: Judged) -> Check:
    """Whether what is left goes with a force of the motion, or with a value that is held."""
    name, level = "missing terms", LACKING_LEVEL.value
    few = _few_windows(of)
    if isinstance(of.lacks, Missing):
        more = Note.of("; ", _shorter(of)) if few else None
        return Check.not_evaluated(name, Missing.of(Note.of(of.lacks.note, more)))
    there = [lack for lack in of.lacks if lack.is_there]
    # What the model lacks moves the gains that are found with it.
    moved_gains = isinstance(of.law, LawCheck) and of.law.found_apart
    wrong_law = _law(of).status == "fail" and not moved_gains
    most = MIN_DISTANCE_FROM_NOISE.value
    refuted = [name for name, beyond in of.basis.beyond.items() if beyond > most]
    bent = bool(refuted) and not wrong_law
    if there:
        told = {lack.subject: lack for lack in reversed(there)}  # of two shapes the stronger
        listed = "; ".join(
            f"{lack.subject} ({_size_text(lack)})"
            for lack in sorted(told.values(), key=_of_force_and_size)
        )
        said = f"what is left asks for more than the model has: {listed}"
        said += ". The law is not the record's, which asks for such forces too" * wrong_law
        said += bent * (
            f". The bound of {' and '.join(refuted)} leaves such forces too: mend that first"
        )
    else:
        said = "what is left goes with no force of the motion that was looked for"
    remedy, few = None, 0 if there else few
    if few:
        said += f"; {few} windows are few, in which one may go untold: "
        remedy = _shorter(of)
    return Check(
        name=name,
        status=passed(not (there or few), matters=not (wrong_law or bent or few)),
        figure=of.lacks[0].chance if of.lacks else None,
        threshold=level,
        p_value=of.lacks[0].chance if of.lacks else None,
        source=LACKING_LEVEL.source,
        meaning=said,
        remedy=remedy,
    )


def _size_text(lack: Lack) -> str:
    """How much is lacking; of what is held also which way."""
    size = f"{abs(lack.size):.2g} +- {lack.deviation:.1g} {lack.told_of}".rstrip()
    return size if _is_force(lack) else f"{size} {'more' if lack.size > 0 else 'less'}"


def _is_force(lack: Lack) -> bool:
    return lack.unit == "%"


def _of_force_and_size(lack: Lack) -> tuple[bool, float]:
    """An order: what is held, whose sizes have units of their own, then forces by their size."""
    return _is_force(lack), -abs(lack.size) if _is_force(lack) else 0.0


def _few_windows(of: Judged) -> int:
    """How many windows of an open loop there are, where more are advised; else 0."""
    if not isinstance(of.basis.predictions, WindowPredictions):
        return 0
    windows = sum(map(len, of.basis.predictions.spans))
    return windows if windows < ADVISED_WINDOWS.value else 0


def _shorter(of: Judged) -> Remedy:
    """Windows so short that they are as many as advised."""
    length = (of.horizon or 1.0) * _few_windows(of) / ADVISED_WINDOWS.value
    places = 1 - math.floor(math.log10(length))
    shorter = math.floor(length * 10**places) / 10**places
    return Remedy.of("follow a longer record, or use ", Setting("horizon", f"{shorter:g}"))


def _known(of: Judged) -> Iterator[Check]:
    """What was known before against what the records tell."""
    if not of.prior:
        return
    far = {name: _from_known(of, name) for name in of.prior}
    worst, most = max(far, key=lambda name: far[name]), MIN_DISTANCE_FROM_NOISE.value
    good = far[worst] <= most
    mean, sd = of.prior[worst]
    known, record = f"what was known of {worst}, {mean:.6g} +- {sd:.2g},", "the record"
    if worst in of.basis.alone:
        value, deviation = of.basis.alone[worst]
        record = f"what the record alone says, {value:.6g} +- {deviation:.2g},"
    said = f"{known} and {record} are {far[worst]:.2g} deviations apart"
    yield Check(
        name="what was known",
        status=passed(good),
        figure=far[worst],
        threshold=most,
        source=MIN_DISTANCE_FROM_NOISE.source,
        meaning=said + ("" if good else ": they contradict each other; one is wrong, or the model"),
    )


def _from_known(of: Judged, name: str) -> float:
    """How far a parameter is from what was known of it before, in deviations."""
    mean, sd = of.prior[name]
    if name in of.basis.alone:
        value, deviation = of.basis.alone[name]
        return abs(value - mean) / math.hypot(sd, deviation)
    place = of.names.index(name)
    both = math.sqrt(max(sd**2 - float(of.deviations[place]) ** 2, _SURE * sd**2))
    return abs(float(of.physical[place]) - mean) / both


def _ended(of: Judged) -> Check:
    best, lost = of.basis.best, ""
    if best.lost:
        lost = f"; {best.lost} parameter sets on the way could not be simulated: {best.why_lost}"
    if best.converged:
        said = f"the search stands still after {len(best.steps)} steps"
    else:
        said = (
            f"the search still moves after {MOST_STEPS} steps; start elsewhere, or leave out what "
            "the record does not show"
        )
    return Check(
        name="convergence",
        status=passed(best.converged),
        figure=float(len(best.steps)),
        threshold=float(MOST_STEPS),
        meaning=said + lost,
    )


def _shown(of: Judged) -> Check:
    several = len(of.outputs) > 1
    said = f"the {' and '.join(of.outputs)} show{'' if several else 's'} every parameter"
    remedy, unseen = None, [*of.unseen, *_unnamed(of)]
    if unseen:
        no = "do not" if several else "does not"
        said = f"the {' and '.join(of.outputs)} {no} show {'; nor '.join(unseen)}; "
        remedy = Remedy.of(
            "hold one with ",
            Setting("fix", f"{unseen[0].split()[0]}=VALUE"),
            ", or record another motion.",
        )
    return Check(
        name="parameters shown",
        status=passed(not unseen),
        threshold=MIN_SHOWN.value,
        source=MIN_SHOWN.source,
        meaning=said,
        remedy=remedy,
    )


def _unnamed(of: Judged) -> list[str]:
    """Parameters of infinite deviation that are in none of the directions that are not shown."""
    named = set(re.findall(r"\w+", " ".join(of.unseen)))
    lost = [name for name, d in zip(of.names, of.deviations, strict=True) if np.isinf(d)]
    return [f"{name} at all" for name in lost if name not in named]


def _none_shown(of: Judged) -> Iterator[Check]:
    """Whether the outputs show none of the parameters that are searched."""
    if not np.isinf(of.deviations).any():
        return
    chosen, most = _searched(of), MAX_RELATIVE_DEVIATION.value
    with np.errstate(divide="ignore", invalid="ignore"):
        percent = 100 * of.deviations / np.abs(of.physical)
    vague = ~(percent <= most)
    if np.all(vague[chosen]):
        yield Check(
            name="any parameter shown",
            status="fail",
            threshold=most,
            source="deviation in percent of the value",
            meaning=f"the {' and '.join(of.outputs)} show{'s' * (len(of.outputs) == 1)} no "
            f"parameter to {most:g} % of it: the numbers are where the search ended, no more",
        )


def _as_low(of: Judged) -> Iterator[Check]:
    """Whether the search passed a place as good as its end, which is claimed to be far from it."""
    found = of.basis.elsewhere
    if found is None:
        return
    order = [int(j) for j in np.argsort(-found.away) if found.away[j] > MIN_FAR.value]
    values = (f"{of.names[j]} {found.physical[j]:.4g} {of.units[j]}" for j in order)
    listed = ", ".join(map(str.rstrip, values))
    outputs = f"{' and '.join(of.outputs)} leave{'s' * (len(of.outputs) == 1)}"
    yield Check(
        name="one end",
        status="fail",
        figure=found.by_errors,
        threshold=MAX_FAR.value,
        source=MAX_FAR.source,
        meaning=(
            f"the errors are as small at {listed}: {found.away[order[0]]:.2g} of the deviations "
            f"away, and {found.by_errors:.2g} by the errors. The {outputs} these open along a "
            "valley, and the deviations are those of one place in it; "
        ),
        remedy=Remedy.of(
            "hold one with ",
            Setting("fix", f"{of.names[order[0]]}=VALUE"),
            ", or follow another output.",
        ),
    )


def _searched(of: Judged) -> NDArray[np.bool_]:
    """Parameters of the model, the law and the drive that were searched and are at no bound."""
    return np.asarray((of.deviations > 0) & ~of.basis.of_start)


def _rows(of: Judged) -> Iterator[Check]:
    """Whether errors are enough to tell how sure the parameters are."""
    rows = int(np.count_nonzero(of.basis.predictions.counted))
    few = few_rows(rows, of.searched)
    if few:
        yield Check(
            name="rows",
            status="note",
            figure=rows / of.searched,
            threshold=MIN_ROWS_PER_PARAMETER.value,
            source=MIN_ROWS_PER_PARAMETER.source,
            meaning=f"{few}; follow a longer part of the record",
        )


def _repeated(of: Judged) -> Iterator[Check]:
    """Whether samples are among the records more than once."""
    if check := repeated_check(of.records):
        yield check


def _alike(of: Judged) -> Iterator[Check]:
    """Whether each of several records has the parameters of the others."""
    if len(of.records) < 2:
        return
    shared = np.isfinite(of.deviations) & (of.deviations > 0) & ~of.basis.of_start
    shared &= ~np.isin(of.names, (*of.found_gains, GAIN))
    slopes = of.basis.best.slopes.jacobian
    found = others_in_records(of.basis.left, slopes, of.physical, shared)
    yield alike_by_outputs(found, of.names, of.units, len(of.records))


def _precise(of: Judged) -> Iterator[Check]:
    """Every parameter that is searched, and shown, against its own deviation."""
    slopes, weights = of.basis.best.slopes.jacobian, of.basis.left.weights
    parts = np.abs(weights[:, None] * slopes * of.physical)
    whole, peak = (np.divide(x, x.max() or 1.0) for x in (_norms(parts), parts.max(axis=0)))
    chosen = (of.deviations > 0) & np.isfinite(of.deviations) & ~of.basis.of_start
    if not chosen.any():
        return
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(chosen, of.deviations / np.abs(of.physical), 0.0)
        times, percent = 1 + 2 * relative, 100 * relative  # of what it may be, by what it is
        small = (whole * times < NEGLIGIBLE_FORCE.value) & (
            peak * times < NEGLIGIBLE_PEAK_FORCE.value
        )
    vague = percent > MAX_RELATIVE_DEVIATION.value
    told = dict(zip(of.names, map(float, percent), strict=True))
    unclear, minor = (
        [of.names[int(j)] for j in np.flatnonzero(x)] for x in (vague & ~small, vague & small)
    )
    yield precision_check(
        max(told.values()),
        [
            f"{name} is not identified by what is followed: its deviation is {told[name]:.3g} % of "
            "it"
            for name in unclear
        ],
        minor,
        "largest part that a parameter has of the output",
        "relative deviation in percent; a parameter that changes the output by less than 1 % of "
        "what the largest does, deviation included, may be as vague as it is",
    )


def _norms(columns: Array) -> Array:
    return np.asarray(np.linalg.norm(columns, axis=0))


def _bounds(of: Judged) -> Check:
    """Parameters at their bounds: what chance takes there, or what contradicts the bound."""
    beyond, most = of.basis.beyond, MIN_DISTANCE_FROM_NOISE.value
    if not beyond:
        return Check(name="bounds", status="pass", meaning="no parameter is driven to a bound")
    listed = ", ".join(f"{name} ({of.at_bound[name]})" for name in beyond)
    said = (
        f"at a bound: {listed}. The interval there is one-sided, and the others are what they "
        "are with it"
    )
    worst = max(beyond, key=lambda name: beyond[name])
    against = beyond[worst] > most
    if against:
        said += (
            f"; without it {worst} would be {beyond[worst]:.2g} deviations beyond: check the "
            "bound, the units and the signs, and what the model lacks"
        )
    return Check(
        name="bounds",
        status="fail" if against else "note",
        figure=beyond[worst],
        threshold=most,
        source="deviations by which a parameter at a bound would be beyond it",
        meaning=said,
    )


def _shaken(of: Judged) -> Iterator[Check]:
    """What noise in the loop moved, and is taken off; and which loops with it are lost."""
    loops, name = of.basis.loops, "noise in the loop"
    lost = ""
    if loops and loops.lost:
        lost = f"{loops.lost} of {loops.asked} pairs of loops with the record's noise end early"
    if loops and not loops.are_enough:
        yield Check.not_evaluated(name, Missing(f"{lost}, so that what it moves is not told"))
        return
    if of.basis.moved is None:
        if lost:
            said = f"{lost}; by the others it moves nothing that matters"
            yield Check(name=name, status="note", meaning=said)
        return
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.nan_to_num(np.abs(of.basis.moved) / of.deviations, posinf=0.0)
    worst = int(np.argmax(far))
    value, moved = of.physical[worst], float(of.basis.moved[worst])
    share = f" ({100 * moved / abs(value):+.2g} %)" if value else ""
    yield Check(
        name=name,
        status="note",
        figure=float(far[worst]),
        threshold=MIN_MOVED_BY_NOISE.value,
        source=MIN_MOVED_BY_NOISE.source,
        meaning=(
            "noise shakes the axis, and friction is not that of its mean velocity then: simulated "
            f"loops with the record's noise moved {of.names[worst]} by {far[worst]:.2g} "
            f"deviations{share}, which is taken off, and the others alike"
            + f"; {lost}"
            * bool(lost)
        ),
    )


def _begun(of: Judged) -> Iterator[Check]:
    """What the first positions and velocities, as the records have them, leave open."""
    by_start = of.basis.by_start
    if not by_start.far.any():
        return
    worst = int(np.argmax(by_start.far))
    value, by = of.physical[worst], abs(float(by_start.moved[worst]))
    share = f"by {100 * by / abs(value):.2g} %" if by < abs(value) else "by more than it is"
    yield Check(
        name="start of the loop",
        status="note",
        figure=float(by_start.far[worst]),
        threshold=MIN_MOVED_BY_START.value,
        source=MIN_MOVED_BY_START.source,
        meaning=(
            "the record begins in motion, and the loop where its first samples say; with another "
            f"start {of.names[worst]} would move {share}, which its deviation counts; "
        ),
        remedy=Remedy.of("find the start with the parameters by ", Setting("free", START), "."),
    )


def _starts(of: Judged) -> Iterator[Check]:
    if len(of.basis.ends) < 2:
        return
    alike = sum(each.cost <= of.basis.best.cost * (1 + SAME_END.value) for each in of.basis.ends)
    share = 1 - alike / len(of.basis.ends)
    yield Check(
        name="starts",
        status=passed(share <= MAX_APART.value, matters=False),
        figure=share,
        threshold=MAX_APART.value,
        source=MAX_APART.source,
        meaning=f"{alike} of {len(of.basis.ends)} searches ended here, the others higher",
    )
