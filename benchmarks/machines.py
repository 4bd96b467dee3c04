"""Servo axes as they are: simulated by steps of their own, many runs at once, apart from axisid.

A position loop over a velocity loop on encoder differences, with or without an integral, or a PID
moves a mass against friction, gravity, a spring or whatever `resistance` adds. Between samples the
force is held and the axis takes midpoint steps of 0.2 ms or less; where the velocity changes its
sign in one, the axis stops there or goes on in the other direction.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]
#: Of time (s), positions (m) and velocities (m/s) of all runs: a resisting force, N.
Resistance = Callable[[float, Array, Array], Array]
#: Of positions (m) and speeds (m/s) of all runs: a factor.
Shape = Callable[[Array, Array], Array | float]
#: A noise of so many runs and samples.
Noise = Callable[[np.random.Generator, int, int], Array]

#: Of time, s: a factor.
OverTime = Callable[[float], float]

_LONGEST_STEP, _LEAST_STEPS = 2e-4, 5  # s; a sample


def nothing(_time: float, position: Array, _velocity: Array) -> Array:
    """No further resistance."""
    return np.zeros_like(position)


def constant(_time: float) -> float:
    """No change over time."""
    return 1.0


def even(_position: Array, _speed: Array) -> float:
    """The same everywhere and at any speed."""
    return 1.0


def white(sd: float) -> Noise:
    """Independent at each sample."""
    return lambda rng, runs, samples: rng.normal(scale=sd, size=(runs, samples))


def autoregressive(sd: float, time: float, period: float) -> Noise:
    """Of first order, with a standard deviation and a correlation time in s."""
    kept = math.exp(-period / time)

    def draw(rng: np.random.Generator, runs: int, samples: int) -> Array:
        new = rng.normal(scale=sd * math.sqrt(1 - kept**2), size=(runs, samples))
        new[:, 0] /= math.sqrt(1 - kept**2)  # as if it had gone on for ever
        return np.asarray(lfilter([1.0], [1.0, -kept], new))

    return draw


@dataclass(frozen=True, kw_only=True)
class Machine:
    """An axis with its drive, its encoder and its noises, in SI.

    Attributes
    ----------
    mass, viscous, coulomb, offset : float
        kg, N/(m/s), N, N.
    resistance : callable
        What resists besides, at rest too.
    shape : callable
        How many times its value Coulomb friction is, of positions and speeds; it holds at rest as
        much as at no speed.
    mass_at, friction_at, gain_at : callable
        Over time, s: how many times what is declared its mass, its friction and its gain are.
    loss : float
        Share of the drive's force that goes into friction, besides Coulomb's.
    feed_forward : float
        Of the reference's acceleration, V/(m/s^2); it is in the logged control or not.
    logs_feed_forward : bool
    clock_jitter : float
        Root mean square by which the law samples too early or late, in periods.
    gain, limit : float
        Force per volt, and the largest control.
    kp, kv, period : float
        Of the cascade ``kv (kp (r - q) - (q[k] - q[k-1]) / period)``.
    tn : float
        Of the cascade's velocity error's integral, s; infinite for none.
    ki, kd : float, optional
        Of a PID ``kp e + ki I + kd (e[k] - e[k-1]) / period`` in place of the cascade.
    lag, delay : float
        Between a command and its force, s; the delay in whole steps of the integration.
    rate_limit, quantisation, deadband : float
        What a command goes through before it acts, in this order: V/s, V, V. The log has the
        command.
    control_step : float
        What the drive rounds its control to, and logs, V; 0 for nothing.
    has_tachometer : bool
        Whether the cascade takes the velocity itself in place of that difference.
    resolution : float
        Step of the encoder, m; 0 for none. Where its steps lie is drawn for each run.
    position_noise, force_noise, control_noise : callable, optional
        In the measured position, within the loop; in the force; in the recorded control only.
    load, antiresonance, load_damping, play : float
        Of the mass, that part of it behind a spring, kg, 0 for none; its frequency with the rest of
        it held, Hz, its damping ratio there, and the play before spring and damper touch it, m.
    injected : (N,) array, optional
        A test signal in the column ``injected``, added to the control or to the reference.
    injected_at : str
        Which of the two.
    """

    mass: float = 100.0
    viscous: float = 240.0
    coulomb: float = 25.0
    offset: float = 0.0
    resistance: Resistance = nothing
    shape: Shape = even
    mass_at: OverTime = constant
    friction_at: OverTime = constant
    gain_at: OverTime = constant
    loss: float = 0.0
    feed_forward: float = 0.0
    logs_feed_forward: bool = True
    clock_jitter: float = 0.0
    gain: float = 35.15
    limit: float = 10.0
    kp: float = 160.18
    kv: float = 243.45
    period: float = 1e-3
    tn: float = math.inf
    ki: float | None = None
    kd: float = 0.0
    control_step: float = 0.0
    lag: float = 0.0
    delay: float = 0.0
    rate_limit: float = math.inf
    quantisation: float = 0.0
    deadband: float = 0.0
    has_tachometer: bool = False
    resolution: float = 0.0
    position_noise: Noise | None = None
    force_noise: Noise | None = None
    control_noise: Noise | None = None
    load: float = 0.0
    antiresonance: float = 30.0
    load_damping: float = 0.02
    play: float = 0.0
    injected: Array | None = None
    injected_at: str = "control"

    @property
    def steps(self) -> int:
        """Of the integration in a sample."""
        return max(_LEAST_STEPS, round(self.period / _LONGEST_STEP))


def records(machine: Machine, reference: Array, runs: int, seed: int) -> list[dict[str, Array]]:
    """Columns of so many records with noises of their own; the reference is (N,)."""
    rng = np.random.default_rng(seed)
    n = len(reference)
    drawn = (machine.position_noise, machine.force_noise, machine.control_noise)
    of_position, of_force, of_control = (
        np.zeros((runs, n)) if noise is None else noise(rng, runs, n) for noise in drawn
    )
    phase = machine.resolution * rng.random(runs)
    q, v = np.full(runs, reference[0]), np.zeros(runs)
    positions, controls = np.empty((runs, n)), np.empty((runs, n))
    added = np.zeros(n) if machine.injected is None else machine.injected[:n]
    to_control, to_reference = (
        added if machine.injected_at == place else 0 * added for place in ("control", "reference")
    )
    followed = reference + to_reference
    forward = machine.feed_forward * np.gradient(np.gradient(reference)) / machine.period**2
    late = np.clip(machine.clock_jitter * rng.normal(size=n + 1), -0.4, 0.4)
    spans = machine.period * (1.0 + np.diff(late))
    drive, law, load = _Drive(machine, runs), _Law(machine), _Load(machine, q)
    for k in range(n):
        measured = _encoder(machine, q + of_position[:, k], phase)
        wanted = law.control(followed[k], measured, v) + to_control[k] + forward[k]
        control = np.clip(wanted, -machine.limit, machine.limit)
        if machine.control_step:
            control = machine.control_step * np.round(control / machine.control_step)
        positions[:, k] = measured
        controls[:, k] = control if machine.logs_feed_forward else control - forward[k]
        acting = control * machine.gain_at(k * machine.period)
        q, v = _sample(machine, k, spans[k], q, v, load, drive.forces(acting, of_force[:, k]))
    controls += of_control
    shared = {"time": machine.period * np.arange(n), "reference": reference}
    shared |= {} if machine.injected is None else {"injected": added}
    return [
        {**shared, "position": p, "control": u} for p, u in zip(positions, controls, strict=True)
    ]


class _Law:
    """The control law, sample by sample, from rest where the first position is measured."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._position: Array | None = None
        self._error: Array | None = None
        self._integral = np.zeros(1)

    def control(self, reference: float, measured: Array, velocity: Array) -> Array:
        """What is commanded of a measured position; the velocity is a tachometer's."""
        m, error = self._machine, reference - measured
        before = measured if self._position is None else self._position
        error_before = error if self._error is None else self._error
        self._position, self._error = measured, error
        if m.ki is not None:
            slope = (error - error_before) / m.period
            control = m.kp * error + m.ki * self._integral + m.kd * slope
            self._integral = self._integral + m.period * error
            return np.asarray(control)
        speed = velocity if m.has_tachometer else (measured - before) / m.period
        of_speed = m.kp * error - speed
        control = m.kv * (of_speed + self._integral / m.tn)
        self._integral = self._integral + m.period * of_speed
        return np.asarray(control)


class _Drive:
    """What a machine's drive makes of commands, step by step."""

    def __init__(self, machine: Machine, runs: int) -> None:
        self._step, self._steps = machine.period / machine.steps, machine.steps
        self._gain, self._lag = machine.gain, machine.lag
        self._pending = [np.zeros(runs)] * round(machine.delay / self._step)
        self._now, self._slow = np.zeros(runs), np.zeros(runs)
        self._most, self._quantum = machine.rate_limit * machine.period, machine.quantisation
        self._band = machine.deadband

    def forces(self, control: Array, added: Array) -> list[Array]:
        """Mean forces of the steps of a sample, with what is added to each."""
        steps = [*self._pending, *[self._gain * self._acting(control)] * self._steps]
        self._pending = steps[self._steps :]
        return [self._followed(target) + added for target in steps[: self._steps]]

    def _acting(self, control: Array) -> Array:
        """What comes through of a command."""
        self._slow = np.maximum(
            np.minimum(control, self._slow + self._most), self._slow - self._most
        )
        acting = self._slow
        if self._quantum:
            acting = np.round(acting / self._quantum) * self._quantum
        return np.asarray(np.sign(acting) * np.maximum(np.abs(acting) - self._band, 0.0))

    def _followed(self, target: Array) -> Array:
        if not self._lag:
            return target
        stays = math.exp(-self._step / self._lag)
        off = self._now - target
        self._now = target + off * stays
        return np.asarray(target + off * (1 - stays) * self._lag / self._step)


class _Load:
    """A mass behind a spring and a damper, by the midpoint steps of the axis before it."""

    def __init__(self, machine: Machine, q: Array) -> None:
        rate = 2 * math.pi * machine.antiresonance
        self._mass, self._stiffness = machine.load, rate**2
        self._damping, self._play = 2 * machine.load_damping * rate, machine.play
        self._q, self._v = q.copy(), np.zeros_like(q)

    def force(self, ahead: float, q: Array, v: Array) -> Array:
        """What it takes from an axis at q with v, so much after the last step."""
        return self._mass * self._rise(ahead, q, v) if self._mass else np.zeros_like(q)

    def step(self, h: float, q: Array, v: Array) -> None:
        """Follow an axis that is at q with v in the middle of the step."""
        if self._mass:
            after = self._v + h * self._rise(h / 2, q, v)
            self._q, self._v = self._q + h / 2 * (self._v + after), after

    def _rise(self, ahead: float, q: Array, v: Array) -> Array:
        later = self._v + ahead * self._pulled(q, v, self._q, self._v)
        return self._pulled(q, v, self._q + ahead / 2 * (self._v + later), later)

    def _pulled(self, q: Array, v: Array, own: Array, speed: Array) -> Array:
        off = q - own
        pulled = self._stiffness * off + self._damping * (v - speed)
        if not self._play:
            return pulled
        beyond = np.abs(off) > self._play / 2
        return np.where(beyond, pulled - self._stiffness * np.sign(off) * self._play / 2, 0.0)


def _encoder(machine: Machine, position: Array, phase: Array) -> Array:
    if not machine.resolution:
        return position
    return machine.resolution * np.floor((position + phase) / machine.resolution + 0.5) - phase


def _sample(
    machine: Machine,
    k: int,
    span: float,
    q: Array,
    v: Array,
    load: "_Load",
    forces: list[Array],
) -> tuple[Array, Array]:
    """From one sample to the next under the forces of its steps."""
    h = span / machine.steps
    for step, force in enumerate(forces):
        time = k * machine.period + step * h
        mass = machine.mass * machine.mass_at(time) - machine.load
        worn = machine.friction_at(time)
        viscous = worn * machine.viscous
        lost = machine.loss * np.abs(force)

        def rubs(q: Array, v: Array, lost: Array = lost, worn: float = worn) -> Array:
            """Coulomb friction, whichever way it points."""
            return worn * machine.coulomb * machine.shape(q, np.abs(v)) + lost

        def pushed(
            ahead: float,
            q: Array,
            v: Array,
            held: Array = force,
            at: float = time,
            viscous: float = viscous,
        ) -> Array:
            """What accelerates but for Coulomb friction, so much later in the step."""
            smooth = viscous * v + machine.offset + machine.resistance(at + ahead, q, v)
            return held - smooth - load.force(ahead, q, v)

        free = pushed(0.0, q, v)
        direction = np.where(v == 0, np.sign(free), np.sign(v))
        sticks = (v == 0) & (np.abs(free) <= rubs(q, v))
        half = v + h / 2 * (free - direction * rubs(q, v)) / mass
        middle = q + h / 2 * v
        slope = pushed(h / 2, middle, half) - direction * rubs(middle, half)
        after = np.where(sticks, 0.0, v + h * slope / mass)
        turned = after * direction < 0
        if turned.any():
            rests = rubs(q, np.zeros_like(v))
            after = np.where(turned, _turned(free, rests, v, after, h, mass), after)
        load.step(h, middle, half)
        q, v = q + h / 2 * (v + after), after
    return q, v


def _turned(free: Array, coulomb: Array, v: Array, after: Array, h: float, mass: float) -> Array:
    """Velocities at the end of a step in which they reach zero: at rest, or turned."""
    left = h * after / np.where(after == v, 1.0, after - v)  # of the step, after the turn
    excess = np.sign(free) * np.maximum(np.abs(free) - coulomb, 0.0)
    return left * excess / mass
