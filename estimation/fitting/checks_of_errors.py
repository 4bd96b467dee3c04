"""Checks of what a fit leaves: is it noise, and what it asks for."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from axisid.estimation.checks import Check, joined, made, status_of
from axisid.estimation.diagnostics import (
    RecordRegressor,
    alike_check,
    lacks_check,
    records_alike,
)
from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.estimates import few_rows
from axisid.estimation.parameters import GAIN
from axisid.estimation.predictions import FEWEST_IN_WINDOW, WindowPredictions
from axisid.estimation.records import record_labels
from axisid.estimation.thresholds import (
    ADVISED_WINDOWS,
    MAX_GROWTH,
    MIN_DISTANCE_FROM_NOISE,
    MIN_ROWS_PER_PARAMETER,
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
    few = _few_windows(of)
    good = steady >= of.horizon and not few
    said = f"windows of {of.horizon:g} s are short enough that errors do not grow in them"
    if few:
        several = "1 window is" if few == 1 else f"{few} windows are"
        said = f"{several} too few to tell deviations, or what the model lacks; {_shorter(of)}"
    if steady < of.horizon:
        said = (
            f"errors grow more than {MAX_GROWTH.value:g} times in windows of {of.horizon:g} s, as "
            f"where friction falls with the velocity; use horizon={steady:g}."
        )
    return Check(
        name="windows",
        status=status_of(good),
        figure=of.horizon,
        threshold=steady,
        source=MAX_GROWTH.source,
        meaning=said,
    )


def simulation_check(of: OutputFit) -> Check:
    """What is left beyond noise: noise may be most of an output that is small, or noisy."""
    # A loop that swings by itself takes its swinging for noise, and leaves more than there is.
    lost = of.error_percent > _MAX_LEFT
    percents = [each.percent for each in of.of_records]
    worst = int(np.argmax(percents if lost else of.percents_beyond_noise))
    beyond, output = of.percents_beyond_noise[worst], of.of_records[worst].output
    percent = max(each.percent for each in of.of_records if each.output == output)
    good = beyond < _MAX_BEYOND_NOISE and not lost
    said = (
        f"the simulated {output} leaves {percent:.3g} % of the recorded one, "
        f"{beyond:.2g} % beyond noise"
    )
    more = "" if good else ": it does not follow it; check the model, the law, units and signs"
    return Check(
        name="simulation",
        status=status_of(good),
        figure=beyond,
        threshold=_MAX_BEYOND_NOISE,
        source="chosen: it is 4.5 on the EMPS record, whose model lacks 6 % of the control",
        meaning=said + more,
    )


def missing_terms_check(of: OutputFit) -> Check | None:
    """Whether what is left goes with a force of the motion, or with a value that is held."""
    check = joined_check("missing terms", of)
    if check is None or check.status != "fail":
        return check
    # What the model lacks moves the gains that are found with it.
    law = of.law
    wrong_law = isinstance(law, LawCheck) and not law.passed and not law.found_apart
    most = MIN_DISTANCE_FROM_NOISE.value
    refuted = [each.name for each in of.held if each.distance > most]
    if wrong_law:
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


def _few_windows(of: OutputFit) -> int:
    """How many windows of an open loop there are, where more are advised; else 0."""
    if not isinstance(of.predictions, WindowPredictions):
        return 0
    windows = sum(map(len, of.predictions.spans))
    return windows if windows < ADVISED_WINDOWS.value else 0


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
    if share:
        said = (
            f"{100 * share:.2g} % of the samples have no weight: they are near rests or reversals "
            "of the record or of its loop, where friction takes any force"
        )
    elif of.rests_count:
        said = (
            "samples near rests and reversals count, as without them a parameter is hardly shown; "
            "behind an encoder they mislead: record longer or faster moves"
        )
    else:
        return None
    return Check(name="samples near rests", status="note", figure=share, meaning=said)


def records_alike_check(of: OutputFit) -> Check | Missing | None:
    """Whether each of several records has the parameters of the others."""
    if len(of.records) < 2:
        return None
    shared = np.isfinite(of.deviations) & (of.deviations > 0) & ~of.of_start
    shared &= ~np.isin(of.names, (*of.found_gains.names, GAIN))
    scores, places = of.judged_scores, np.flatnonzero(of.inner)
    records = []
    for spans in scores.spans:
        span = slice(spans[0].start, spans[-1].stop)
        J = scores.jacobian[span]
        own = np.flatnonzero(shared[places] & J.any(axis=0))  # others' local ones are nothing here
        made = np.linalg.norm(J * of.physical[places], axis=0)
        records.append(
            RecordRegressor(
                names=tuple(of.names[j] for j in places[own]),
                units=tuple(of.quantities[j].unit for j in places[own]),
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
