"""Machines of the field, right ones and wrong ones, and what is declared and logged of them.

Half of the right machines, and the axes that faults are put into but the first, are drawn from a
seed: mass, law, period, motion, encoder and noise, each in proportion to the others, as a machine
builder would have chosen them. A right one may be sampled with a jitter of 5 % of its period.
`verdicts.py` counts what becomes of them.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from machines import Array, Machine, autoregressive, records, white
from scipy.signal import lfilter

from axisid import Coordinate, Parameter, Record, build, newton, read_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import ControlLaw, cascade_p_pi, cascade_pd_difference, pid
from axisid.elements import Drive, coulomb, offset, viscous

#: What a drive is declared to do to commands, by the names of `Machine`.
OF_DRIVE = ("lag", "delay")


class Motion(NamedTuple):
    """What is commanded: a kind, its top speed, SI, the time to reach it, s, and its length, s."""

    kind: str = "trapezoids with dwells"
    speed: float = 0.12
    rise: float = 0.15
    seconds: float = 13.0


class Log(NamedTuple):
    """What a log makes of a record.

    Attributes
    ----------
    jitter : float
        Root mean square of what parts its stamps from even times, in periods.
    factor : float
        How many times the control it holds; -1 for its opposite.
    early : int
        Samples by which the control stands too early.
    has_reference : bool
    """

    jitter: float = 0.0
    factor: float = 1.0
    early: int = 0
    has_reference: bool = True


_MOVES, _PLAIN = Motion(), Log()


@dataclass(frozen=True, kw_only=True)
class Case:
    """A machine, what it does, and what is declared and logged of it.

    Attributes
    ----------
    machine, declared : Machine
        As it is, and as it is said to be: its law, drive, and whether it has an offset.
    motion : Motion
    log : Log
    is_rotary : bool
    fault : str
        What is wrong; empty for a right machine.
    named : str
        Regular expression of what has to be said of it.
    """

    machine: Machine
    declared: Machine
    motion: Motion = _MOVES
    log: Log = _PLAIN
    is_rotary: bool = False
    fault: str = ""
    named: str = ""

    @property
    def truth(self) -> dict[str, float]:
        """Of the parameters that are declared."""
        m = self.machine
        values = {"M": m.mass, "Fv": m.viscous, "Fc": m.coulomb}
        return values | ({"F0": m.offset} if self.declared.offset else {})

    @property
    def axis(self) -> GeneratedAxis:
        """As it is declared."""
        d = self.declared
        return declared_axis(
            nominal=float(f"{d.mass:.0e}"),
            law_of=(d.kp, d.kv, d.tn, d.ki, d.kd, d.period),
            gain=d.gain,
            limit=d.limit,
            has_offset=bool(d.offset),
            is_rotary=self.is_rotary,
            **{name: getattr(d, name) for name in OF_DRIVE},
        )

    def records(self, runs: int, seed: int) -> Iterator[Record]:
        """So many records, with noises of their own; other cases want other seeds."""
        reference = reference_of(self.motion, self.machine.period)
        for k, columns in enumerate(records(self.machine, reference, runs, seed)):
            yield read_record(self._logged(columns, np.random.default_rng([seed, k, 1])), self.axis)

    def _logged(self, columns: Mapping[str, Array], rng: np.random.Generator) -> dict[str, Array]:
        left_out = {"injected"} if self.log.has_reference else {"injected", "reference"}
        kept = {name: each for name, each in columns.items() if name not in left_out}
        rows = len(kept["time"]) - self.log.early
        control = self.log.factor * kept["control"][self.log.early :]
        kept = {name: each[:rows] for name, each in kept.items()} | {"control": control}
        off = np.clip(self.log.jitter * rng.normal(size=rows), -0.45, 0.45)
        return kept | {"time": kept["time"] + self.machine.period * off}


def _right(machine: Machine, motion: Motion = _MOVES, **others: object) -> Case:
    return Case(machine=machine, declared=machine, motion=motion, **others)  # type: ignore[arg-type]


_P_PI = Machine(kp=25.0, kv=150.0, tn=0.05, resolution=1e-6, force_noise=white(2.0))
_FINE = Machine(resolution=5e-8, control_noise=white(2e-3))

#: Right machines that are the same in every run.
FIXED: dict[str, Case] = {
    "PD, 2 um, dwells, force of 20 ms": _right(
        Machine(resolution=2e-6, force_noise=autoregressive(1.0, 0.02, 1e-3))
    ),
    "PD, white position noise of 5 um, dwells": _right(Machine(position_noise=white(5e-6))),
    "P-PI, 1 um, dwells": _right(_P_PI),
    "P-PI, 850 kg, 5 um, minimum jerk": _right(
        Machine(
            mass=850.0,
            viscous=900.0,
            coulomb=120.0,
            gain=300.0,
            kp=25.0,
            kv=120.0,
            tn=0.05,
            resolution=5e-6,
        ),
        Motion("minimum jerk", 0.16, 0.2),
    ),
    "PID, 20 um, joystick": _right(
        replace(_P_PI, kp=1200.0, ki=4000.0, kd=80.0, resolution=2e-5, force_noise=white(1.0)),
        Motion("joystick"),
    ),
    "PD, 0.25 ms, 0.5 um, dwells": _right(
        Machine(period=2.5e-4, resolution=5e-7, force_noise=autoregressive(1.0, 0.02, 2.5e-4)),
        Motion(seconds=8.0),
    ),
    "P-PI, 5 ms, 1 um, dwells": _right(
        replace(_P_PI, period=5e-3, kp=15.0, kv=100.0, tn=0.1), Motion(seconds=30.0)
    ),
    "P-PI, 10 um, rounded currents, multisine": _right(
        replace(_P_PI, resolution=1e-5, control_step=0.01), Motion("multisine")
    ),
    "PD, weight, encoder of 5 um": _right(
        replace(_FINE, offset=150.0, coulomb=40.0, resolution=5e-6), Motion("trapezoids")
    ),
    "PD, drive with lag and delay": _right(
        replace(_FINE, lag=8e-4, delay=4e-4, position_noise=white(1e-6)), Motion("trapezoids")
    ),
    "PD, white position noise of 2 um, no reference": _right(
        Machine(position_noise=white(2e-6), control_noise=white(2e-3)),
        log=Log(has_reference=False),
    ),
    "P-PI, 1 um, dwells, no reference": _right(_P_PI, log=Log(has_reference=False)),
    "PD, sampled with jitter of 5 %": _right(replace(_FINE, clock_jitter=0.05)),
    "PD, 2 s": _right(
        replace(_FINE, force_noise=autoregressive(2.0, 0.05, 1e-3)), Motion("trapezoids", seconds=2)
    ),
}

_KINDS = (
    "trapezoids with dwells",
    "minimum jerk",
    "joystick",
    "prbs",
    "multisine",
    "chirp",
    "trapezoids",
)
_PERIODS = (1e-3, 2.5e-4, 4e-3, 5e-4, 2e-3, 5e-3)
_LAWS = ("PD", "P-PI", "PID")


def drawn(seed: int, number: int) -> dict[str, Case]:
    """Right machines that nobody has tuned anything to: kinds in turn, sizes at random."""
    rng = np.random.default_rng([seed, 2026])

    def in_turn(values: Sequence[Any]) -> list[Any]:
        """Each as often as the others, in an order of their own each time."""
        times = -(-number // len(values))
        return [values[i] for _ in range(times) for i in rng.permutation(len(values))][:number]

    found = {}
    choices = zip(in_turn(_KINDS), in_turn(_PERIODS), in_turn(_LAWS), strict=True)
    for k, (kind, period, law) in enumerate(choices):
        case = _drawn(rng, law, period, kind)
        m, unit = case.machine, "kg m^2" if case.is_rotary else "kg"
        name = f"drawn {k + 1}: {law}, {m.mass:.3g} {unit}, {1e3 * period:g} ms, {kind}"
        found[name] = case
    return found


def _drawn(rng: np.random.Generator, law: str, period: float, kind: str) -> Case:
    """A machine whose force, friction, law, encoder and noise are in proportion."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    is_rotary = bool(rng.random() < 0.3)
    mass = between(1e-3, 10.0) if is_rotary else between(1.0, 1000.0)
    speed = between(2.0, 20.0) if is_rotary else between(0.05, 0.5)
    rise = max(between(0.05, 0.2), 20 * period)
    force = mass * speed / rise
    coulomb, viscous, offset = (force * rng.uniform(0.1, 0.6) for _ in range(3))
    offset = float(rng.choice([-1, 0, 0, 1])) * offset
    gain = (force + coulomb + viscous + abs(offset)) / 3.0  # a third of the limit of 10 V
    bandwidth = min(2 * math.pi * rng.uniform(8, 25), 0.25 / period)
    kv, kp = bandwidth * mass / gain, bandwidth / rng.uniform(4, 6)
    noise = {
        0: None,
        1: white(coulomb * rng.uniform(0.01, 0.05)),
        2: autoregressive(coulomb * rng.uniform(0.01, 0.04), between(3e-3, 0.3), period),
    }[int(rng.integers(3))]
    # A step of the encoder is heard in the control, by 0.3 V at most.
    step = min(speed * period * between(3e-3, 0.3), 0.3 * period / kv)
    machine = Machine(
        mass=mass,
        viscous=viscous / speed,
        coulomb=coulomb,
        offset=offset,
        gain=gain,
        kp=kv * kp if law == "PID" else kp,
        kv=kv,
        tn=rng.uniform(5, 10) / bandwidth if law == "P-PI" else math.inf,
        ki=kv * kp * bandwidth / rng.uniform(20, 40) if law == "PID" else None,
        kd=kv if law == "PID" else 0.0,
        period=period,
        resolution=step,
        force_noise=noise,
        position_noise=white(step * rng.uniform(0.1, 1.0)) if rng.random() < 0.3 else None,
        control_step=float(rng.choice([0.0, 0.0, 0.005])),
    )
    log = Log(jitter=0.03 if rng.random() < 0.2 else 0.0)
    # Some fifty rises at least; as many samples at most as are quickly simulated.
    seconds = min(between(max(2.0, 50 * rise), 60.0), 16_000 * period)
    motion = Motion(kind, speed, rise, seconds)
    return Case(machine=machine, declared=machine, motion=motion, log=log, is_rotary=is_rotary)


def axes_of_faults(seed: int) -> dict[str, Case]:
    """The axes that faults are put into: a stage, and two that are drawn."""
    rng = np.random.default_rng([seed, 24])
    stage = Machine(resolution=1e-6, force_noise=white(1.0))
    return {
        "stage": _right(stage),
        "P-PI": _level(_drawn(rng, "P-PI", 1e-3, "minimum jerk")),
        "PID": _level(_drawn(rng, "PID", 2e-3, "trapezoids with dwells")),
    }


def _level(case: Case) -> Case:
    """Without a weight, so that an offset is none that is declared."""
    machine = replace(case.machine, offset=0.0)
    return replace(case, machine=machine, declared=machine)


#: What is wrong, of a right case, and what has to be said of it. Of two masses that is the
#: frequency of the load with the axis held, or that of both of them free, 1.29 times as high.
Fault = tuple[Callable[[Case], Case], str]


def _is(**changes: Callable[[Case], object]) -> Callable[[Case], Case]:
    """Change the machine, not what is declared of it."""
    return lambda case: replace(
        case,
        machine=replace(case.machine, **{n: of(case) for n, of in changes.items()}),  # type: ignore[arg-type]
    )


def _resists(force: Callable[[Case, Array, Array], Array]) -> Callable[[Case], Case]:
    """Add a resisting force of the position and of the velocity."""
    return _is(resistance=lambda c: lambda _time, q, v: force(c, q, v))


def _logs(**changes: object) -> Callable[[Case], Case]:
    return lambda case: replace(case, log=case.log._replace(**changes))


def _travel(case: Case) -> float:
    return float(np.ptp(reference_of(case.motion, case.machine.period)))


def _rubs(shape: Callable[[Case, Array, Array], Array]) -> Callable[[Case], Case]:
    """Have Coulomb friction so many times what is declared, of the position and of the speed."""
    return _is(shape=lambda c: lambda q, speed: shape(c, q, speed))


def _wave(share: float, lengths: float) -> Callable[[Case], Callable[[Array], Array]]:
    """A sine over the position, of so many lengths over the travel."""

    def of(case: Case) -> Callable[[Array], Array]:
        rate = 2 * math.pi * lengths / _travel(case)
        return lambda q: np.asarray(share * np.sin(rate * q))

    return of


def _rubs_along(share: float, lengths: float) -> Callable[[Case], Case]:
    """Have such a sine in Coulomb friction."""

    def of(case: Case) -> Callable[[Array, Array], Array]:
        wave = _wave(share, lengths)(case)
        return lambda q, _: 1.0 + wave(q)

    return _is(shape=of)


def _cogs(case: Case) -> Callable[[float, Array, Array], Array]:
    wave, size = _wave(0.08, 18.0)(case), case.machine.coulomb
    return lambda _time, q, _v: size * wave(q)


def _springs(case: Case) -> Callable[[float, Array, Array], Array]:
    rate = 0.2 * case.machine.coulomb / _travel(case)
    return lambda _time, q, _v: rate * q


def _peak(case: Case) -> float:
    """What the motion asks of the control, V."""
    m, time = case.machine, case.machine.period
    velocity = np.gradient(reference_of(case.motion, time), time)
    force = m.mass * np.gradient(velocity, time) + m.viscous * velocity
    return float(np.abs(force + m.coulomb * np.sign(velocity)).max() / m.gain)


def _behind(frequency: float, **others: Callable[[Case], float]) -> Callable[[Case], Case]:
    return _is(load=lambda c: 0.4 * c.machine.mass, antiresonance=lambda _: frequency, **others)


def _signal(case: Case) -> Array:
    """A sine of 11 Hz in the control, 3 % of its limit."""
    time = case.machine.period * np.arange(round(case.motion.seconds / case.machine.period))
    return np.asarray(0.03 * case.machine.limit * np.sin(2 * math.pi * 11.0 * time))


def _forward(case: Case) -> float:
    """Half of what the mass takes."""
    return 0.5 * case.machine.mass / case.machine.gain


def _payload(case: Case) -> Callable[[float], float]:
    return lambda time: 1.0 if time < 0.6 * case.motion.seconds else 1.1


FAULTS: dict[str, Fault] = {
    "mass grows by 10 % over the record": (
        _is(mass_at=lambda c: lambda t: 1 + 0.1 * t / c.motion.seconds),
        r"(\bM\b|acceleration).*(with time|half|from .* s on)",
    ),
    "payload of 10 %, from 60 % on": (
        _is(mass_at=_payload),
        r"(\bM\b|acceleration).*(with time|half|from .* s on)",
    ),
    "Stribeck": (
        _rubs(lambda c, _, speed: 1.0 + 0.3 * np.exp(-speed / (0.08 * c.motion.speed))),
        r"stribeck",
    ),
    "quadratic": (
        _resists(lambda c, _, v: 0.3 * c.machine.coulomb * v * np.abs(v) / c.motion.speed**2),
        r"quadratic\(",
    ),
    "direction": (
        _resists(lambda c, _, v: 0.1 * c.machine.coulomb * np.abs(v) / c.motion.speed),
        r"asymmetric|direction",
    ),
    "friction over the position": (
        _rubs_along(0.1, 1.5),
        r"depends (linearly )?on the (square of the )?position|friction .*periodic in the position",
    ),
    "spring": (_is(resistance=_springs), r"spring"),
    "cogging": (
        _is(resistance=_cogs),
        r"cogging\(",
    ),
    "friction with a period": (
        _rubs_along(0.08, 7.0),
        r"periodic_coulomb\(",
    ),
    "backlash": (
        _behind(80.0, load_damping=lambda _: 0.3, play=lambda c: 5e-4 * _travel(c)),
        r"\b(backlash|play)\b",
    ),
    "two masses, 12 Hz": (_behind(12.0), r"antiresonance near 1[123]\b|loop near 1[4-7]\b"),
    "two masses, 35 Hz": (_behind(35.0), r"antiresonance near 3[2-8]\b|loop near 4[1-9]\b"),
    "two masses, 70 Hz": (
        _behind(70.0),
        r"antiresonance near (6[4-9]|7[0-6])\b|loop near (8[2-9]|9[0-9])\b",
    ),
    "gain falls by 5 % over the record": (
        _is(gain_at=lambda c: lambda t: 1 - 0.05 * t / c.motion.seconds),
        r"\bgain\b.*(with time|half|from .* s on)",
    ),
    "delay of a sample": (
        _is(delay=lambda c: c.machine.period),
        r"\b(delay|lag)\b",
    ),
    "lag of a sample": (
        _is(lag=lambda c: c.machine.period),
        r"\b(delay|lag)\b",
    ),
    "control logged a sample early": (_logs(early=1), r"before the law can|\bearl(y|ier)\b"),
    "control's sign": (_logs(factor=-1.0), r"sign is (flipped|opposite)"),
    "feed-forward in the log": (
        _is(feed_forward=_forward),
        r"feed-?forward|no change of its gains explains",
    ),
    "feed-forward out of the log": (
        _is(feed_forward=_forward, logs_feed_forward=lambda _: False),
        r"feed-?forward",
    ),
    "test signal": (_is(injected=_signal), r"test signal"),
    "sampled with jitter of 20 %": (_is(clock_jitter=lambda _: 0.2), r"\b(jitter|clock|stamps)\b"),
    "warms up by 20 %": (
        _is(friction_at=lambda c: lambda t: 1 + 0.2 * math.exp(-3 * t / c.motion.seconds)),
        r"(\bFc\b|\bFv\b|friction).*(with time|half|from .* s on)",
    ),
    "saturates": (
        _is(limit=lambda c: 0.7 * _peak(c)),
        r"at (its|the) limit|saturat|gives no more than",
    ),
    "offset": (
        _is(offset=lambda c: c.machine.offset + 0.15 * c.machine.coulomb),
        r"offset\(",
    ),
    "loss by the load of 5 %": (_is(loss=lambda _: 0.05), r"\bloss\b|by the load"),
    "kp 10 % larger": (_is(kp=lambda c: 1.1 * c.machine.kp), r"\bkp is \S+ instead of \S+ \(1\."),
    "damping 10 % larger": (
        _is(kv=lambda c: 1.1 * c.machine.kv, kd=lambda c: 1.1 * c.machine.kd),
        r"\bk[vd] is \S+ instead of \S+ \(1\.",
    ),
}


def wrong(seed: int) -> dict[str, Case]:
    """Every fault in each of three axes."""
    return {
        f"{fault}; {name}": replace(change(case), fault=fault, named=named)
        for fault, (change, named) in FAULTS.items()
        for name, case in axes_of_faults(seed).items()
    }


@cache
def reference_of(motion: Motion, period: float) -> Array:
    """The commanded positions of a motion, (N,)."""
    kind, speed, rise, seconds = motion
    time = period * np.arange(round(seconds / period))
    match kind:
        case "trapezoids" | "trapezoids with dwells":
            return _trapezoids(time, speed, rise, 3 * rise if "dwells" in kind else 0.0)
        case "minimum jerk":
            return _minimum_jerk(time, speed, rise)
        case "prbs":
            return _levels(time, 4 * rise, 0.7 * rise, speed * np.array([-1.0, 1.0]))
        case "joystick":
            levels = speed * np.array([-1.0, -0.4, 0.0, 0.0, 0.4, 1.0])
            return _levels(time, 4 * rise, 0.7 * rise, levels)
        case "multisine":
            rates = 0.3 / rise * np.arange(1, 10, 2)
            waves = sum(np.sin(w * time + k * k) / w for k, w in enumerate(rates))
            return _scaled(time, waves, speed, rise)
        case "chirp":
            rate = 0.15 / rise * (1 + 12 * time / seconds)
            return _scaled(time, np.sin(np.cumsum(rate) * period) / rate, speed, rise)
    raise ValueError(f"no motion is called {kind}")


def _scaled(time: Array, position: Array, speed: float, rise: float) -> Array:
    """From rest, with a greatest speed."""
    begun = position * np.minimum(1.0, time / (4 * rise)) ** 2
    return np.asarray(begun * speed / np.abs(np.gradient(begun, time)).max())


def _trapezoids(time: Array, speed: float, rise: float, dwell: float) -> Array:
    """There and back at a third, two thirds and all of a speed, each time with the same rise."""
    slow = speed / 3
    corners, at, end = [0.0], [0.0], 0.0
    k = 0
    while end < time[-1]:
        v = slow * (1 + (k // 2) % 3) * (1 if k % 2 == 0 else -1)
        ramp = rise * abs(v) / speed
        for span, level in ((dwell, 0.0), (ramp, v), (5 * rise, v), (ramp, 0.0)):
            end += span
            corners.append(level)
            at.append(end)
        k += 1
    velocity = np.interp(time, at, corners)
    steps = (velocity[1:] + velocity[:-1]) / 2 * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _minimum_jerk(time: Array, speed: float, rise: float) -> Array:
    """Moves of several lengths, with rests of a third of their time."""
    span = 5 * rise
    move, phase = np.divmod(time, 4 / 3 * span)
    part = np.minimum(phase / span, 1.0)
    shape = part**3 * (10 - 15 * part + 6 * part**2)
    places = np.array([0.0, 0.4, -0.2, 0.7, 0.1, -0.3, 0.3]) * speed * span / 1.875
    begin, end = (places[(move.astype(int) + k) % len(places)] for k in (0, 1))
    return np.asarray(begin + (end - begin) * shape)


def _levels(time: Array, hold: float, smooth: float, levels: Array) -> Array:
    """Random levels of a speed, held and smoothed by two low-passes, as a position."""
    period = float(time[1])
    chosen = np.random.default_rng(7).choice(levels, size=int(time[-1] / hold) + 1)
    speed = chosen[(time / hold).astype(int)]
    kept = math.exp(-period / smooth)
    for _ in range(2):
        speed = lfilter([1 - kept], [1, -kept], speed)
    return np.asarray(np.cumsum(speed) * period)


@cache
def declared_axis(
    *,
    nominal: float = 100.0,
    law_of: tuple[float, float, float, float | None, float, float] = (
        *(Machine.kp, Machine.kv, Machine.tn, Machine.ki, Machine.kd, Machine.period),
    ),
    gain: float = Machine.gain,
    limit: float = Machine.limit,
    has_offset: bool = False,
    is_rotary: bool = False,
    **drive: float,
) -> GeneratedAxis:
    """The axis as it is declared, whatever the machine has besides."""
    units = ("rad", "kg m^2", "N m/(rad/s)", "N m") if is_rotary else ("m", "kg", "N/(m/s)", "N")
    q = Coordinate("q", unit=units[0])
    mass = Parameter("M", units[1], nominal=nominal, lower=0.0)
    fv, fc, f0 = Parameter("Fv", units[2]), Parameter("Fc", units[3]), Parameter("F0", units[3])
    return build(
        newton(
            "stage",
            coordinate=q,
            parameters=(mass, fv, fc, *((f0,) if has_offset else ())),
            inertia=mass,
            resistance=(viscous(fv, q), coulomb(fc, q), *((offset(f0),) if has_offset else ())),
            drive=Drive(gain=gain, unit="V", limit=limit, **drive),  # type: ignore[arg-type]
            control=_law(*law_of),
        )
    )


def _law(kp: float, kv: float, tn: float, ki: float | None, kd: float, period: float) -> ControlLaw:
    if ki is not None:
        return pid(kp=kp, ki=ki, kd=kd, period=period)
    if math.isfinite(tn):
        return cascade_p_pi(kp=kp, kv=kv, tn=tn, period=period)
    return cascade_pd_difference(kp=kp, kv=kv, period=period)
