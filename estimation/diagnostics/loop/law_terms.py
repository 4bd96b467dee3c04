"""The recorded control beside the terms of the declared law, where the two can be compared."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.runtime import by_sample
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter, SampledFilter
from axisid.estimation.thresholds.diagnostics import COMPARISON_CUTOFF, MAX_LIMIT_EXCESS
from axisid.estimation.thresholds.records import LIMIT_TOLERANCE
from axisid.modeling.declaration import ControlLaw
from axisid.modeling.quantities import MEASURED_VELOCITY
from axisid.support.arrays import Array, relative_error_percent

LAW_SETTLING = 10  # samples in which the law's memory fills


def takes_velocity(law: ControlLaw) -> bool:
    """Whether a law takes the velocity of an ideal sensor, which is not recorded."""
    following = [memory.following for memory in law.memory]
    return any(e.has(MEASURED_VELOCITY) for e in (law.output, *following))


def compared_with_law(
    axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The control, (N,), the law's terms, (N, terms), and which samples to compare, (N,)."""
    control, reference = np.asarray(record.control), np.asarray(record.commanded)
    # A control beyond the limit by more is in a wrong unit, not one of a saturated drive.
    limited = np.isclose(
        np.abs(control), axis.axis.drive.limit, rtol=LIMIT_TOLERANCE.value, atol=0.0
    )
    for start, stop in record.masked:
        # A position that was cut off stays in the memory.
        limited[start : stop + LAW_SETTLING] = True
    limited[:settle] = True
    if not takes_velocity(law):
        terms = _run_law(axis, reference, record.position, np.zeros_like(record.position))
        terms = np.hstack([terms, _added(record, law)])
        return control, terms, ~(limited | _cut(control, terms, axis.axis.drive.limit))
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period)
    smooth = SampledFilter(low_pass, record.period)
    _, velocity, _ = smooth.motion(record.position)
    terms = _run_law(axis, reference, record.position, velocity)
    terms = np.hstack([terms, _added(record, law)])
    if np.all(np.isfinite(terms)):
        control, *columns = (smooth.motion(signal)[0] for signal in (control, *terms.T))
        terms = np.column_stack(columns)
    limited[-settle:] = True
    limited |= _cut(control, terms, axis.axis.drive.limit)
    # The low-pass spreads a limited sample over its neighbours.
    return control, terms, ~maximum_filter1d(limited, settle)


def law_error_percent(axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int) -> float:
    """What a law leaves of the recorded control, percent."""
    control, terms, used = compared_with_law(axis, law, record, settle)
    return relative_error_percent((control - terms.sum(axis=1))[used], control[used])


def _cut(control: Array, terms: Array, limit: float) -> NDArray[np.bool_]:
    """Where the law asks for more than the limit, and gets it but for a converter's noise, (N,)."""
    wanted = terms.sum(axis=1)
    there = np.abs(control) >= (1 - MAX_LIMIT_EXCESS.value) * limit
    return np.asarray(there & (wanted * np.sign(control) > limit))


def _added(record: Record, law: ControlLaw) -> Array:
    """What was added to the control besides, as late as the law, (N, 1); (N, 0) for nothing."""
    added = record.added_control
    if added is None:
        return np.empty((len(record), 0))
    late = np.concatenate([np.zeros(law.delay), added[: len(added) - law.delay]])
    return np.asarray(late[:, None])


def _run_law(axis: GeneratedAxis, reference: Array, position: Array, velocity: Array) -> Array:
    """The control law's terms along recorded signals, (N, terms), when they are applied.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    reference, position, velocity : (N,) array
        What the law measured.
    """
    declared = axis.axis.control
    delay = 0 if declared is None else declared.delay
    law, terms = axis.functions["control_law"], axis.functions["control_terms"]
    start = axis.functions["control_start"](reference[0], position[0]).full()
    signals = [values[None, :] for values in (reference, position, velocity)]
    states = np.zeros((len(start), len(reference)))
    if len(start):
        # The state comes first in and first out, so that the function can be run along the samples.
        along = law.slice("law", [3, 0, 1, 2], [1]).mapaccum(len(reference))
        states = np.hstack([start, along(start, *signals).full()[:, :-1]])
    rows = by_sample(terms.call([*signals, states])[0].full(), len(reference))
    return np.concatenate([np.repeat(rows[:1], delay, axis=0), rows[: len(rows) - delay]])
