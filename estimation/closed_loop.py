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
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen import SIGNALS, STATUSES, GeneratedAxis, LoopSettings, as_generated
from axisid.modeling import Axis, ModelError, UsageError

from .arrays import Array
from .errors import EstimationError
from .signals import Signals
from .virtual_loop import VirtualLoop

_PROBE = 1e-6  # of position and velocity, for the plant's rates
_RESOLVED = 0.05  # rate times step at which a Runge-Kutta step is accurate
_MOST_SUBSTEPS = 1000
_PROBED_POSITIONS = 33
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
        """+1 and -1 while sliding, 0 while stuck: at rest, and nothing to move it."""
        stuck = (self.velocity == 0) & (self.acceleration == 0)
        return np.where(stuck, 0.0, self.direction)

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
    axis: Axis | GeneratedAxis,
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
    axis : Axis or GeneratedAxis
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
    axis = as_generated(axis)
    theta, ref = _vector(parameters, "parameters"), _vector(reference, "reference")
    _check_loop(axis, theta.shape, ref, period, resolution, substeps)
    noise = None if position_noise is None else _vector(position_noise, "position_noise")
    if noise is not None and (noise.shape != ref.shape or not np.all(np.isfinite(noise))):
        raise UsageError(
            f"the noise has {len(noise)} samples, the reference {len(ref)}; give as many, finite."
        )
    first = float(ref[0] if start is None else start)
    (push,) = axis.rows("direct_dynamics", first, 0.0, [1.0, 0.0], 0.0, theta)
    if not 0 < push[0, 0] - push[1, 0] < math.inf:
        raise EstimationError(_no_inertia(axis, theta))
    settings = LoopSettings(
        period=period,
        resolution=resolution,
        allowed=_allowed(np.ptp(ref), abs(first - ref[0])),
        substeps=substeps
        or int(_substeps(axis, theta[None, :], ref, np.array([first]), period)[0]),
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
    axis: Axis | GeneratedAxis,
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
    axis : Axis or GeneratedAxis
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
    axis = as_generated(axis)
    theta = np.ascontiguousarray(parameters, dtype=float)
    ref = _aligned(reference)
    _check_loop(axis, theta.shape[1:], ref, period, resolution, substeps)
    lanes = len(theta)
    if theta.ndim != 2 or ref.shape[1:] not in ((), (lanes,)):
        raise UsageError(
            f"parameters have the shape {theta.shape} and the reference {ref.shape}; give (B, p) "
            "and (N,) or (N, B)."
        )
    noise = None if position_noise is None else _aligned(position_noise)
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
    failures = {
        int(lane): _no_inertia(axis, theta[lane])
        for lane in np.flatnonzero(~_has_inertia(axis, theta, first))
    }
    sound = np.array([lane for lane in range(lanes) if lane not in failures], dtype=int)
    counts = np.zeros(lanes, dtype=int)
    if sound.size:
        counts[sound] = substeps or _substeps(axis, theta[sound], ref, first[sound], period)
    allowed = np.array(
        [
            _allowed(span, away)
            for span, away in np.broadcast(np.ptp(ref, axis=0), np.abs(first - ref[0]))
        ]
    )
    run = _Batch(axis, theta, ref, noise, first, period, resolution, allowed, wanted, threads)
    # Lanes that ask for more steps in a sample run apart, so that they do not slow the others.
    groups = [np.flatnonzero(counts == count) for count in np.unique(counts[sound])]
    if len(groups) == 1 and len(groups[0]) == lanes:
        out = run.lanes(None, int(counts[0]), failures)
    else:
        out = {name: np.full((len(ref), lanes), np.nan) for name in wanted}
        for group in groups:
            for name, values in run.lanes(group, int(counts[group[0]]), failures).items():
                out[name][:, group] = values
    given = {new: old for old, new in names.items()}
    return BatchSimulation(
        signals={given.get(name, name): values for name, values in out.items()},
        failures=dict(sorted(failures.items())),
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
    vector = np.require(values, dtype=float, requirements=["C", "A"])
    if vector.ndim != 1 or not len(vector):
        raise UsageError(f"{what}: the shape is {vector.shape}; give one row of numbers.")
    return vector


def _aligned(values: ArrayLike) -> Array:
    """The array itself, unless its floats do not lie on whole multiples of their size."""
    array = np.require(values, dtype=float, requirements=["A"])
    whole = all(stride % array.itemsize == 0 for stride in array.strides)
    return array if whole else array.copy()


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
    whole = isinstance(substeps, (int, np.integer))
    if substeps is not None and not (whole and 1 <= substeps <= _MOST_SUBSTEPS):
        raise UsageError(f"the substeps are {substeps!r}; give 1 to {_MOST_SUBSTEPS}.")


def _has_inertia(axis: GeneratedAxis, parameters: Array, position: Array) -> NDArray[np.bool_]:
    """Which parameter sets, (B, p), have a positive and finite inertia at their positions, (B,)."""
    dynamics = axis.functions["direct_dynamics"]
    push, rest = (
        dynamics.call([position[None, :], 0.0, tau, 0.0, parameters.T])[0].full()[0]
        for tau in (1.0, 0.0)
    )
    with np.errstate(invalid="ignore"):
        return np.asarray((push - rest > 0) & np.isfinite(push - rest))


def _no_inertia(axis: GeneratedAxis, parameters: Array) -> str:
    return (
        f"axis {axis.axis.name!r} has no positive inertia with {axis.describe(parameters)}, so it "
        "cannot be simulated. Give its inertial parameters a positive nominal value, or check the "
        "signs of force and position in the record."
    )


def _substeps(
    axis: GeneratedAxis, parameters: Array, reference: Array, start: Array, period: float
) -> NDArray[np.int64]:
    """Runge-Kutta steps in a sample that resolve each lane's own rates, (B,).

    The rates are the plant's damping and stiffness, and a continuous law's. Where they depend on
    the motion they are probed over the reference's positions and speeds, in both directions.
    """
    if axis.uniform and len(start) == 1:
        held = np.resize([start[0], 0.0, 0.0], axis.functions["held_acceleration"].size1_in("held"))
        q, dq = start[0] + np.array([0, 0, _PROBE]), np.array([0, _PROBE, 0])
        here, faster, further = axis.rows("held_acceleration", q, dq, held, 1.0, parameters[0])[0][
            :, 0
        ]
        return _steps(np.array([[faster - here]]), np.array([[further - here]]), period)
    function = axis.functions["held_acceleration"]
    positions, speeds, directions = start[:, None], np.zeros(1), np.ones(1)
    if not axis.uniform:
        low, high = float(reference.min()), float(reference.max())
        grid = np.linspace(low, high, _PROBED_POSITIONS)
        positions = np.concatenate([positions, np.tile(grid, (len(start), 1))], axis=1)
        fastest = float(np.max(np.abs(np.diff(reference, axis=0)), initial=0.0)) / period
        speeds = fastest * np.array([-1.0, -0.1, -1e-3, 1e-3, 0.1, 1.0])
        directions = np.array([-1.0, 1.0])
    lanes, count = positions.shape
    shape = (lanes, count, len(speeds), len(directions))
    q = np.broadcast_to(positions[:, :, None, None], shape).ravel()
    dq = np.broadcast_to(speeds[None, None, :, None], shape).ravel()
    s = np.broadcast_to(directions, shape).ravel()
    theta = np.repeat(parameters, count * len(speeds) * len(directions), axis=0).T
    held = np.zeros((function.size1_in("held"), len(q)))
    if len(held) > 1:
        held[0] = q

    def accelerate(q_off: float, dq_off: float) -> Array:
        arguments = [(q + q_off)[None, :], (dq + dq_off)[None, :], held, s[None, :], theta]
        return np.asarray(function.call(arguments)[0].full()[0])

    with np.errstate(all="ignore"):
        here = accelerate(0.0, 0.0)
        by_speed, by_position = accelerate(0.0, _PROBE) - here, accelerate(_PROBE, 0.0) - here
    return _steps(by_speed.reshape(lanes, -1), by_position.reshape(lanes, -1), period)


def _steps(by_speed: Array, by_position: Array, period: float) -> NDArray[np.int64]:
    """Steps from how the acceleration changes over a probe, (B, points) each."""
    with np.errstate(all="ignore"):
        damping, stiffness = np.abs(by_speed) / _PROBE, np.abs(by_position) / _PROBE
        rates = np.maximum(damping, np.sqrt(stiffness))
        rates = np.where(np.isfinite(rates), rates, 0.0)
        wanted = np.ceil(rates.max(axis=1) * period / _RESOLVED)
    return np.asarray(np.clip(wanted, 1, _MOST_SUBSTEPS), dtype=np.int64)


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


@dataclass(frozen=True, slots=True)
class _Batch:
    """What the groups of lanes of a batch share."""

    axis: GeneratedAxis
    parameters: Array
    reference: Array
    noise: Array | None
    start: Array
    period: float
    resolution: float
    allowed: Array
    wanted: Sequence[str]
    threads: int | None

    def lanes(
        self, group: NDArray[np.intp] | None, substeps: int, failures: dict[int, str]
    ) -> dict[str, Array]:
        """Simulate a group of lanes, or all; what fails is added to `failures`."""
        every = group is None
        chosen = np.arange(len(self.parameters)) if group is None else group
        settings = LoopSettings(
            period=self.period,
            resolution=self.resolution,
            allowed=self.allowed if every else np.ascontiguousarray(self.allowed[chosen]),
            substeps=substeps,
        )
        arguments = (
            self.reference if every or self.reference.ndim == 1 else self.reference[:, chosen],
            self.noise if every or self.noise is None else self.noise[:, chosen],
            self.parameters if every else np.ascontiguousarray(self.parameters[chosen]),
            self.start if every else np.ascontiguousarray(self.start[chosen]),
            settings,
            self.wanted,
        )
        library = self.axis.native.library()
        if library is None:
            self.axis.native.warn_once()
            status, stopped, out = _virtual_batch(self.axis, *arguments)
        else:
            count = _processors() if self.threads is None else max(1, self.threads)
            status, stopped, out = library.simulate_batch(*arguments, count)
        for i in np.flatnonzero(status):
            lane, sample = int(chosen[i]), int(stopped[i])
            for signal in out.values():
                signal[sample:, i] = np.nan
            failures[lane] = _failure(
                self.axis, self.parameters[lane], int(status[i]), sample, self.period
            )
        return out


def _virtual_batch(
    axis: GeneratedAxis,
    reference: Array,
    noise: Array | None,
    parameters: Array,
    start: Array,
    settings: LoopSettings,
    wanted: Sequence[str],
) -> tuple[NDArray[np.int32], NDArray[np.int64], dict[str, Array]]:
    """Lane by lane in the virtual machine."""
    lanes = len(parameters)
    out = {name: np.empty((len(reference), lanes)) for name in wanted}
    status, stopped = np.zeros(lanes, dtype=np.int32), np.zeros(lanes, dtype=np.int64)
    for lane in range(lanes):
        own = replace(settings, allowed=float(settings.allowed[lane]))
        status[lane], stopped[lane], signals = VirtualLoop(axis, parameters[lane], own).run(
            reference if reference.ndim == 1 else reference[:, lane],
            None if noise is None else noise[:, lane],
            float(start[lane]),
        )
        for name in wanted:
            out[name][:, lane] = signals[name]
    return status, stopped, out


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
