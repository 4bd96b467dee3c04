"""The recorded control beside the terms of the declared law, where the two can be compared."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import (
    LawTicks,
    as_logged,
    control_along,
    law_ticks,
    limit_in_log,
    position_noise,
    start_of_law,
    terms_along,
    two_clocks,
)
from axisid.estimation.records import Record, at_times
from axisid.estimation.signals import Prefilter, SampledFilter
from axisid.estimation.thresholds import COMPARISON_CUTOFF, LIMIT_TOLERANCE, MAX_LIMIT_EXCESS
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent

_COINCIDES = 1e-6  # of a sample
LAW_SETTLING = 10  # samples in which the law's memory fills


def compared_with_law(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The control, (N,), the law's terms, (N, terms), and which samples to compare, (N,)."""
    control, settle = np.asarray(record.control), settling(law)
    # A control beyond the limit by more is in a wrong unit, not one of a saturated drive.
    limited = np.isclose(np.abs(control), limit_in_log(axis), rtol=LIMIT_TOLERANCE.value, atol=0.0)
    for start, stop in record.masked:
        # A position that was cut off stays in the memory.
        limited[start : stop + LAW_SETTLING] = True
    limited[:settle] = True
    ticks, memory = noisy_ticks(axis, law, record)
    terms = terms_along(axis, ticks, memory)
    terms = np.hstack([terms, _added(axis, record, law, ticks)])
    if not law.takes_velocity:
        return control, terms, ~(limited | at_limit(control, terms, axis.axis.drive.limit))
    smooth = compared_as(law, record)
    if np.all(np.isfinite(terms)):
        control, *columns = map(smooth, (control, *terms.T))
        terms = np.column_stack(columns)
    limited[-settle:] = True
    limited |= at_limit(control, terms, axis.axis.drive.limit)
    # The low-pass spreads a limited sample over its neighbours.
    return control, terms, ~maximum_filter1d(limited, settle)


def noisy_ticks(axis: GeneratedAxis, law: ControlLaw, record: Record) -> tuple[LawTicks, Array]:
    """What a law measured along a record, with all its noise, and what it remembers first, (m,).

    That is of the low-passed velocity, of which the first controls show it better.
    """
    whole = (0, len(record))
    ticks = law_ticks(axis, record, whole, noisy=True)
    quiet = law_ticks(axis, record, whole) if law.takes_velocity else ticks
    return ticks, start_of_law(axis, record, whole, quiet)


def compared_as(law: ControlLaw, record: Record) -> Callable[[Array], Array]:
    """What both sides are filtered by: a low-pass, where the law reads an ideal velocity."""
    if not law.takes_velocity:
        return lambda signal: signal
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period)
    smooth = SampledFilter(low_pass, record.period)
    return lambda signal: smooth.motion(signal)[0]


def settling(law: ControlLaw) -> int:
    """Samples at the start that are not compared."""
    return round(1 / COMPARISON_CUTOFF.value) if law.takes_velocity else LAW_SETTLING


def law_error_percent(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float:
    """What a law leaves of the recorded control, percent."""
    return residual_percent(*compared_with_law(axis, law, record))


def residual_percent(control: Array, terms: Array, used: NDArray[np.bool_]) -> float:
    """What a law leaves of a control, percent, as `compared_with_law` gives the two."""
    return relative_error_percent((control - terms.sum(axis=1))[used], control[used])


def at_limit(control: Array, terms: Array, limit: float) -> NDArray[np.bool_]:
    """Where the law asks for more than the limit, and gets it but for a converter's noise, (N,)."""
    wanted = terms.sum(axis=1)
    there = np.abs(control) >= (1 - MAX_LIMIT_EXCESS.value) * limit
    return np.asarray(there & (wanted * np.sign(control) > limit))


def _added(axis: GeneratedAxis, record: Record, law: ControlLaw, ticks: LawTicks) -> Array:
    """What was added to the control besides, as late as the law, (N, 1); (N, 0) for nothing."""
    if record.added_control is None:
        return np.empty((len(record), 0))
    return as_logged(axis, ticks.added_at_samples(law.delay)[:, None])


def left_open_percent(axis: GeneratedAxis, record: Record, used: NDArray[np.bool_]) -> float:
    """How far the control of a right law may be from the recorded one, percent of that.

    Between the samples of a log the position is taken by a cubic spline. What that misses is the
    noise that the law measured, and a motion faster than the log: how much the control may differ
    by them is measured, with noise of the same size added to the positions, and with every second
    sample left out of the spline.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        Of one piece, with a reference and a control.
    used : (N,) array of bool
        Samples that are compared.

    Returns
    -------
    float
        0 where law and log have one clock, or the law reads samples of the log alone.
    """
    whole = (0, len(record))
    clocks = two_clocks(axis, record, whole)
    if clocks is None:
        return 0.0
    ticks = law_ticks(axis, record, whole)
    start = start_of_law(axis, record, whole, ticks)
    if np.allclose(clocks.times, np.round(clocks.times), rtol=0, atol=_COINCIDES):
        return 0.0  # every position that the law read is in the log
    noise = position_noise(record.position) * np.random.default_rng(0).normal(size=len(ticks))
    undisturbed = control_along(axis, ticks, start)
    every_second = record.position[::2]
    drawn = at_times(clocks.times / 2, np.arange(float(len(every_second))), every_second, "spline")
    off = [
        control_along(axis, replace(ticks, position=position), start) - undisturbed
        for position in (ticks.position + noise, drawn)
    ]
    control = np.asarray(record.control)
    by_noise, by_spline = (relative_error_percent(each[used], control[used]) for each in off)
    return float(np.hypot(by_noise, by_spline))
