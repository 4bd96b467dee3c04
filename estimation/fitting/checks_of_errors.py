"""Checks of what a fit leaves: is it noise, and what it asks for."""

import math
from collections.abc import Iterator

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.diagnostics import repeated_check
from axisid.estimation.diagnostics.law import LawCheck
from axisid.estimation.estimates import few_rows
from axisid.estimation.joint import GAIN
from axisid.estimation.predictions import FEWEST_IN_WINDOW, WindowPredictions
from axisid.estimation.thresholds.estimates import (
    MIN_DISTANCE_FROM_NOISE,
    MIN_ROWS_PER_PARAMETER,
)
from axisid.estimation.thresholds.fitting import (
    ADVISED_WINDOWS,
    LACKING_LEVEL,
    MAX_BEYOND_NOISE,
    MAX_GROWTH,
    MAX_LEFT,
)
from axisid.estimation.told_by_outputs import Lack, alike_by_outputs, others_in_records
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

from .basis import Judged


def windows_check(of: Judged) -> Iterator[Check]:
    """Whether nothing drives the axis away in the windows of an open loop, and they are enough."""
    if not isinstance(of.basis.predictions, WindowPredictions) or of.horizon is None:
        return
    try:
        steady = of.basis.predictions.steady_horizon(of.physical)
    except EstimationError as lost:
        yield Check.not_evaluated("windows", Missing.of(lost.note))
        return
    few = _few_windows(of)
    good, remedy = steady >= of.horizon and not few, _shorter(of) if few else None
    said = f"windows of {of.horizon:g} s are short enough that errors do not grow in them"
    if few:
        several = "1 window is" if few == 1 else f"{few} windows are"
        said = f"{several} too few to tell deviations, or what the model lacks; "
    if steady < of.horizon:
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


def simulation_check(of: Judged) -> Check:
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


def missing_terms_check(of: Judged) -> Check:
    """Whether what is left goes with a force of the motion, or with a value that is held."""
    name, level = "missing terms", LACKING_LEVEL.value
    if isinstance(of.lacks, Missing):
        return Check.not_evaluated(name, of.lacks)
    there = [lack for lack in of.lacks if lack.is_there]
    # What the model lacks moves the gains that are found with it.
    moved_gains = isinstance(of.law, LawCheck) and of.law.found_apart
    wrong_law = of.is_law_wrong and not moved_gains
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
    return Check(
        name=name,
        status=passed(not there, matters=not (wrong_law or bent)),
        figure=of.lacks[0].chance if of.lacks else None,
        threshold=level,
        p_value=of.lacks[0].chance if of.lacks else None,
        source=LACKING_LEVEL.source,
        meaning=said,
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
    """Windows so short that they are as many as advised, where they still are windows."""
    length = sum(len(each) * each.period for each in of.records) / ADVISED_WINDOWS.value
    places = 1 - math.floor(math.log10(length))
    shorter = math.floor(length * 10**places) / 10**places
    if shorter < FEWEST_IN_WINDOW * max(record.period for record in of.records):
        return Remedy.of("follow a longer record.")
    return Remedy.of("follow a longer record, or use ", Setting("horizon", f"{shorter:g}"))


def rows_check(of: Judged) -> Iterator[Check]:
    """Whether errors are enough to tell how sure the parameters are."""
    rows = int(np.count_nonzero(of.basis.left.counted))
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


def rests_check(of: Judged) -> Iterator[Check]:
    """How many samples have no weight, as they are near rests."""
    measured = np.count_nonzero(of.basis.predictions.counted)
    share = 1 - np.count_nonzero(of.basis.left.counted) / measured
    if share:
        said = (
            f"{100 * share:.2g} % of the samples have no weight: they are near rests or reversals "
            "of the record or of its loop, where friction takes any force"
        )
    elif of.basis.rests_count:
        said = (
            "samples near rests and reversals count, as without them a parameter is hardly shown; "
            "behind an encoder they mislead: record longer or faster moves"
        )
    else:
        return
    yield Check(name="samples near rests", status="note", figure=share, meaning=said)


def repeated_records_check(of: Judged) -> Iterator[Check]:
    """Whether samples are among the records more than once."""
    if check := repeated_check(of.records):
        yield check


def records_alike_check(of: Judged) -> Iterator[Check]:
    """Whether each of several records has the parameters of the others."""
    if len(of.records) < 2:
        return
    shared = np.isfinite(of.deviations) & (of.deviations > 0) & ~of.basis.of_start
    shared &= ~np.isin(of.names, (*of.found_gains, GAIN))
    slopes = of.basis.best.slopes.jacobian
    found = others_in_records(of.basis.left, slopes, of.physical, shared)
    yield alike_by_outputs(found, of.names, of.units, len(of.records))
