"""The signals that a regressor is made of, and what a motion shows of an axis.

Recorded signals are no part of what is differentiated, so that they stand in the rows as the force
does: as they were recorded. Products of them and the motion are made sample by sample, and both
sides of the rows then take the same decimation filter. What is held changes at a sample: its mean
about the sample belongs to the acceleration there.

Without the samples near reversals and rests friction is not rounded, which is worth much, but an
axis that accelerates only where it turns hardly shows its inertia. What tells is the information on
a parameter, the inverse of its variance for noise of one size. Rests are no loss, as sticking
friction takes any force; nor is friction that depends on the speed, such as a peak about rest, as
the low-pass rounds that near reversals. Coulomb friction counts: where it loses much, little else
tells it from other terms.

Of an axis that is partially linear the columns are those of the Jacobian at the nominal values.
One whose nonlinear parameters are of such friction is not asked: what the low-pass makes of a peak
about rest leads its search astray, however much of the inertia is lost with it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.thresholds import MIN_MOVING_SPEED
from axisid.support.arrays import Array, Exact
from axisid.support.errors import DataError

#: Position, velocity and acceleration, each (N,), SI.
Motion = tuple[Array, Array, Array]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signals(Exact):
    """Motion and force sample by sample, each (N,), SI.

    `direction` is the friction direction: the sign of the velocity, and between -1 and 1 for an
    axis that sticks. `recorded` are the signals that the axis declares, in its order.
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
    """Force that the drive makes of a control, (N,), by the motion and the signals beside it."""
    return axis.evaluate("drive_force", control, position, velocity, *recorded)[0][:, 0]


def hold_mean(values: Array, starts: Sequence[int], delay: float = 0.5) -> Array:
    """The mean of what is held just before and just after each sample, (N,), segment by segment.

    That is half a sample late. Of what is held for less than a sample, only the value at each is
    known: it is taken that much later along a straight line.
    """
    before = np.concatenate([values[:1], values[:-1]])
    before[starts] = values[starts]
    return np.asarray((1 - delay) * values + delay * before, dtype=float)


def recorded_signals(
    axis: GeneratedAxis, source: str, columns: Mapping[str, Array]
) -> tuple[Array, ...]:
    """The signals that an axis declares, in its order, (N,) each.

    Parameters
    ----------
    axis : GeneratedAxis
    source : str
        Of the record, for messages.
    columns : mapping of str to (N,) array
        By role or name.

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


_MAX_REST_SPEED = 0.005  # of the largest, below which an axis rests, whatever noise or creep it is
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
    return tuple(filter(None, (one_direction(signals), one_speed(signals))))


def resting(signals: Signals, used: NDArray[np.bool_], others_fastest: float = 0.0) -> float:
    """Part of the samples of a fit at which the axis stands still.

    Parameters
    ----------
    signals : Signals
        (N,)
    used : (N,) array of bool
        Samples of the fit.
    others_fastest : float
        Largest speed of other records of the machine.
    """
    speed = np.abs(signals.velocity)
    still = speed[used] < _MAX_REST_SPEED * max(float(speed.max()), others_fastest)
    return float(np.mean(still)) if used.any() else 0.0


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


def advice_on_rests(rest: float) -> str | None:
    """What to say of a fit that is mostly of an axis at rest; None for another."""
    if rest <= MAX_REST_SHARE:
        return None
    return (
        f"the axis rests in {100 * rest:.0f} % of the samples that the fit has, where "
        "sticking friction takes any force and no model gives it: leave the rests out "
        '(reversals="leave-out", at a higher cut-off if too little is left) before '
        "anything else is checked"
    )


_SIGNALS = ("position", "velocity", "acceleration", "direction")  # as the regressor takes them
_SMALLEST = 1e-100  # whose square is exact
_RIDGE = 1e-12  # of a column, in which it is not told from others


def remaining_information(counts: NDArray[np.bool_], moving: Array, remaining: Array) -> float:
    """The least part of the information on a parameter that is left.

    Parameters
    ----------
    counts : (P,) array of bool
        Of which parameters a loss counts, see `loss_counts_for`.
    moving, remaining : (P, P) array
        Products of the regressor's columns of all samples in motion, and of those that are left.
    """
    both = moving + remaining
    if not np.all(np.isfinite(both)):
        return 1.0  # whatever is done, the regression will say what is wrong
    size = np.sqrt(np.diag(both))
    counted = counts & (np.diag(moving) > 0)
    scale = np.outer(*(np.where(size > _SMALLEST, size, 1.0),) * 2)
    ridge = _RIDGE * np.eye(len(both))
    # Of each parameter beside the others.
    before, after = (
        1 / np.diag(np.linalg.inv(each / scale + ridge)) for each in (moving, remaining)
    )
    return float(np.min(after[counted] / before[counted], initial=1.0))


def loss_counts_for(axis: GeneratedAxis) -> NDArray[np.bool_]:
    """Of which parameters, (p,), a loss counts: none of friction that depends on the speed."""
    depends = columns_by_signal(axis)
    return ~(depends["direction"] & depends["velocity"])


def columns_of(axis: GeneratedAxis, signals: Signals) -> Array:
    """Of the inverse model, (N, p), for each of its parameters."""
    motion = (signals.position, signals.velocity, signals.acceleration, signals.direction)
    # A partially linear model is linearised where an amount of 0 would not hide what it scales.
    hidden = (axis.nominal == 0) & ~np.array(axis.nonlinear)
    about = () if axis.is_linear else (np.where(hidden, 1.0, axis.nominal),)
    columns, _ = axis.evaluate("idm_regressor", *motion, *signals.recorded, *about)
    return columns


def searches_friction(axis: GeneratedAxis) -> bool:
    """Whether a nonlinear parameter is of friction that depends on the speed."""
    return bool(np.any(np.array(axis.nonlinear) & ~loss_counts_for(axis)))


@lru_cache(maxsize=32)  # asked of an axis in every identification
def columns_by_signal(axis: GeneratedAxis) -> dict[str, NDArray[np.bool_]]:
    """Which columns of the inverse model, (p,), depend on which signal, or on recorded ones."""
    depends = dict.fromkeys((*_SIGNALS, "recorded"), np.zeros(len(axis.parameters), dtype=bool))
    names = (*_SIGNALS, *("recorded" for _ in axis.signals))
    for place, name in enumerate(names):
        rows, _ = axis.functions["idm_regressor"].jac_sparsity(0, place).get_triplet()
        depends[name] = depends[name] | np.isin(np.arange(len(axis.parameters)), rows)
    return depends
