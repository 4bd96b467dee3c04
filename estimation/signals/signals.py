"""Signals of the regressor, and the information that a motion has on the parameters of an axis.

Recorded signals are not differentiated, so that they enter the rows unfiltered, as the force does.
Products with the motion are computed sample by sample, and both sides of the rows then pass the
same decimation filter. A held signal changes at a sample: its mean about the sample belongs to the
acceleration there.

Without the samples near reversals and rests the low-pass does not round the friction, which is a
large gain; but an axis that accelerates only where it reverses then hardly shows its inertia. The
criterion is the information on a parameter, the inverse of its variance for noise of a fixed
variance. Samples at rest are no loss, as sticking friction takes any force; nor are those of
friction that depends on speed, such as a peak about rest, as the low-pass rounds it near reversals.
Coulomb friction counts: where it loses much information, it is hardly separable from other terms.

For a partially linear axis the columns are those of the Jacobian at the nominal values. The
criterion does not apply to an axis with nonlinear parameters of speed-dependent friction: the
rounded peak about rest would mislead the search, whatever information on the inertia is lost.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.findings import Finding
from axisid.estimation.thresholds import MIN_MOVING_SPEED
from axisid.support.arrays import Array, Exact
from axisid.support.errors import DataError

#: Position, velocity and acceleration, each (N,), SI.
Motion = tuple[Array, Array, Array]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signals(Exact):
    """Motion and force sample by sample, each (N,), SI.

    `direction` is the friction direction: the sign of the velocity, or between -1 and 1 while the
    axis sticks. `recorded` has the recorded signals in the order of the axis's declaration.
    """

    position: Array
    velocity: Array
    acceleration: Array
    force: Array
    direction: Array
    recorded: tuple[Array, ...] = ()


def drive_force(
    axis: GeneratedAxis,
    control: Array,
    position: Array,
    velocity: Array,
    recorded: Sequence[Array] = (),
) -> Array:
    """Return the drive's force for a control, a motion and recorded signals, (N,)."""
    return axis.evaluate("drive_force", control, position, velocity, *recorded)[0][:, 0]


def hold_mean(values: Array, starts: Sequence[int], delay: float = 0.5) -> Array:
    """Return the mean of the held values just before and just after each sample, (N,).

    ``(1 - d) x_k + d x_(k-1)`` with the delay d, within segments. The mean is half a sample late. A
    value that is held for less than a sample is interpolated linearly, d samples late.

    Parameters
    ----------
    values : (N,) array
    starts : sequence of int
        First samples of the segments.
    delay : float
        d, samples.
    """
    before = np.concatenate([values[:1], values[:-1]])
    before[starts] = values[starts]
    return np.asarray((1 - delay) * values + delay * before, dtype=float)


def recorded_signals(
    axis: GeneratedAxis, source: str, columns: Mapping[str, Array]
) -> tuple[Array, ...]:
    """Return the recorded signals in the order of the axis's declaration, (N,) each.

    Parameters
    ----------
    axis : GeneratedAxis
    source : str
        Name of the record, for messages.
    columns : mapping of str to (N,) array
        Columns by role or name.

    Raises
    ------
    DataError
        The record lacks one.
    """
    names = [signal.name for signal in axis.signals]
    if missing := [name for name in names if name not in columns]:
        raise DataError(
            f"{source} has no column for {', '.join(missing)}, which axis {axis.name!r} has "
            "as recorded signals; name it with columns "
            f"{','.join(f'{name}=NAME' for name in missing)}.",
            code="missing-column",
        )
    return tuple(columns[name] for name in names)


_MAX_REST_SPEED = 0.005  # of the largest speed, below which an axis rests, noise or creep included
# share of the samples in motion in the rarer direction, below which the axis hardly reverses
_MIN_REVERSED_SHARE = 0.01
_MIN_STEADY_SAMPLES = 16  # samples at steady speed that are needed to find a single speed
_MIN_SPEED_SPREAD = 0.1  # spread relative to the cruising speed, below which there is one speed
_MAX_STEADY_ACCELERATION = 0.1  # of the largest acceleration, below which the speed is steady
# share of the samples of a fit at rest: measured, an eighth at rest changes friction by a tenth, a
# third changes most of it
MAX_REST_SHARE = 0.1


def motion_lacks(signals: Signals) -> tuple[str, ...]:
    """Return sentences on missing excitation: one direction only, one speed only."""
    return tuple(filter(None, (one_direction(signals), one_speed(signals))))


def resting(signals: Signals, used: NDArray[np.bool_], others_fastest: float = 0.0) -> float:
    """Return the share of the samples of a fit at which the axis is at standstill.

    Parameters
    ----------
    signals : Signals
        Of N samples.
    used : (N,) array of bool
        Samples of the fit.
    others_fastest : float
        Largest speed of other records of the machine.
    """
    speed = np.abs(signals.velocity)
    still = speed[used] < _MAX_REST_SPEED * max(float(speed.max()), others_fastest)
    return float(np.mean(still)) if used.any() else 0.0


def one_direction(signals: Signals) -> str:
    """Return a sentence if the velocity has only one sign; empty if it has both."""
    moving = signals.velocity[_in_motion(signals)]
    forward = float(np.mean(moving > 0)) if len(moving) else 0.0
    if _MIN_REVERSED_SHARE <= forward <= 1 - _MIN_REVERSED_SHARE:
        return ""
    return f"the velocity {'never' if forward in (0, 1) else 'hardly ever'} changes its sign"


def one_speed(signals: Signals) -> str:
    """Return a sentence if there is only one cruising speed; empty otherwise.

    Accelerating through other speeds does not separate friction terms well.
    """
    acceleration = np.abs(signals.acceleration)
    steady = acceleration < _MAX_STEADY_ACCELERATION * acceleration.max()
    speeds = np.abs(signals.velocity[_in_motion(signals) & steady])
    if len(speeds) < _MIN_STEADY_SAMPLES:
        return ""
    low, middle, high = np.quantile(speeds, [0.1, 0.5, 0.9])
    return "there is one speed only" if high - low < _MIN_SPEED_SPREAD * middle else ""


def _in_motion(signals: Signals) -> NDArray[np.bool_]:
    """Return True for samples in motion, (N,)."""
    speed = np.abs(signals.velocity)
    return np.asarray(speed > MIN_MOVING_SPEED.value * speed.max())


@dataclass(frozen=True, slots=True, kw_only=True)
class RestingAxis(Finding):
    """An axis that rests in so many samples of a fit that sticking friction misleads it.

    Attributes
    ----------
    percent : float
        Of the samples that the fit has.
    """

    percent: float


def resting_axis(rest: float) -> RestingAxis | None:
    """Return the finding of an axis that rests in too many samples of a fit; None for another.

    Parameters
    ----------
    rest : float
        Part of the samples of the fit at which the axis rests.
    """
    return RestingAxis(percent=100 * rest) if rest > MAX_REST_SHARE else None


_SIGNALS = ("position", "velocity", "acceleration", "direction")  # as the regressor takes them
_SMALLEST = 1e-100  # smaller values have inexact squares
_RIDGE = 1e-12  # relative to a column: added so that dependent columns can be inverted


def remaining_information(counts: NDArray[np.bool_], moving: Array, remaining: Array) -> float:
    """Return the smallest ratio over the parameters of the remaining to the whole information.

    The information on parameter j is ``1 / [(X'X)^-1]_jj``.

    Parameters
    ----------
    counts : (P,) array of bool
        Parameters that are considered, see `loss_counts_for`.
    moving, remaining : (P, P) array
        ``X'X`` of all samples in motion, and of the remaining samples.
    """
    both = moving + remaining
    if not np.all(np.isfinite(both)):
        return 1.0  # the regression refuses such a record with a reason
    size = np.sqrt(np.diag(both))
    counted = counts & (np.diag(moving) > 0)
    scale = np.outer(*(np.where(size > _SMALLEST, size, 1.0),) * 2)
    ridge = _RIDGE * np.eye(len(both))
    # Information on each parameter with all others unknown.
    before, after = (
        1 / np.diag(np.linalg.inv(each / scale + ridge)) for each in (moving, remaining)
    )
    return float(np.min(after[counted] / before[counted], initial=1.0))


def loss_counts_for(axis: GeneratedAxis) -> NDArray[np.bool_]:
    """Return True for parameters whose loss of information matters, (p,).

    False for friction that depends on speed.
    """
    depends = columns_by_signal(axis)
    return ~(depends["direction"] & depends["velocity"])


def columns_of(axis: GeneratedAxis, signals: Signals) -> Array:
    """Return the columns of the inverse model, or of its Jacobian, for each parameter, (N, p)."""
    motion = (signals.position, signals.velocity, signals.acceleration, signals.direction)
    # Factors of 0 are set to 1, as a factor of 0 would hide the terms that it scales.
    hidden = (axis.nominal == 0) & ~np.array(axis.nonlinear)
    about = () if axis.is_linear else (np.where(hidden, 1.0, axis.nominal),)
    columns, _ = axis.evaluate("idm_regressor", *motion, *signals.recorded, *about)
    return columns


def searches_friction(axis: GeneratedAxis) -> bool:
    """Return True if a nonlinear parameter belongs to friction that depends on speed."""
    return bool(np.any(np.array(axis.nonlinear) & ~loss_counts_for(axis)))


@lru_cache(maxsize=32)  # asked of an axis in every identification
def columns_by_signal(axis: GeneratedAxis) -> dict[str, NDArray[np.bool_]]:
    """Return for each signal True for the columns of the inverse model that depend on it, (p,)."""
    depends = dict.fromkeys((*_SIGNALS, "recorded"), np.zeros(len(axis.parameters), dtype=bool))
    names = (*_SIGNALS, *("recorded" for _ in axis.signals))
    for place, name in enumerate(names):
        rows, _ = axis.functions["idm_regressor"].jac_sparsity(0, place).get_triplet()
        depends[name] = depends[name] | np.isin(np.arange(len(axis.parameters)), rows)
    return depends
