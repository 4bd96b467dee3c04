"""What the drive remembers where a record begins.

It is in no log, but the first controls show it: an integral that holds a load, the last position of
a moving axis. Sought is the memory with which the law gives them, by least squares; what they do
not show stays as the law declares it for an axis at rest, and so does all of it where that gives
them too, within what the law leaves of them anyway.
"""

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.thresholds.records import LIMIT_TOLERANCE
from axisid.estimation.thresholds.simulation import (
    MIN_MEMORY_EFFECT,
    MIN_START_DISTANCE,
    MIN_START_ERROR,
)
from axisid.support.arrays import Array, covered

from .law_run import control_along, slopes_along, state_at_rest
from .law_ticks import LawTicks, law_of

_SAMPLES = 50  # of the record that are looked at
_STEPS = 4  # of Newton's method; a law that is linear in its memory takes one


def first_memory(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], ticks: LawTicks
) -> Array | None:
    """What the drive remembers at the first sample of a segment, (m,).

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        With a reference.
    span : tuple of int
        The segment: first row and the one after the last.
    ticks : LawTicks
        Of the segment.

    Returns
    -------
    (m,) array or None
        None where it is that of an axis at rest, as the law declares it, or where there is no
        control that shows it.
    """
    if record.control is None or not axis.functions["control_start"].numel_out(0):
        return None
    law = law_of(axis)
    control = record.control[slice(*span)]
    ticks = ticks.first(_SAMPLES)
    first = control[: len(ticks.held)] - ticks.added_at_samples(law.delay)
    seen = _unlimited(axis, record, span)[: len(first)]
    at_rest = state_at_rest(axis, ticks)
    off = (first - control_along(axis, ticks, at_rest))[seen]
    least = (
        MIN_START_ERROR.value * float(np.linalg.norm(control)) * np.sqrt(len(off) / len(control))
    )
    if not law.balanced and not np.linalg.norm(off) > least:
        return None
    state, freedom = _solved(axis, ticks, first, seen, at_rest)
    left = (first - control_along(axis, ticks, state))[seen]
    if law.balanced:
        return state
    noise = float(left @ left) / max(len(left) - freedom, 1)
    gained = float(off @ off - left @ left) / max(freedom, 1)
    return state if gained > MIN_START_DISTANCE.value**2 * noise else None


def _unlimited(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> NDArray[np.bool_]:
    """Which samples of a segment are measured, and not at the drive's limit, (N,)."""
    rows, limit = slice(*span), axis.axis.drive.limit * (1 - LIMIT_TOLERANCE.value)
    masked = covered(record.masked, len(record))[rows]
    return np.asarray(~masked & (np.abs(np.asarray(record.control)[rows]) < limit))


def _solved(
    axis: GeneratedAxis, ticks: LawTicks, control: Array, seen: NDArray[np.bool_], state: Array
) -> tuple[Array, int]:
    """The memory that gives the controls, and in how many directions they show it."""
    shown = 0
    for _ in range(_STEPS):
        off = (control - control_along(axis, ticks, state))[seen]
        slopes = slopes_along(axis, ticks, state)[seen]
        if not (np.all(np.isfinite(off)) and np.all(np.isfinite(slopes))):
            break
        sizes = np.linalg.norm(slopes, axis=0)
        scale = np.where(sizes > 0, sizes, 1.0)
        u, effect, v = np.linalg.svd(slopes / scale, full_matrices=False)
        clear = effect > MIN_MEMORY_EFFECT.value * effect.max(initial=0.0)
        step = (v[clear].T @ ((u.T @ off)[clear] / effect[clear])) / scale
        state, shown = state + step, int(clear.sum())
        if np.linalg.norm(slopes @ step) <= 1e-12 * np.linalg.norm(control):
            break
    return state, shown
