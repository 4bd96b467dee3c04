"""What a motion lacks to show parameters, and how much of it is rest."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import runs

from .prefilter import Span
from .reversals import REST
from .signals import Signals

_FEWEST = 16  # samples at steady speed
_MOVING = 0.05  # of the largest speed
_STILL = 0.01  # of the largest speed, which noise may make of a rest
_REVERSED = 0.01  # of the samples in motion
_ONE_SPEED = 0.1  # spread of the cruising speed, relative
_STEADY = 0.1  # of the largest acceleration


def motion_lacks(signals: Signals) -> tuple[str, ...]:
    """What a motion lacks, in words, whatever the axis."""
    facts = (one_direction(signals), one_speed(signals))
    return tuple(fact for fact in facts if fact)


def resting(signals: Signals, spans: Sequence[Span], used: NDArray[np.bool_]) -> float:
    """Part of the samples of a fit at which the axis stands still.

    Parameters
    ----------
    signals : Signals
        (N,)
    spans : sequence of (int, int)
        Segments of the record.
    used : (N,) array of bool
        Samples of the fit.
    """
    still, fastest = np.zeros(len(used), dtype=bool), float(np.abs(signals.velocity).max())
    for first, last in spans:
        speed = signals.velocity[first:last]
        for start, stop in runs(np.abs(speed) < _MOVING * fastest):
            # It stops and starts slowly. Creeping gets somewhere, reversing does not stay.
            within = slice(start + (stop - start) // 4, stop - (stop - start) // 4)
            drift = abs(float(np.mean(speed[within])))
            stays = float(np.mean(np.abs(speed[within]))) < _STILL * fastest
            still[first + start : first + stop] = stays and drift < REST * fastest
    return float(np.mean(still[used])) if used.any() else 0.0


def one_direction(signals: Signals) -> str:
    """That the velocity has one sign, in words; empty if it has both."""
    moving = signals.velocity[_in_motion(signals)]
    forward = float(np.mean(moving > 0)) if len(moving) else 0.0
    if _REVERSED <= forward <= 1 - _REVERSED:
        return ""
    return f"the velocity {'never' if forward in (0, 1) else 'hardly ever'} changes its sign"


def one_speed(signals: Signals) -> str:
    """One cruising speed; accelerating through others in between does not tell them apart well."""
    steady = np.abs(signals.acceleration) < _STEADY * np.abs(signals.acceleration).max()
    speeds = np.abs(signals.velocity[_in_motion(signals) & steady])
    if len(speeds) < _FEWEST:
        return ""
    low, middle, high = np.quantile(speeds, [0.1, 0.5, 0.9])
    return "there is one speed only" if high - low < _ONE_SPEED * middle else ""


def _in_motion(signals: Signals) -> NDArray[np.bool_]:
    speed = np.abs(signals.velocity)
    return np.asarray(speed > _MOVING * speed.max())


MOST_REST = 0.1  # of the samples that the fit has


def rests_first(rest: float) -> str:
    """What to say of a fit that is mostly of an axis at rest; empty for another."""
    if rest <= MOST_REST:
        return ""
    return (
        f"the axis rests in {100 * rest:.0f} % of the samples that the fit has, where sticking "
        "friction takes any force and no model gives it: leave the rests out (--reversals "
        "leave-out, at a higher cut-off if too little is left) before anything else is checked"
    )
