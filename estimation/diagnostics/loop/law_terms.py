"""The recorded control beside the terms of the declared law, where the two can be compared."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import LawTicks, as_logged, law_ticks, start_of_law, terms_along
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter, SampledFilter
from axisid.estimation.thresholds.diagnostics import COMPARISON_CUTOFF, MAX_LIMIT_EXCESS
from axisid.estimation.thresholds.records import LIMIT_TOLERANCE
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent

LAW_SETTLING = 10  # samples in which the law's memory fills


def compared_with_law(
    axis: GeneratedAxis, law: ControlLaw, record: Record, settle: int
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The control, (N,), the law's terms, (N, terms), and which samples to compare, (N,)."""
    control, whole = np.asarray(record.control), (0, len(record))
    # A control beyond the limit by more is in a wrong unit, not one of a saturated drive.
    limited = np.isclose(
        np.abs(control), axis.axis.drive.limit, rtol=LIMIT_TOLERANCE.value, atol=0.0
    )
    for start, stop in record.masked:
        # A position that was cut off stays in the memory.
        limited[start : stop + LAW_SETTLING] = True
    limited[:settle] = True
    ticks = law_ticks(axis, record, whole)
    terms = terms_along(axis, ticks, start_of_law(axis, record, whole, ticks))
    terms = np.hstack([terms, _added(axis, record, law, ticks)])
    if not law.takes_velocity:
        return control, terms, ~(limited | _cut(control, terms, axis.axis.drive.limit))
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period)
    smooth = SampledFilter(low_pass, record.period)
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


def _added(axis: GeneratedAxis, record: Record, law: ControlLaw, ticks: LawTicks) -> Array:
    """What was added to the control besides, as late as the law, (N, 1); (N, 0) for nothing."""
    if record.added_control is None:
        return np.empty((len(record), 0))
    return as_logged(axis, ticks.added_at_samples(law.delay)[:, None])
