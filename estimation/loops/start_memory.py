"""What the drive remembers where a record begins.

It is in no log, but the first controls show it: an integral that holds a load, the last position of
a moving axis. Sought is the memory with which the law gives them, by least squares; what they do
not show stays as the law declares it for an axis at rest, and so does all of it where that gives
them too, within what the law leaves of them anyway.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.simulation import law_of
from axisid.estimation.thresholds import LIMIT_TOLERANCE
from axisid.support.arrays import Array, covered

from .as_logged import as_logged, limit_in_log
from .law_run import control_along, law_memory, slopes_along, state_at_rest, states_along
from .law_ticks import LawTicks, law_ticks
from .start_velocity import MIN_START_DISTANCE

# of the control, which the memory of an axis at rest may miss: half the 0.24 % that the law
# leaves of the EMPS record
_MIN_START_ERROR = 1e-3
# of the largest effect on the first controls; with less, the memory stays as declared
MIN_MEMORY_EFFECT = 1e-3
# of what the memory at rest misses, for another to be taken: on twins at rest a wrong gain leaves
# 0.5 and more; under a load or in motion 0.04 at most, with gains 10 to 50 % off too
_MAX_START_LEFT = 0.1

START_SAMPLES = 50  # of the record that are looked at
_STEPS = 4  # of Newton's method; a law that is linear in its memory takes one
_LINEAR = 1e-9  # of the control: what a step leaves beside what it should


def start_of_law(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], ticks: LawTicks
) -> Array:
    """What the drive remembers where a segment begins, of the record or as it is declared, (m,)."""
    found = first_memory(axis, record, span, ticks)
    return state_at_rest(axis, ticks) if found is None else found


def first_memory(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], ticks: LawTicks | None = None
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
    ticks : LawTicks, optional
        Of the segment, where they are known.

    Returns
    -------
    (m,) array or None
        None where it is that of an axis at rest, as the law declares it, or where there is no
        control that shows it.
    """
    if record.control is None or not law_memory(axis):
        return None
    law = law_of(axis)
    control = record.control[slice(*span)]
    ticks = (ticks or law_ticks(axis, record, span)).first(START_SAMPLES)
    wanted = control[: len(ticks.held)] - as_logged(axis, ticks.added_at_samples(law.delay))
    seen = unlimited(axis, record, span)[: len(wanted)]
    at_rest = state_at_rest(axis, ticks)
    made = control_along(axis, ticks, at_rest)
    off = wanted - made
    if not law.balanced and not at_rest_misses(off, seen, float(np.mean(control**2))):
        return None
    found = _solved(axis, ticks, wanted, seen, at_rest)
    if np.any(seen & ~below_limit(axis, made)):  # where nothing shows what moves it
        moving = _solved(axis, ticks, wanted, seen, _state_in_motion(axis, ticks))
        found = min(found, moving, key=lambda each: float(np.linalg.norm(each.left)))
    off = off[seen]
    left, noise = float(np.linalg.norm(found.left)), float(found.left @ found.left)
    gained = (float(off @ off) - noise) / max(found.shown, 1)
    noise /= max(len(off) - found.shown, 1)
    explained = left < _MAX_START_LEFT * float(np.linalg.norm(off))
    clear = explained and gained > MIN_START_DISTANCE**2 * noise
    return found.state if law.balanced or clear else None


def at_rest_misses(
    off: Array, seen: NDArray[np.bool_], power: float | Array
) -> np.bool_ | NDArray[np.bool_]:
    """Whether the memory of an axis at rest leaves too much of the first controls, by lane.

    Parameters
    ----------
    off : (n,) or (n, L) array
        What it leaves of them.
    seen : (n,) or (n, L) array of bool
        Which count.
    power : float or (L,) array
        Mean square of the control.
    """
    left = np.sqrt(np.sum(np.where(seen, off, 0.0) ** 2, axis=0))
    least = _MIN_START_ERROR * np.sqrt(power * seen.sum(axis=0))
    return np.asarray(left > least)[()]


def below_limit(axis: GeneratedAxis, control: Array) -> NDArray[np.bool_]:
    """Which controls are not at the drive's limit."""
    return np.abs(control) < limit_in_log(axis) * (1 - LIMIT_TOLERANCE.value)


def unlimited(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> NDArray[np.bool_]:
    """Which samples of a segment are measured, and not at the drive's limit, (N,)."""
    rows = slice(*span)
    masked = covered(record.masked, len(record))[rows]
    return np.asarray(~masked & below_limit(axis, np.asarray(record.control)[rows]))


def _state_in_motion(axis: GeneratedAxis, ticks: LawTicks) -> Array:
    """What the drive remembers of an axis that moved as it does before the first evaluation, (m,).

    A law that differences positions takes an axis at rest that moves at once for one that leaps:
    its control is at the drive's limit then, whatever it remembers.
    """
    before = np.arange(-len(ticks), 0)

    def led(values: Array) -> Array:
        slope = (values[-1] - values[0]) / max(len(values) - 1, 1)
        return np.append(values[0] + slope * before, values[0])

    way = LawTicks.at_samples(
        led(ticks.reference),
        led(ticks.position),
        np.full(len(before) + 1, ticks.velocity[0]),
        tuple(np.full(len(before) + 1, values[0]) for values in ticks.recorded),
    )
    return states_along(axis, way, state_at_rest(axis, way))[:, -1]


@dataclass(frozen=True, slots=True)
class _Memory:
    """A memory, what it leaves of the controls, and in how many directions they show it."""

    state: Array
    left: Array
    shown: int


def _solved(
    axis: GeneratedAxis, ticks: LawTicks, wanted: Array, seen: NDArray[np.bool_], state: Array
) -> _Memory:
    """The memory that gives the controls, from one that does not."""
    off, shown = (wanted - control_along(axis, ticks, state))[seen], 0
    for _ in range(_STEPS):
        slopes = slopes_along(axis, ticks, state)[seen]
        if not (np.all(np.isfinite(off)) and np.all(np.isfinite(slopes))):
            break
        sizes = np.linalg.norm(slopes, axis=0)
        scale = np.where(sizes > 0, sizes, 1.0)
        u, effect, v = np.linalg.svd(slopes / scale, full_matrices=False)
        clear = effect > MIN_MEMORY_EFFECT * effect.max(initial=0.0)
        step = (v[clear].T @ ((u.T @ off)[clear] / effect[clear])) / scale
        state, shown, expected = state + step, int(clear.sum()), off - slopes @ step
        off = (wanted - control_along(axis, ticks, state))[seen]
        if np.linalg.norm(off - expected) <= _LINEAR * np.linalg.norm(wanted):
            break
    return _Memory(state, off, shown)
