"""Friction of a record by velocity, and the fitted friction law."""

from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification
from axisid.estimation.regression import InverseForm
from axisid.estimation.signals import Signals
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from axisid.support.wording import first_case

_MAX_WEIGHT_DIFFERENCE = 0.02  # of a row's weight from 1, up to which it is a point of the curve
# largest part of the friction that depends on other signals than the velocity, for a curve
_MAX_INSEPARABLE_FORCE = 1e-6
_MIN_BIN_ROWS = 4  # fewest rows in a bin of velocity whose mean is shown

_BINS = 41
_PROBES = 200


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrictionCurve:
    """Friction by velocity: the force minus the part of the model that is independent of velocity.

    Attributes
    ----------
    velocity, force : (n,) array
        Velocity and friction of the rows: recorded force minus the parts of the model that do not
        depend on velocity.
    skipped : int
        Number of rows that are not shown, because some of their samples have no weight in the
        estimate: the filtered velocity and force of such a row are too small, and do not lie on the
        friction law.
    binned : (b, 3) array
        Velocity, mean and standard deviation of the force, by bin of velocity.
    law : (m, 2) array
        Velocity and fitted force; NaN between the two directions.
    """

    velocity: Array
    force: Array
    skipped: int
    binned: Array
    law: Array


def friction_curve(result: "Identification", estimate: "Estimate") -> FrictionCurve | Missing:
    """Return the friction by velocity, or the reason why it cannot be shown.

    Parameters
    ----------
    result : Identification
    estimate : Estimate
        An estimate of the result.
    """
    axis, physical = result.axis, estimate.physical
    data, signals = result.data, result.data.signals
    if reason := _inseparable(axis, physical, signals):
        return Missing(reason)
    friction = signals.force - _force(axis, physical, _still(signals))
    reduced = data.reduce(np.column_stack([signals.velocity, friction]))
    weights = data.sampling.weights
    # Rows all of whose samples have their full weight.
    whole = np.abs(weights / data.sampling.filter.row_gain - 1) < _MAX_WEIGHT_DIFFERENCE
    if not whole.any():
        return Missing("every row contains samples near velocity reversals or standstill")
    velocity, force = (reduced[whole] / weights[whole, None]).T
    return FrictionCurve(
        velocity=velocity,
        force=force,
        skipped=len(whole) - int(whole.sum()),
        binned=_binned(velocity, force),
        law=_law(axis, physical, signals, velocity),
    )


def _force(axis: GeneratedAxis, physical: Array, signals: Signals) -> Array:
    """Return the force of the model with parameters (p,) along a motion, (N,)."""
    return InverseForm(axis).at(physical).equations(signals).predicted(physical)


def _still(signals: Signals) -> Signals:
    """Return the same positions and accelerations without velocity and friction direction."""
    return replace(signals, velocity=0 * signals.velocity, direction=0 * signals.direction)


def _at(signals: Signals, velocity: Array, sample: int | None = None) -> Signals:
    """Return signals with given velocities, (m,), at one position and acceleration.

    Position, acceleration and recorded signals are those of the sample with the index `sample`; for
    None they are the medians over all samples.
    """
    many = np.ones_like(velocity)
    position, acceleration, *recorded = (
        float(np.median(values) if sample is None else values[sample])
        for values in (signals.position, signals.acceleration, *signals.recorded)
    )
    return Signals(
        position=position * many,
        velocity=velocity,
        acceleration=acceleration * many,
        force=many,
        direction=np.sign(velocity),
        recorded=tuple(value * many for value in recorded),
    )


def _velocity_part(axis: GeneratedAxis, physical: Array, signals: Signals) -> Array:
    """Return the part of the model's force that depends on the velocity, (N,)."""
    return _force(axis, physical, signals) - _force(axis, physical, _still(signals))


def _inseparable(axis: GeneratedAxis, physical: Array, signals: Signals) -> str:
    """Return the reason why friction is not a function of velocity; empty if it is one.

    The velocity-dependent force over a range of velocities is compared between samples.
    """
    probes = np.linspace(0, len(signals.velocity) - 1, _PROBES).astype(int)
    velocity = float(np.max(np.abs(signals.velocity))) * np.linspace(-1, 1, 20)  # without 0
    parts = np.array([_velocity_part(axis, physical, _at(signals, velocity, i)) for i in probes])
    size = float(np.max(np.abs(parts)))
    return first_case(
        (not np.isfinite(size), "the model's force is not finite at the estimate"),
        (size == 0, "no term of the equation of motion depends on the velocity"),
        (
            float(np.max(np.ptp(parts, axis=0))) > _MAX_INSEPARABLE_FORCE * size,
            "the part of the force that depends on the velocity also depends on the position, the "
            "acceleration or a recorded signal, so that it is not a curve over the velocity",
        ),
        (True, ""),
    )


def _binned(velocity: Array, force: Array) -> Array:
    """Return velocity, mean and standard deviation of the force by bin of velocity, (b, 3).

    The array lacks bins with few rows.
    """
    edges = np.linspace(velocity.min(), velocity.max(), _BINS + 1)
    if edges[0] < 0 < edges[-1]:  # no bin has rows of both directions
        edges = np.insert(edges, np.searchsorted(edges, 0.0), 0.0)
    which = np.clip(np.digitize(velocity, edges) - 1, 0, len(edges) - 2)
    rows = [
        (velocity[inside].mean(), force[inside].mean(), force[inside].std())
        for inside in (which == i for i in range(len(edges) - 1))
        if np.count_nonzero(inside) >= _MIN_BIN_ROWS
    ]
    return np.array(rows).reshape(-1, 3)


def _law(axis: GeneratedAxis, physical: Array, signals: Signals, velocity: Array) -> Array:
    """Return velocity and fitted friction on both sides of standstill, (m, 2).

    At standstill, where friction may take several values, the force is NaN.
    """
    ends = min(velocity.min(), 0.0), max(velocity.max(), 0.0)
    v = np.sort(np.concatenate([end * np.linspace(1e-6, 1.0, 120) for end in ends if end]))
    law = np.column_stack([v, _velocity_part(axis, physical, _at(signals, v))])
    return np.insert(law, np.flatnonzero(np.diff(np.sign(v))) + 1, [0.0, np.nan], axis=0)
