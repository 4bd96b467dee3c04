"""Closed-loop simulation: the reference in, everything else simulated.

The control law is evaluated once a sample and held (or all the time, if it is continuous). In
between, the plant moves in one friction mode; where the velocity reaches zero the crossing is
located and the mode chosen anew. At rest the model itself decides: with the accelerations a(+) and
a(-) for both friction directions, the axis sticks if and only if ``a(+) <= 0 <= a(-)``
[Filippov1988]_. Native code runs where there is a compiler, the CasADi virtual machine elsewhere.
"""

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen import SIGNALS, STATUSES, GeneratedAxis, LoopSettings
from axisid.modeling import ModelError, UsageError

from .arrays import Array
from .errors import EstimationError
from .signals import Signals
from .virtual_loop import VirtualLoop

_PROBE = 1e-6  # of position and velocity, for the plant's rates
_RESOLVED = 0.1  # rate times step at which a Runge-Kutta step is accurate
_MOST_SUBSTEPS = 1000
_RUNAWAY = 100.0  # of the reference's span


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """A simulated closed loop, at the reference's samples, (N,) each, SI.

    Force, acceleration and friction direction are those just after the control was updated at the
    sample; with position and velocity they satisfy the model row by row.

    Attributes
    ----------
    time, position, velocity, acceleration, force : array
    control : array
        In the drive's unit.
    direction : array
        Friction direction: +1 or -1 while sliding, between them while stuck.
    direction_before : array
        The same just before the sample, under what was held until then.
    measured_position : array
        With the noise and the encoder resolution that were given.
    """

    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    force: Array
    control: Array
    direction: Array
    direction_before: Array
    measured_position: Array

    @property
    def mode(self) -> Array:
        """+1 and -1 while sliding, 0 while stuck."""
        return np.where(np.abs(self.direction) < 1, 0.0, self.direction)

    @property
    def signals(self) -> Signals:
        """What a regressor is made of, just after each sample."""
        return Signals(
            position=self.position,
            velocity=self.velocity,
            acceleration=self.acceleration,
            force=self.force,
            direction=self.direction,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchSimulation:
    """Many simulations side by side.

    Attributes
    ----------
    signals : dict of str to (N, B) array
        The signals that were asked for, by name as in `Simulation`; NaN from the sample on at which
        a simulation ended early.
    failures : dict of int to str
        Why and where, by lane, for those that ended early.
    """

    signals: dict[str, Array]
    failures: dict[int, str]

    def __getitem__(self, name: str) -> Array:
        return self.signals[name]


def simulate(
    axis: GeneratedAxis,
    parameters: ArrayLike,
    reference: ArrayLike,
    period: float,
    *,
    start: float | None = None,
    position_noise: ArrayLike | None = None,
    resolution: float = 0.0,
    substeps: int | None = None,
) -> Simulation:
    """Simulate the axis under its control law, starting at rest.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    parameters : (p,) array_like
        Physical parameters, SI.
    reference : (N,) array_like
        Commanded position.
    period : float
        Sampling period, s.
    start : float, optional
        First position; the first reference by default.
    position_noise : (N,) array_like, optional
        Added to the position that the law measures.
    resolution : float
        Of the encoder, in the coordinate's unit; the law then measures whole counts. 0 for none.
    substeps : int, optional
        Runge-Kutta steps in a sample; the error falls with their fourth power. By default as many
        as the damping and stiffness of the axis ask for at the start, mostly 1.

    Raises
    ------
    ModelError
        The axis has no control law.
    UsageError
        An argument has the wrong shape or value.
    EstimationError
        The inertia is not positive, or the loop diverges or chatters; the sample is named.
    """
    theta, ref = _vector(parameters, "parameters"), _vector(reference, "reference")
    _check_loop(axis, theta.shape, ref, period, resolution, substeps)
    noise = None if position_noise is None else _vector(position_noise, "position_noise")
    if noise is not None and (noise.shape != ref.shape or not np.all(np.isfinite(noise))):
        raise UsageError(
            f"the noise has {len(noise)} samples, the reference {len(ref)}; give as many, finite."
        )
    first = float(ref[0] if start is None else start)
    _check_inertia(axis, theta, first)
    settings = LoopSettings(
        period=period,
        resolution=resolution,
        allowed=_allowed(np.ptp(ref), abs(first - ref[0])),
        substeps=substeps or _substeps(axis, theta[None, :], np.array([first]), period),
    )
    library = axis.native.library()
    if library is None:
        axis.native.warn_once()
        status, stopped, out = VirtualLoop(axis, theta, settings).run(ref, noise, first)
    else:
        status, stopped, out = library.simulate(ref, noise, theta, first, settings)
    if status:
        raise EstimationError(_failure(axis, theta, status, stopped, period))
    return Simulation(
        time=period * np.arange(len(ref), dtype=np.float64),
        direction_before=out.pop("before"),
        measured_position=_measured(out["position"], noise, resolution),
        **out,
    )


def simulate_batch(
    axis: GeneratedAxis,
    parameters: ArrayLike,
    reference: ArrayLike,
    period: float,
    *,
    start: ArrayLike | None = None,
    position_noise: ArrayLike | None = None,
    resolution: float = 0.0,
    substeps: int | None = None,
    signals: Sequence[str] = SIGNALS[:5],
    threads: int | None = None,
) -> BatchSimulation:
    """Simulate many parameter sets, references or noises side by side.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    parameters : (B, p) array_like
        One row a lane.
    reference : (N,) or (N, B) array_like
        Shared, or one column a lane.
    period : float
        Sampling period, s.
    start : (B,) array_like, optional
        First positions; the first references by default.
    position_noise : (N, B) array_like, optional
    resolution, substeps
        As in `simulate`.
    signals : sequence of str
        What is wanted: each takes N x B floats. Names as in `Simulation`.
    threads : int, optional
        As many as there are processors by default.

    Raises
    ------
    ModelError
        The axis has no control law.
    UsageError
        An argument has the wrong shape or value.

    Notes
    -----
    A lane that fails does not end the others; see `BatchSimulation.failures`.
    """
    theta = np.ascontiguousarray(parameters, dtype=float)
    ref = np.asarray(reference, dtype=float)
    _check_loop(axis, theta.shape[1:], ref, period, resolution, substeps)
    lanes = len(theta)
    if theta.ndim != 2 or ref.shape[1:] not in ((), (lanes,)):
        raise UsageError(
            f"parameters have the shape {theta.shape} and the reference {ref.shape}; give (B, p) "
            "and (N,) or (N, B)."
        )
    noise = None if position_noise is None else np.asarray(position_noise, dtype=float)
    if noise is not None and (noise.shape != (len(ref), lanes) or not np.all(np.isfinite(noise))):
        raise UsageError(
            f"the noise has the shape {noise.shape}; give {(len(ref), lanes)}, all finite."
        )
    names = {"direction_before": "before"}
    wanted = [names.get(name, name) for name in signals]
    if unknown := set(wanted) - set(SIGNALS):
        raise UsageError(
            f"there is no signal {', '.join(unknown)}; there are {', '.join(SIGNALS)}."
        )
    first = np.broadcast_to(ref[0], lanes) if start is None else np.asarray(start, dtype=float)
    if first.shape != (lanes,):
        raise UsageError(f"the start has the shape {first.shape}; give one position a lane.")
    first = np.ascontiguousarray(first)
    away = float(np.max(np.abs(first - ref[0]), initial=0.0))
    settings = LoopSettings(
        period=period,
        resolution=resolution,
        allowed=_allowed(np.max(np.ptp(ref, axis=0)), away),
        substeps=substeps or _substeps(axis, theta, first, period),
    )
    library = axis.native.library()
    if library is None:
        axis.native.warn_once()
        status, stopped, out = _virtual_batch(axis, theta, ref, noise, first, settings, wanted)
    else:
        count = _processors() if threads is None else max(1, threads)
        status, stopped, out = library.simulate_batch(
            ref, noise, theta, first, settings, wanted, count
        )
    failures = {}
    for lane in np.flatnonzero(status):
        for signal in out.values():
            signal[stopped[lane] :, lane] = np.nan
        failures[int(lane)] = _failure(
            axis, theta[lane], int(status[lane]), int(stopped[lane]), period
        )
    given = {new: old for old, new in names.items()}
    return BatchSimulation(
        signals={given.get(name, name): values for name, values in out.items()}, failures=failures
    )


def signals_before(axis: GeneratedAxis, parameters: Array, simulation: Simulation) -> Signals:
    """Signals just before each sample: the same motion under the force held until then.

    They satisfy the model row by row too. At the first sample, and for a continuous law, they are
    those just after.
    """
    law = axis.axis.control
    if law is not None and law.continuous:
        return simulation.signals
    held = np.concatenate([simulation.force[:1], simulation.force[:-1]])
    (acceleration,) = axis.rows(
        "direct_dynamics",
        simulation.position,
        simulation.velocity,
        held,
        simulation.direction_before,
        parameters,
    )
    return Signals(
        position=simulation.position,
        velocity=simulation.velocity,
        acceleration=acceleration[:, 0],
        force=held,
        direction=simulation.direction_before,
    )


def no_control_law(name: str) -> ModelError:
    """The error of an axis whose loop cannot be closed."""
    return ModelError(
        f"axis {name!r} has no control law, so its closed loop cannot be simulated. Declare one "
        "with control=..., or use idm-ls or ddm-ls."
    )


def _vector(values: ArrayLike, what: str) -> Array:
    vector = np.ascontiguousarray(values, dtype=float)
    if vector.ndim != 1 or not len(vector):
        raise UsageError(f"{what}: the shape is {vector.shape}; give one row of numbers.")
    return vector


def _check_loop(
    axis: GeneratedAxis,
    shape: tuple[int, ...],
    reference: Array,
    period: float,
    resolution: float,
    substeps: int | None,
) -> None:
    law = axis.axis.control
    if law is None:
        raise no_control_law(axis.axis.name)
    if shape != (len(axis.parameters),):
        raise UsageError(
            f"axis {axis.axis.name!r} has {len(axis.parameters)} parameters "
            f"({', '.join(axis.names)}); {shape[0] if shape else 'no'} were given."
        )
    if not len(reference) or not np.all(np.isfinite(reference)):
        raise UsageError("the reference is empty or not finite; give finite positions.")
    if not (math.isfinite(period) and period > 0):
        raise UsageError(f"the period is {period!r} s; give a positive number.")
    if not resolution >= 0 or (resolution and law.continuous):
        raise UsageError(
            f"the resolution is {resolution!r}; give 0 or more, and 0 with a continuous law, which "
            "takes no samples."
        )
    if substeps is not None and substeps < 1:
        raise UsageError(f"the substeps are {substeps!r}; give 1 or more.")


def _check_inertia(axis: GeneratedAxis, parameters: Array, position: float) -> None:
    dynamics = axis.functions["direct_dynamics"]
    push, rest = (float(dynamics(position, 0.0, tau, 0.0, parameters)) for tau in (1.0, 0.0))
    if not (push - rest > 0 and math.isfinite(push - rest)):
        raise EstimationError(
            f"axis {axis.axis.name!r} has no positive inertia with {axis.describe(parameters)}, so "
            "it cannot be simulated. Give its inertial parameters a positive nominal value, or "
            "check the signs of force and position in the record."
        )


def _substeps(axis: GeneratedAxis, parameters: Array, start: Array, period: float) -> int:
    """Runge-Kutta steps that resolve the plant's own rates: damping over mass, and stiffness."""
    function = axis.functions["held_acceleration"]
    held = np.zeros((function.size1_in("held"), len(start)))
    held[0] = start if len(held) > 1 else 0.0

    def accelerate(dq: float, ddq: float) -> Array:
        position, velocity = start + dq, np.full(len(start), ddq)
        lanes = (position[None, :], velocity[None, :], held, 0.0, parameters.T)
        return np.asarray(function.call(lanes)[0].full()[0])

    rest = accelerate(0.0, 0.0)
    damping = np.abs(accelerate(0.0, _PROBE) - rest) / _PROBE
    stiffness = np.abs(accelerate(_PROBE, 0.0) - rest) / _PROBE
    fastest = float(np.max(np.maximum(damping, np.sqrt(stiffness))))
    wanted = fastest * period / _RESOLVED
    return int(min(max(1.0, math.ceil(wanted)), _MOST_SUBSTEPS)) if math.isfinite(wanted) else 1


def _allowed(span: float, away: float) -> float:
    """Distance from the reference beyond which the loop has run away."""
    return _RUNAWAY * max(float(span), float(away)) or math.inf


def _failure(
    axis: GeneratedAxis, parameters: Array, status: int, sample: int, period: float
) -> str:
    """What happened, where, with which parameters, and what to do."""
    where = f"at sample {sample} ({sample * period:g} s) with {axis.describe(parameters)}"
    what = f"the simulated closed loop of axis {axis.axis.name!r}"
    if STATUSES[status] == "chatter":
        return (
            f"{what} changes the friction direction without end {where}; check the friction in the "
            "equation of motion."
        )
    how = "leaves the range" if STATUSES[status] == "out of range" else "is not finite"
    return (
        f"{what} diverges: the position {how} {where}. Check the control law's gains and period, "
        "the drive gain and the nominal values."
    )


def _measured(position: Array, noise: Array | None, resolution: float) -> Array:
    measured = position if noise is None else position + noise
    return np.floor(measured / resolution + 0.5) * resolution if resolution > 0 else measured


def _virtual_batch(
    axis: GeneratedAxis,
    parameters: Array,
    reference: Array,
    noise: Array | None,
    start: Array,
    settings: LoopSettings,
    wanted: Sequence[str],
) -> tuple[NDArray[np.int32], NDArray[np.int64], dict[str, Array]]:
    """Lane by lane in the virtual machine."""
    lanes = len(parameters)
    out = {name: np.empty((len(reference), lanes)) for name in wanted}
    status, stopped = np.zeros(lanes, dtype=np.int32), np.zeros(lanes, dtype=np.int64)
    for lane in range(lanes):
        loop = VirtualLoop(axis, parameters[lane], settings)
        status[lane], stopped[lane], signals = loop.run(
            reference if reference.ndim == 1 else reference[:, lane],
            None if noise is None else noise[:, lane],
            float(start[lane]),
        )
        for name in wanted:
            out[name][:, lane] = signals[name]
    return status, stopped, out


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
