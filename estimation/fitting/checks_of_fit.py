"""Checks of what a fit leaves, and of what it says: is it noise, and how surely is it shown."""

import math
import re
from dataclasses import replace
from functools import partial
from operator import attrgetter

import numpy as np

from axisid.estimation.checks import Check, joined, made, status_of
from axisid.estimation.diagnostics import (
    RecordRegressor,
    alike_check,
    held_check,
    lacks_check,
    nominal_check,
    precision_check,
    records_alike,
)
from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.estimates import few_rows, student_interval
from axisid.estimation.parameters import GAIN
from axisid.estimation.predictions import FEWEST_IN_WINDOW, WindowPredictions
from axisid.estimation.records import record_labels
from axisid.estimation.thresholds import (
    ADVISED_WINDOWS,
    MAX_FAR,
    MAX_GROWTH,
    MAX_RELATIVE_DEVIATION,
    MIN_DISTANCE_FROM_NOISE,
    MIN_FAR,
    MIN_ROWS_PER_PARAMETER,
    MIN_SHOWN,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, Missing

from .result import OutputFit

_MAX_BEYOND_NOISE = 15.0  # % of a recorded output, left beyond noise
# % of a recorded output left with noise; a loop that does nothing leaves 100, noise beside a
# small motion hardly more
_MAX_LEFT = 120.0


def windows_check(of: OutputFit) -> Check | Missing | None:
    """Whether nothing drives the axis away in the windows of an open loop, and they are enough."""
    if not isinstance(of.predictions, WindowPredictions) or of.horizon is None:
        return None
    try:
        steady = of.predictions.steady_horizon(of.physical)
    except EstimationError as lost:
        return Missing(str(lost))
    windows, advised = sum(map(len, of.predictions.spans)), ADVISED_WINDOWS.value
    said = f"windows of {of.horizon:g} s are short enough that errors do not grow in them"
    if windows < advised:
        several = "1 window is" if windows == 1 else f"{windows} windows are"
        said = f"{several} too few to tell deviations, or what the model lacks; {_shorter(of)}"
    if steady < of.horizon:
        said = (
            f"errors grow more than {MAX_GROWTH.value:g} times in windows of {of.horizon:g} s, as "
            f"where friction falls with the velocity; use horizon={steady:g}."
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
    worst = max(of.of_records, key=attrgetter("percent" if lost else "percent_beyond_noise"))
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
    law, most = of.law, MIN_DISTANCE_FROM_NOISE.value
    refuted = [each.name for each in of.held if each.distance > most]
    if isinstance(law, LawCheck) and not law.passed and not law.found_apart:
        more = ". The law is not the record's, which asks for such forces too"
    elif refuted:
        more = f". The bound of {' and '.join(refuted)} leaves such forces too: mend that first"
    else:
        return check
    return replace(check, status="note", meaning=check.meaning + more)


def joined_check(name: str, of: OutputFit) -> Check | None:
    """What is checked of what the model lacks, over all records."""
    found = [
        made(name, partial(lacks_check, lacks, name, axis, record, of.levels))
        for lacks, axis, record in zip(of.lacks, of.axes, of.records, strict=True)
    ]
    return joined(found, record_labels(of.records))


def _shorter(of: OutputFit) -> str:
    """Windows so short that they are as many as advised, where they still are windows."""
    length = sum(len(each) * each.period for each in of.records) / ADVISED_WINDOWS.value
    places = 1 - math.floor(math.log10(length))
    shorter = math.floor(length * 10**places) / 10**places
    if shorter < FEWEST_IN_WINDOW * max(record.period for record in of.records):
        return "follow a longer record."
    return f"follow a longer record, or use horizon={shorter:g}"


def rows_check(of: OutputFit) -> Check | None:
    """Whether errors are enough to tell how sure the parameters are."""
    rows = int(np.count_nonzero(of.judged_scores.counted))
    searched = len(of.names) - len(of.fixed)
    few = few_rows(rows, searched)
    if not few:
        return None
    return Check(
        name="rows",
        status="note",
        figure=rows / searched,
        threshold=MIN_ROWS_PER_PARAMETER.value,
        source=MIN_ROWS_PER_PARAMETER.source,
        meaning=f"{few}; follow a longer part of the record",
    )


def rests_check(of: OutputFit) -> Check | None:
    """How many samples have no weight, as they are near rests."""
    measured = np.count_nonzero(of.predictions.counted)
    share = 1 - np.count_nonzero(of.judged_scores.counted) / measured
    if not (share or of.rests_count):
        return None
    said = (
        "samples near rests and reversals count, as without them a parameter is hardly shown; "
        "behind an encoder they mislead: record longer or faster moves"
    )
    if share:
        said = (
            f"{100 * share:.2g} % of the samples have no weight: they are near rests or reversals "
            "of the record or of its loop, where friction takes any force"
        )
    return Check(name="samples near rests", status="note", figure=share, meaning=said)


def records_alike_check(of: OutputFit) -> Check | Missing | None:
    """Whether each of several records has the parameters of the others."""
    if len(of.records) < 2:
        return None
    shared = np.isfinite(of.deviations) & (of.deviations > 0) & ~of.of_start
    shared &= ~np.isin(of.names, (*of.found_gains.names, GAIN))
    scores, places = of.judged_scores, np.flatnonzero(of.unknowns.free & (of.sides == 0))
    records = []
    for spans in scores.spans:
        span = slice(spans[0].start, spans[-1].stop)
        J = scores.jacobian[span]
        own = np.flatnonzero(shared[places] & J.any(axis=0))  # others' local ones are nothing here
        made = np.linalg.norm(J * of.physical[places], axis=0)
        records.append(
            RecordRegressor(
                names=tuple(of.names[j] for j in places[own]),
                units=tuple(of.unknowns.quantities[j].unit for j in places[own]),
                values=of.physical[places[own]],
                slopes=np.eye(len(places))[own],
                span=span,
                columns=J[:, own],
                instruments=J[:, own],
                size=float(made.max(initial=0.0)),
            )
        )

    def extended(_: Array, columns: Array) -> tuple[Array, Array, Array]:
        return scores.extended(columns, clustered=of.horizon is not None)

    alike = records_alike(scores.jacobian, records, extended, of.levels)
    return alike_check(alike, record_labels(of.records), of.levels, "output")


_SURE = 1e-2  # of a variance: the least by which what was known is moved


def known_check(of: OutputFit) -> Check | None:
    """What was known before against what the records tell."""
    if not of.prior:
        return None
    far = dict[str, float]()
    for name, (mean, sd) in of.prior.items():
        place = of.names.index(name)
        value, both = float(of.physical[place]), sd**2 - float(of.deviations[place]) ** 2
        if name in of.without_prior:
            value, deviation = of.without_prior[name]
            both = sd**2 + deviation**2
        far[name] = abs(value - mean) / math.sqrt(max(both, _SURE * sd**2))
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
    said = f"the {of.output} show{'' if several else 's'} every parameter"
    named = {*re.findall(r"\w+", " ".join(of.unseen))}
    lost = [name for name, d in zip(of.names, of.deviations, strict=True) if np.isinf(d)]
    unseen = [*of.unseen, *(f"{name} at all" for name in lost if name not in named)]
    if unseen:
        no = "do not" if several else "does not"
        said = (
            f"the {of.output} {no} show {'; nor '.join(unseen)}; hold one with fix "
            f"{unseen[0].split()[0]}=VALUE, or record another motion."
        )
    return Check(
        name="parameters shown",
        status=status_of(not unseen),
        threshold=MIN_SHOWN.value,
        source=MIN_SHOWN.source,
        meaning=said,
    )


def none_shown_check(of: OutputFit) -> Check | None:
    """Whether the outputs show none of the parameters that are searched."""
    if not np.isinf(of.deviations).any():
        return None
    most, searched = MAX_RELATIVE_DEVIATION.value, (of.deviations > 0) & ~of.of_start
    if np.any(searched & (100 * of.deviations <= most * np.abs(of.physical))):
        return None
    return Check(
        name="any parameter shown",
        status="fail",
        threshold=most,
        source="deviation in percent of the value",
        meaning=f"the {of.output} show{'s' * (len(of.outputs) == 1)} no "
        f"parameter to {most:g} % of it: the numbers are where the search ended, no more",
    )


def one_end_check(of: OutputFit) -> Check | None:
    """Whether the search passed a place as good as its end, which is claimed to be far from it."""
    found = of.elsewhere
    if found is None:
        return None
    order = [int(j) for j in np.argsort(-found.away) if found.away[j] > MIN_FAR.value]
    values = (
        f"{of.names[j]} {found.physical[j]:.4g} {of.unknowns.quantities[j].unit}" for j in order
    )
    listed = ", ".join(map(str.rstrip, values))
    outputs = f"{of.output} leave{'s' * (len(of.outputs) == 1)}"
    return Check(
        name="one end",
        status="fail",
        figure=found.by_errors,
        threshold=MAX_FAR.value,
        source=MAX_FAR.source,
        meaning=(
            f"the errors are as small at {listed}: {found.away[order[0]]:.2g} of the "
            f"deviations away, and {found.by_errors:.2g} by the errors. The {outputs} these "
            "open along a valley, and the deviations are those of one place in it; hold one "
            f"with fix {of.names[order[0]]}=VALUE, or follow another output."
        ),
    )


def precise_check(of: OutputFit) -> Check | None:
    """Every parameter that is searched, and shown, against its own deviation."""
    parts = np.abs(of.weighing.weights[:, None] * of.best.slopes.jacobian * of.physical)
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


def bounds_check(of: OutputFit) -> Check:
    """Parameters at their bounds: what chance takes there, or what contradicts the bound."""
    if of.held:
        return held_check(of.held)
    return Check(name="bounds", status="pass", meaning="no parameter is driven to a bound")


def nominal_values_check(of: OutputFit) -> Check | None:
    """Values of another order of size than declared."""
    declared = {p.name: p for p in of.axes[0].axis.parameters}
    rows = zip(of.names, of.physical, of.deviations, strict=True)
    return nominal_check(
        (declared[name], value, student_interval(value, deviation, np.inf))
        for name, value, deviation in rows
        if name in declared
    )
