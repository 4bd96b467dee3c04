"""What a motion lacks to show parameters, and how much of it is rest."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.thresholds import MIN_MOVING_SPEED, REST_SPEED
from axisid.support.arrays import runs
from axisid.support.remedy import Note, Remedy, Setting

from .sampled_filter import Span
from .signals import Signals

_MAX_REST_SPEED = 0.01  # of the largest, on average: what noise may make of a rest
# of the samples in motion go the other way; with fewer the axis hardly reverses
_MIN_REVERSED_SHARE = 0.01
_MIN_STEADY_SAMPLES = 16  # at steady speed, from which it is told whether there is one speed only
_MIN_SPEED_SPREAD = 0.1  # of the cruising speed, relative; below, there is one speed only
_MAX_STEADY_ACCELERATION = 0.1  # of the largest; below, the speed is steady
# of the samples of the fit: measured, an eighth at rest moves friction by a tenth, a third by
# most of it
MAX_REST_SHARE = 0.1


def motion_lacks(signals: Signals) -> tuple[str, ...]:
    """What a motion lacks, in words, whatever the axis."""
    facts = (one_direction(signals), one_speed(signals))
    return tuple(fact for fact in facts if fact)


def resting(
    signals: Signals, spans: Sequence[Span], used: NDArray[np.bool_], beside: float = 0.0
) -> float:
    """Part of the samples of a fit at which the axis stands still.

    Parameters
    ----------
    signals : Signals
        (N,)
    spans : sequence of (int, int)
        Segments of the record.
    used : (N,) array of bool
        Samples of the fit.
    beside : float
        Largest speed of other records of the machine.
    """
    still = np.zeros(len(used), dtype=bool)
    fastest = max(float(np.abs(signals.velocity).max()), beside)
    for first, last in spans:
        speed = signals.velocity[first:last]
        for start, stop in runs(np.abs(speed) < MIN_MOVING_SPEED.value * fastest):
            # It stops and starts slowly. Creeping gets somewhere, reversing does not stay.
            within = slice(start + (stop - start) // 4, stop - (stop - start) // 4)
            drift = abs(float(np.mean(speed[within])))
            stays = float(np.mean(np.abs(speed[within]))) < _MAX_REST_SPEED * fastest
            still[first + start : first + stop] = stays and drift < REST_SPEED.value * fastest
    return float(np.mean(still[used])) if used.any() else 0.0


def one_direction(signals: Signals) -> str:
    """That the velocity has one sign, in words; empty if it has both."""
    moving = signals.velocity[_in_motion(signals)]
    forward = float(np.mean(moving > 0)) if len(moving) else 0.0
    if _MIN_REVERSED_SHARE <= forward <= 1 - _MIN_REVERSED_SHARE:
        return ""
    return f"the velocity {'never' if forward in (0, 1) else 'hardly ever'} changes its sign"


def one_speed(signals: Signals) -> str:
    """One cruising speed; accelerating through others in between does not tell them apart well."""
    acceleration = np.abs(signals.acceleration)
    steady = acceleration < _MAX_STEADY_ACCELERATION * acceleration.max()
    speeds = np.abs(signals.velocity[_in_motion(signals) & steady])
    if len(speeds) < _MIN_STEADY_SAMPLES:
        return ""
    low, middle, high = np.quantile(speeds, [0.1, 0.5, 0.9])
    return "there is one speed only" if high - low < _MIN_SPEED_SPREAD * middle else ""


def _in_motion(signals: Signals) -> NDArray[np.bool_]:
    speed = np.abs(signals.velocity)
    return np.asarray(speed > MIN_MOVING_SPEED.value * speed.max())


def rests_first(rest: float) -> Note | None:
    """What to say of a fit that is mostly of an axis at rest; None for another."""
    if rest <= MAX_REST_SHARE:
        return None
    return Note(
        f"the axis rests in {100 * rest:.0f} % of the samples that the fit has, where sticking "
        "friction takes any force and no model gives it: ",
        Remedy.of(
            "leave the rests out (",
            Setting("reversals", "leave-out"),
            ", at a higher cut-off if too little is left) before anything else is checked",
        ),
    )
