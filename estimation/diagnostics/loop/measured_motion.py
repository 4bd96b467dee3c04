"""A measured velocity against the position's derivative, an acceleration against the velocity's.

Both say the same of the axis, whatever its model: a factor between them is a unit or a scale, a
delay the drive's filter or the logger's, a constant the zero of a tachometer. Each may be noisy.
The factor of a regression is then too small, and the inverse of the other way's too large, so that
the truth lies between the two [Frisch1934]_. A delay is found by moving the derivative until the
regression asks for no more: there noise has nothing to attenuate.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d, shift

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.records import Record, advised_between, advised_shift, samples_apart
from axisid.estimation.regression import Hac, Solution, factor, least_squares
from axisid.estimation.signals import Neighbours, Prefilter, SampledFilter
from axisid.estimation.tables import label_unit
from axisid.estimation.thresholds import COMPARISON_CUTOFF, MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array, covered
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

from .force import MAX_FORCE_CUTOFF, MIN_SETTLING_TIMES

# of the factor to the derivative, from 1: friction and inertia are off by as much
_MAX_MOTION_FACTOR_ERROR = 0.01
_MAX_MOTION_DELAY = 0.35  # samples behind the derivative: as much as the force may be misaligned
_MAX_MOTION_OFFSET = 0.01  # constant between the two, by the derivative's root mean square
# % of the derivative, left by factor, delay and constant; from there on the column is another
# signal, as noise in the band is far less
_MAX_MOTION_DIFFERENCE = 30.0

_OFTEN = 4  # rows in a period of the highest frequency that is left
_STEPS, _STILL = 12, 1e-3  # of the search for the delay, samples
_TINY = 1e-300
_FARTHEST = 50.0  # samples of delay that are looked for
#: Units that a column may be in though nobody said so, by what the coordinate is measured in.
_UNITS = {
    "velocity": {"m": ("mm/s", "cm/s", "m/min", "mm/min"), "rad": ("rpm", "deg/s", "rev/s")},
    "acceleration": {"m": ("mm/s^2", "cm/s^2", "g"), "rad": ("deg/s^2", "rev/s^2")},
}


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionComparison:
    """A measured derivative against a computed one.

    Attributes
    ----------
    factor, factor_deviation : float
        Of the measured one, in the middle of what noise leaves open, with half of that.
    delay, delay_deviation : float
        Of the measured one, samples.
    offset, offset_deviation : float
        What is constant between the two, SI.
    size : float
        Root mean square of the computed one, SI.
    left_percent : float
        What remains of either beside the other, percent of it.
    """

    factor: float
    factor_deviation: float
    delay: float
    delay_deviation: float
    offset: float
    offset_deviation: float
    size: float
    left_percent: float

    @property
    def scaled(self) -> float:
        """Distance of the factor from 1 by what it may be; so are the others."""
        return abs(self.factor - 1) / _allowed(_MAX_MOTION_FACTOR_ERROR, self.factor_deviation)

    @property
    def late(self) -> float:
        """The delay."""
        return abs(self.delay) / _allowed(_MAX_MOTION_DELAY, self.delay_deviation)

    @property
    def moved(self) -> float:
        """The constant."""
        most = _MAX_MOTION_OFFSET * self.size
        return abs(self.offset) / _allowed(most, self.offset_deviation)

    @property
    def other(self) -> float:
        """What is left."""
        return self.left_percent / _MAX_MOTION_DIFFERENCE

    @property
    def worst(self) -> float:
        """The largest of them; beyond 1 something is wrong."""
        return max(self.scaled, self.late, self.moved, self.other)


def _allowed(most: float, deviation: float) -> float:
    return max(most, MIN_DISTANCE_FROM_NOISE.value * deviation)


def compared_motion(record: Record, role: str) -> MotionComparison | Missing:
    """Hold a measured velocity or acceleration against the derivative of what was measured before.

    Parameters
    ----------
    record : Record
        With that column.
    role : {"velocity", "acceleration"}

    Returns
    -------
    MotionComparison or Missing
        Missing where there is no such derivative, or the record is too short or still to tell.
    """
    longest = record.longest()
    by_position = role == "velocity" or record.velocity is None
    if by_position and record.integrated:
        return Missing(
            f"no position was recorded that the {role} could be held against, and no loop can be "
            f"simulated: the scale of the motion rests on the column of the {role} alone"
        )
    basis = longest.position if by_position else np.asarray(longest.velocity)
    times = 2 if role == "acceleration" and by_position else 1
    return _compared(longest, basis, times, np.asarray(getattr(longest, role)))


def compared_with_loop(record: Record, velocities: Sequence[Array]) -> MotionComparison | Missing:
    """Hold a velocity that was measured alone against that of the simulated loop.

    The loop follows the recorded reference, whatever its parameters are but for a little: it has
    the scale and the zero of the motion.

    Parameters
    ----------
    record : Record
        Of a velocity without a position.
    velocities : sequence of (N,) array
        Of the loop, by segment.
    """
    lengths = [len(each) for each in velocities]
    longest = int(np.argmax(lengths))
    return _compared(
        record.longest(), velocities[longest], 0, np.asarray(record.longest().velocity)
    )


def _compared(
    record: Record, basis: Array, times: int, measured: Array
) -> MotionComparison | Missing:
    """Both low-passed alike; the basis is differentiated so many times."""
    period = record.period
    cutoff = min(COMPARISON_CUTOFF.value / period, MAX_FORCE_CUTOFF)
    settle = round(1 / (cutoff * period))
    unmasked = ~covered(record.masked, len(record))
    used = minimum_filter1d(unmasked, 2 * settle + 1, mode="constant", cval=0)
    if used.sum() < MIN_SETTLING_TIMES * settle:
        return Missing("too few samples that follow one another were measured for it")
    smooth = SampledFilter(Prefilter(cutoff=cutoff), period)
    computed, target = smooth.low_passed(basis), smooth.low_passed(measured)
    for _ in range(times):
        computed, target = np.gradient(computed, period), _averaged(target)
    rows = np.flatnonzero(used).astype(np.int64)[
        :: max(settle // _OFTEN, 1)
    ]  # what is slow needs no more
    try:
        return _fitted(computed, target, rows, max(settle // _OFTEN, 1))
    except EstimationError:
        return Missing("the axis hardly moves in what is compared")


def _averaged(values: Array) -> Array:
    """Means over the two samples that a central difference spans, by Simpson's rule."""
    inner = (values[:-2] + 4 * values[1:-1] + values[2:]) / 6
    return np.concatenate([values[:1], inner, values[-1:]])


def _fitted(
    computed: Array, target: Array, rows: NDArray[np.int64], step: int
) -> MotionComparison | Missing:
    order = Neighbours.of(rows, step)
    delay, moved, found = _in_step(computed, target, rows, order)
    back = _fit(target, moved, rows, order)
    deviations = np.sqrt(np.diag(Hac(2 * _OFTEN).matrix(found)))
    low, high = sorted((float(found.theta[0]), 1 / (float(back.theta[0]) or _TINY)))
    gain = (low + high) / 2
    size = float(np.sqrt(np.mean(computed[rows] ** 2)))
    alike = float(found.theta[0] * back.theta[0])  # squared partial correlation
    return MotionComparison(
        factor=gain,
        factor_deviation=float(np.hypot(deviations[0], (high - low) / 2)),
        delay=delay,
        delay_deviation=float(deviations[1] / abs(gain)) if gain else float("inf"),
        offset=float(found.theta[2]),
        offset_deviation=float(deviations[2]),
        size=size,
        left_percent=100 * float(np.sqrt(max(1 - alike, 0.0))),
    )


def _in_step(
    computed: Array, target: Array, rows: NDArray[np.int64], order: Neighbours
) -> tuple[float, Array, Solution]:
    """The delay that leaves none to be fitted, what is so moved, and the fit; else none is taken.

    Two signals that have nothing to do with each other have no delay.
    """
    first = _fit(computed, target, rows, order)
    delay, moved, found = 0.0, computed, first
    for _ in range(_STEPS):
        change = -float(found.theta[1]) / float(found.theta[0]) if found.theta[0] else np.inf
        delay += change
        if not abs(delay) < _FARTHEST:
            return 0.0, computed, first
        moved = np.asarray(shift(computed, delay, order=3, mode="nearest"), dtype=float)
        found = _fit(moved, target, rows, order)
        if abs(change) < _STILL:
            break
    return delay, moved, found


def _fit(given: Array, target: Array, rows: NDArray[np.int64], order: Neighbours) -> Solution:
    """The target by a factor of what is given, its change in a sample, and a constant."""
    columns = np.column_stack([given, np.gradient(given), np.ones_like(given)])[rows]
    regressor = factor(columns, ("factor", "delay", "offset"), neighbours=order)
    return least_squares(target[rows], regressor)


def compared_motions(
    record: Record, velocities: Sequence[Array] = ()
) -> dict[str, MotionComparison | Missing]:
    """`compared_motion` of each of the two that was measured.

    A velocity without a position is held against those of the simulated loop, (N,) by segment,
    where there are any.
    """
    found = {role: compared_motion(record, role) for role in record.motion if role != "position"}
    if record.integrated and velocities and "velocity" in found:
        found["velocity"] = compared_with_loop(record, velocities)
    return found


def motion_check(
    axis: GeneratedAxis, record: Record, role: str, found: MotionComparison | Missing | None
) -> Check | Missing | None:
    """What was found of a measured velocity or acceleration; nothing without the column."""
    if found is None or isinstance(found, Missing):
        return found
    against, told = _derivative(record, role), _told(axis, found, role)
    meaning, remedy = f"the measured {role} is {against} ({told})", None
    if found.other > 1:
        meaning = (
            f"the measured {role} is not {against}: {found.left_percent:.3g} % are left whatever "
            f"factor, delay and constant ({told}): "
        )
        remedy = Remedy.of("check the column (", Setting("columns", f"{role}=NAME:UNIT"), ")")
    elif found.worst > 1:
        meaning = f"the measured {role} is {told} beside {against}: "
        remedy = _remedy(axis, record, found, role)
    return Check(
        name=f"measured {role}",
        status=passed(found.worst <= 1),
        figure=found.worst if np.isfinite(found.worst) else None,
        threshold=1.0,
        source="largest of the factor's distance from 1 by "
        f"{_MAX_MOTION_FACTOR_ERROR:g}, the delay by {_MAX_MOTION_DELAY:g} samples and "
        f"the constant by {100 * _MAX_MOTION_OFFSET:g} % of the {role}, or by three of their "
        "deviations where these are more",
        meaning=meaning,
        remedy=remedy,
    )


def _derivative(record: Record, role: str) -> str:
    if role == "velocity" and record.integrated:
        return "that of the simulated loop, which follows the reference"
    if role == "velocity":
        return "the position's derivative"
    return (
        "the position's second derivative"
        if record.velocity is None
        else ("the measured velocity's derivative")
    )


def _told(axis: GeneratedAxis, found: MotionComparison, role: str) -> str:
    """Factor, delay and constant with their deviations."""
    q = axis.axis.coordinate
    unit = q.velocity_unit if role == "velocity" else q.acceleration_unit
    way = "late" if found.delay >= 0 else "early"
    return (
        f"{found.factor:.4g} +- {max(found.factor_deviation, 1e-4):.1g} times, "
        f"{abs(found.delay):.2f} +- {max(found.delay_deviation, 1e-2):.1g} samples {way} and "
        f"{found.offset:+.3g} +- {found.offset_deviation:.1g} {unit}"
    )


def _remedy(axis: GeneratedAxis, record: Record, found: MotionComparison, role: str) -> Remedy:
    """What sets right what is wrong."""
    parts: list[Remedy] = []
    name = record.provenance.columns.get(role, "NAME")
    if found.late > 1:
        parts.append(_in_time(record, found, role))
    if found.scaled > 1:
        beside = "reference" if role == "velocity" and record.integrated else "position"
        parts.append(_in_scale(axis, found, role, name, beside))
    if found.moved > 1:
        unit = f"{axis.axis.coordinate.unit}/s{'^2' * (role == 'acceleration')}"
        zero = Setting("columns", f"{role}={name}:UNIT{-found.offset:+.3g}{unit}")
        parts.append(Remedy.of("take off its zero (", zero, ")"))
    joined: list[Remedy | str] = []
    for part in parts:
        joined += [", and ", part] if joined else [part]
    return Remedy.of(*joined)


def _in_time(record: Record, found: MotionComparison, role: str) -> Remedy:
    apart = samples_apart(getattr(record, role))
    if apart > 1:
        return Remedy.of("draw it between its values (", advised_between(role), ")")
    return advised_shift(role, found.delay, _MAX_MOTION_DELAY)


def _in_scale(
    axis: GeneratedAxis, found: MotionComparison, role: str, name: str, beside: str
) -> Remedy:
    vague = MIN_DISTANCE_FROM_NOISE.value * found.factor_deviation + _MAX_MOTION_FACTOR_ERROR
    for unit in _UNITS[role][axis.axis.coordinate.unit]:
        known = label_unit(unit)
        if known is not None and abs(found.factor * known[0] - 1) <= vague:
            return Remedy.of("it is in ", Setting("columns", f"{role}={name}:{unit}"))
    if abs(found.factor + 1) <= vague:
        return Remedy.of("turn its sign (", Setting("columns", f"{role}={name}:UNIT*-1"), ")")
    return Remedy.of(
        f"check its unit and scale, and those of the {beside} (",
        Setting("columns", f"{role}={name}:UNIT"),
        ")",
    )
