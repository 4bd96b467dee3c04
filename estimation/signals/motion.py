"""Missing excitation of a motion: one direction only, one speed only, or much standstill."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.findings import Finding
from axisid.estimation.thresholds import MIN_MOVING_SPEED

from .signals import Signals

# Speed relative to the largest speed, below which an axis is at rest, with noise or creep.
_MAX_REST_SPEED = 0.005
# Share of the samples in motion in the rarer direction, below which the axis hardly reverses.
_MIN_REVERSED_SHARE = 0.01
_MIN_STEADY_SAMPLES = 16  # smallest number of samples at steady speed that show a single speed
_MIN_SPEED_SPREAD = 0.1  # spread relative to the cruising speed, below which there is one speed
# Acceleration relative to the largest acceleration, below which the speed is steady.
_MAX_STEADY_ACCELERATION = 0.1
# Largest share of the samples of a fit at rest. Measured: a share of an eighth changes the
# estimated friction by a tenth, a share of a third changes most of it.
MAX_REST_SHARE = 0.1


def motion_lacks(signals: Signals) -> tuple[str, ...]:
    """Return sentences on missing excitation, one direction or one speed only; empty for none."""
    return tuple(filter(None, (one_direction(signals), one_speed(signals))))


def resting(signals: Signals, used: NDArray[np.bool_], others_fastest: float = 0.0) -> float:
    """Return the share of the samples of a fit at which the axis is at standstill.

    Parameters
    ----------
    signals : Signals
        Signals of all N samples.
    used : (N,) array of bool
        True for samples of the fit.
    others_fastest : float
        Largest speed of other records of the machine, m/s or rad/s.
    """
    speed = np.abs(signals.velocity)
    still = speed[used] < _MAX_REST_SPEED * max(float(speed.max()), others_fastest)
    return float(np.mean(still)) if used.any() else 0.0


def one_direction(signals: Signals) -> str:
    """Return a sentence if the velocity (nearly) always has the same sign; empty otherwise."""
    moving = signals.velocity[_in_motion(signals)]
    forward = float(np.mean(moving > 0)) if len(moving) else 0.0
    if _MIN_REVERSED_SHARE <= forward <= 1 - _MIN_REVERSED_SHARE:
        return ""
    return f"the velocity {'never' if forward in (0, 1) else 'hardly ever'} changes sign"


def one_speed(signals: Signals) -> str:
    """Return a sentence if there is only one cruising speed; empty otherwise.

    The axis passes other speeds while it accelerates, but these samples do not separate friction
    terms well.
    """
    acceleration = np.abs(signals.acceleration)
    steady = acceleration < _MAX_STEADY_ACCELERATION * acceleration.max()
    speeds = np.abs(signals.velocity[_in_motion(signals) & steady])
    if len(speeds) < _MIN_STEADY_SAMPLES:
        return ""
    low, middle, high = np.quantile(speeds, [0.1, 0.5, 0.9])
    return "the axis has one cruising speed only" if high - low < _MIN_SPEED_SPREAD * middle else ""


def _in_motion(signals: Signals) -> NDArray[np.bool_]:
    """Return True for samples in motion, (N,)."""
    speed = np.abs(signals.velocity)
    return np.asarray(speed > MIN_MOVING_SPEED.value * speed.max())


@dataclass(frozen=True, slots=True, kw_only=True)
class RestingAxis(Finding):
    """Standstill in so many samples of a fit that sticking friction biases the fit.

    Attributes
    ----------
    percent : float
        Share of the samples of the fit with the axis at standstill, %.
    """

    percent: float


def resting_axis(rest: float) -> RestingAxis | None:
    """Return the finding that an axis is at standstill in too many samples of a fit; None if not.

    Parameters
    ----------
    rest : float
        Share of the samples of the fit at which the axis is at standstill.
    """
    return RestingAxis(percent=100 * rest) if rest > MAX_REST_SHARE else None
