"""Machines that are identified to count judgements, and what is declared of them.

Right models of several noises, motions and logs; machines of the field, which rest between moves,
under laws with an integral, behind coarse encoders, at other periods; the same whose reversals are
kept, of which least squares or DIDIM is asked for, and without a reference; and wrong models, each
with what has to be said of it. `judgement.py` counts.
"""

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from machines import Array, Machine, autoregressive, white
from scipy.signal import lfilter

from axisid import Coordinate, Parameter, build, leave_out, newton
from axisid.codegen.artefacts import GeneratedAxis
from axisid.control import ControlLaw, cascade_p_pi, cascade_pd_difference, pid
from axisid.elements import Drive, coulomb, offset, viscous
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import back_and_forth

#: What a drive is declared to do to commands, by the names of `Machine`.
OF_DRIVE = ("lag", "delay", "rate_limit", "quantisation", "deadband")


class Gains(NamedTuple):
    """Of a law, as `Machine` has them."""

    kp: float
    kv: float
    period: float
    tn: float
    ki: float | None
    kd: float

    @classmethod
    def of(cls, machine: Machine) -> "Gains":
        """Those of a machine."""
        return cls(*(getattr(machine, name) for name in cls._fields))

    @property
    def law(self) -> ControlLaw:
        """As it is declared."""
        plain = {"kp": self.kp, "period": self.period}
        if self.ki is not None:
            return pid(**plain, ki=self.ki, kd=self.kd)
        if math.isfinite(self.tn):
            return cascade_p_pi(**plain, kv=self.kv, tn=self.tn)
        return cascade_pd_difference(**plain, kv=self.kv)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A machine and what is declared of it.

    Attributes
    ----------
    machine : Machine
    has_offset : bool
        Whether an offset is declared.
    motion : str
        Of `reference_of`.
    named : str
        Regular expression of what has to be said of a wrong model; empty for a right one.
    rightly : tuple of str
        Checks that are right to fail on a right model, as a method that the record does not suit
        is far off.
    kept : bool
        Whether reversals are kept, which are else left out.
    methods : tuple of str, optional
        That are asked for; all by default.
    has_reference : bool
        Whether the reference is recorded.
    logged_step : float
        What the log rounds the position to, which the law does not have, m; 0 for nothing.
    logged_zero : float
        How far the logged position is from where the law reads it, m.
    is_late : bool
        Whether the drive is declared to act as it is told, whatever the machine's does.
    jitter : float
        Root mean square of what parts the stamps from even times, in periods.
    undeclared : str
        A parameter of the machine that is not declared, with its term; empty for none.
    gains : Gains, optional
        Of the law that is declared; the machine's by default.
    logged_control : float
        How many times the control is logged as it is; -1 for its opposite.
    logged_early : int
        Samples by which it is logged before it acts.
    """

    machine: Machine
    has_offset: bool = False
    motion: str = "moves"
    named: str = ""
    rightly: tuple[str, ...] = ()
    kept: bool = False
    methods: tuple[str, ...] | None = None
    has_reference: bool = True
    logged_step: float = 0.0
    logged_zero: float = 0.0
    is_late: bool = False
    jitter: float = 0.0
    undeclared: str = ""
    gains: Gains | None = None
    logged_control: float = 1.0
    logged_early: int = 0


_PLAIN = Gains.of(Machine())
_QUIET = Machine(resolution=5e-8, control_noise=white(2e-3))


def _with(**changes: object) -> Machine:
    return replace(_QUIET, **changes)  # type: ignore[arg-type]


RIGHT: dict[str, Case] = {
    "fine encoder": Case(machine=_QUIET),
    "white position noise": Case(machine=_with(position_noise=white(1e-6))),
    "white control noise": Case(machine=_with(control_noise=white(0.05))),
    "exact encoder": Case(machine=_with(resolution=0.0)),
    "control noise of 20 ms": Case(
        machine=_with(resolution=0.0, control_noise=autoregressive(0.05, 0.02, 1e-3))
    ),
    "force of 50 ms": Case(machine=_with(force_noise=autoregressive(2.0, 0.05, 1e-3))),
    "force of 500 ms": Case(machine=_with(force_noise=autoregressive(2.0, 0.5, 1e-3))),
    "2 s of it": Case(
        machine=_with(force_noise=autoregressive(2.0, 0.05, 1e-3)), motion="short moves"
    ),
    "coarse encoder": Case(
        machine=_with(resolution=5e-5),
    ),
    "encoder of 5 um": Case(machine=_with(resolution=5e-6)),
    "sines": Case(machine=_QUIET, motion="sines"),
    "weight": Case(machine=_with(offset=150.0, coulomb=40.0), has_offset=True),
    "high friction": Case(machine=_with(coulomb=90.0)),
    "drive with a lag": Case(machine=_with(lag=1e-3)),
    "drive with a lag and a delay": Case(
        machine=_with(lag=8e-4, delay=4e-4, position_noise=white(1e-6))
    ),
    "drive with a dead band": Case(machine=_with(deadband=0.1)),
    "drive with a rate, steps and a dead band": Case(
        machine=_with(rate_limit=300.0, quantisation=0.05, deadband=0.1, position_noise=white(1e-6))
    ),
}

_P_PI = replace(Machine(), kp=25.0, kv=150.0, tn=0.05)

#: Right models of machines as they stand in the field.
FIELD: dict[str, Case] = {
    "dwells, 2 um": Case(machine=Machine(resolution=2e-6), motion="dwells"),
    "dwells, 2 um, force of 20 ms": Case(
        machine=Machine(resolution=2e-6, force_noise=autoregressive(1.0, 0.02, 1e-3)),
        motion="dwells",
    ),
    "dwells, white 5 um": Case(machine=Machine(position_noise=white(5e-6)), motion="dwells"),
    "P-PI, dwells, 1 um": Case(
        machine=replace(_P_PI, resolution=1e-6, force_noise=white(2.0)), motion="dwells"
    ),
    "P-PI, 850 kg, minimum jerk, 5 um": Case(
        machine=replace(
            _P_PI, mass=850.0, viscous=900.0, coulomb=120.0, gain=300.0, resolution=5e-6, kv=120.0
        ),
        motion="minimum jerk",
    ),
    "P-PI, PRBS, force": Case(
        machine=replace(_P_PI, resolution=1e-6, force_noise=white(3.0)), motion="prbs"
    ),
    "PID, joystick, 20 um": Case(
        machine=replace(
            _P_PI, kp=1200.0, ki=4000.0, kd=80.0, resolution=2e-5, force_noise=white(1.0)
        ),
        motion="joystick",
    ),
    "0.25 ms, dwells, 0.5 um": Case(
        machine=Machine(
            period=2.5e-4, resolution=5e-7, force_noise=autoregressive(1.0, 0.02, 2.5e-4)
        ),
        motion="dwells",
    ),
    "5 ms, P-PI, dwells, 1 um": Case(
        machine=replace(
            _P_PI, period=5e-3, kp=15.0, kv=100.0, tn=0.1, resolution=1e-6, force_noise=white(2.0)
        ),
        motion="dwells",
    ),
    "P-PI, multisine, 10 um, rounded control": Case(
        machine=replace(_P_PI, resolution=1e-5, control_step=0.01, force_noise=white(2.0)),
        motion="multisine",
    ),
}

#: Right models whose reversals are kept.
KEPT: dict[str, Case] = {
    "sines, kept": Case(machine=_QUIET, motion="sines", kept=True),
    "high friction, kept": Case(machine=_with(coulomb=90.0), motion="two sines", kept=True),
    "slow, high friction, kept": Case(machine=_with(coulomb=90.0), motion="slow sines", kept=True),
    "position noise, kept": Case(
        machine=_with(position_noise=white(3e-6)),
        motion="two sines",
        kept=True,
    ),
    "slow, position noise, kept": Case(
        machine=_with(position_noise=white(3e-6)),
        motion="slow sines",
        kept=True,
    ),
}

_QUIET_LOOPS = ("fine encoder", "white control noise", "force of 50 ms", "2 s of it", "sines")

#: Of which least squares is asked for alone, and those without a reference.
ALONE: dict[str, Case] = {
    f"{name}, least squares": replace(RIGHT[name], methods=("idm-ls",)) for name in _QUIET_LOOPS
}
FREE: dict[str, Case] = {
    f"{name}, no reference": replace(RIGHT[name], has_reference=False)
    for name in (*_QUIET_LOOPS, "white position noise", "encoder of 5 um")
}
FREE |= {
    f"position noise of {size} um, no reference": Case(
        machine=_with(resolution=0.0, position_noise=white(size * 1e-6)), has_reference=False
    )
    for size in (5, 10)
}

_SHORT = replace(RIGHT["2 s of it"], machine=_QUIET)

#: Short records, logs that are coarser than the encoder, and stamps that are uneven where the
#: sampling is not.
LOGGED: dict[str, Case] = {
    "2 s, force of 10 ms": replace(
        _SHORT, machine=_with(force_noise=autoregressive(2.0, 0.01, 1e-3))
    ),
    "2 s, force of 500 ms": replace(
        _SHORT,
        machine=_with(force_noise=autoregressive(2.0, 0.5, 1e-3)),
        rightly=("precision",),  # friction is known to 20 %
    ),
    "2 s, white control noise": replace(_SHORT, machine=_with(control_noise=white(0.05))),
    "2 s, coarse encoder": replace(
        _SHORT, machine=_with(resolution=5e-5), rightly=RIGHT["coarse encoder"].rightly
    ),
}
LOGGED |= {
    f"{name}, {log} log": replace(
        RIGHT[name],
        has_reference=False,
        logged_step=step,
        # What the filter moves is not known there: 0.03 % of the mass, nine deviations.
        rightly=("residuals against the motion", "normal residuals")
        if name in ("fine encoder", "sines")
        else (),
    )
    for name in ("fine encoder", "white control noise", "force of 50 ms", "sines")
    for log, step in (("0.1 um", 1e-7), ("0.5 um", 5e-7))
}
LOGGED |= {
    f"{name}, stamps {percent} % off": replace(RIGHT[name], jitter=percent / 100)
    for name in ("fine encoder", "white position noise", "force of 50 ms", "sines")
    for percent in (2, 4)
}

#: Of which DIDIM is asked for alone, and beside instruments as a second opinion.
OUTPUT_ERROR: dict[str, Case] = {
    f"{name}, {said}": replace(case, methods=methods, rightly=())
    for name, case in (RIGHT | KEPT).items()
    for said, methods in (("didim", ("didim",)), ("second opinion", ("idm-iv", "didim")))
}

_STAGE = _with(force_noise=white(1.0))
#: A sine of 11 Hz in the control, V, that the log does not have.
_INJECTED = 0.3 * np.sin(2 * math.pi * 11.0 * 1e-3 * np.arange(40000))

WRONG: dict[str, Case] = {
    "mass changes": Case(
        machine=replace(_STAGE, mass_at=lambda time: 100.0 if time < 9.0 else 110.0),
        named=r"\bM\b.*(chang|half|from .* s on)",
    ),
    "missing offset": Case(machine=replace(_STAGE, offset=3.0), named=r"offset"),
    "no Coulomb friction declared": Case(machine=_STAGE, undeclared="Fc", named=r"declare coulomb"),
    "no viscous friction declared": Case(machine=_STAGE, undeclared="Fv", named=r"declare viscous"),
    "Stribeck peak": Case(
        machine=replace(
            _STAGE, resistance=lambda _, __, v: 8.0 * np.sign(v) * np.exp(-np.abs(v) / 0.01)
        ),
        named=r"[Ss]tribeck",
    ),
    "directional viscous": Case(
        machine=replace(_STAGE, resistance=lambda _, __, v: 12.0 * np.abs(v)),
        named=r"asymmetric_viscous|direction",
    ),
    "friction dip": Case(
        machine=replace(
            _STAGE,
            resistance=lambda _, __, v: (
                -4.0
                * np.sign(v)
                * np.maximum(0.0, 1.0 - np.abs(v) / 0.04)
                * np.minimum(1.0, np.abs(v) / 2e-3)
            ),
        ),
        named=r"[Ss]tribeck|speed",
    ),
    "position dependence": Case(
        machine=replace(
            _STAGE,
            resistance=lambda _, q, v: 2.5 * np.sign(v) * np.sin(2 * math.pi * q / 0.1),
        ),
        named=r"position",
    ),
    "load behind a spring, 12 Hz": Case(
        machine=replace(_STAGE, load=40.0, antiresonance=12.0),
        named=r"resonance: an antiresonance near 1[123]\b",
    ),
    "load behind a spring, 35 Hz": Case(
        machine=replace(_STAGE, load=40.0, antiresonance=35.0),
        named=r"resonance: an antiresonance near 3[2-8]\b",
    ),
    "cogging of 5 mm": Case(
        machine=replace(
            _STAGE, coulomb=20.0, resistance=lambda _, q, __: np.sin(2 * math.pi * q / 0.005)
        ),
        named=r"declare cogging\(.*period=0\.00(5|49\d|50\d)\)",
    ),
    "friction every 20 mm": Case(
        machine=replace(
            _STAGE,
            coulomb=20.0,
            resistance=lambda _, q, v: np.sign(v) * np.sin(2 * math.pi * q / 0.02),
        ),
        named=r"declare periodic_coulomb\(.*period=0\.0(2|19\d|20\d)\)",
    ),
    "quadratic friction": Case(
        machine=replace(_STAGE, resistance=lambda _, __, v: 300.0 * v * np.abs(v)),
        named=r"quadratic",
    ),
    "spring": Case(
        machine=replace(_STAGE, resistance=lambda _, q, __: 60.0 * (q - 0.05)), named=r"spring"
    ),
    "test signal not recorded": Case(
        machine=replace(_STAGE, injected=_INJECTED), named=r"test signal"
    ),
    "kp declared 10 % low": Case(
        machine=replace(_STAGE, kp=1.1 * 160.18), gains=_PLAIN, named=r"\bkp is 1\."
    ),
    "kv declared 10 % low": Case(
        machine=replace(_STAGE, kv=1.1 * 243.45), gains=_PLAIN, named=r"\bkv is 1\."
    ),
    "log of 11 bit, no reference": Case(
        machine=_QUIET, has_reference=False, logged_step=0.09 / 2**11, named=r"M by about -\d"
    ),
    "position 10 um from its zero": Case(
        machine=_QUIET, logged_zero=1e-5, named=r"\+1e-05 m away from its zero"
    ),
    "lag not declared": Case(
        machine=_with(lag=1e-3), is_late=True, named=r"delay or its lag, 0\.000[89]|0\.001"
    ),
    "delay not declared": Case(
        machine=_with(delay=6e-4), is_late=True, named=r"delay or its lag, 0\.000[567]"
    ),
    "dead band not declared": Case(
        machine=_with(deadband=0.1),
        is_late=True,
        named=r"dead band, Drive\(deadband=0\.(1|099|098)\)",
    ),
    "position noise, least squares": Case(
        machine=_with(position_noise=white(1e-6)), methods=("idm-ls",), named=r"\bM misses for it"
    ),
}

#: Behind encoders whose steps the law reads as they are, under laws with an integral.
_STEPS = {name: FIELD[name] for name in ("P-PI, dwells, 1 um", "PID, joystick, 20 um")}
for _name, _case in _STEPS.items():
    WRONG |= {
        f"{_name}, control's sign flipped": replace(
            _case, logged_control=-1.0, named=r"its sign is opposite"
        ),
        f"{_name}, logged a sample early": replace(_case, logged_early=1, named=r"1 sample before"),
        f"{_name}, test signal not recorded": replace(
            _case,
            machine=replace(_case.machine, injected=_INJECTED),
            named=r"not the declared law's .*test signal",
        ),
    }

CASES = RIGHT | FIELD | KEPT | ALONE | FREE | LOGGED | OUTPUT_ERROR | WRONG


def _moves(period: float = 1e-3, repeat: int = 3, dwell: float = 0.0) -> Array:
    moves = back_and_forth(
        speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=0.75, repeat=repeat, dwell=dwell
    )
    return np.asarray(trajectory(moves, period))


#: Amplitudes in m, frequencies in Hz.
_SINES = {
    "sines": ((0.02, 0.5), (0.005, 1.3), (0.002, 2.9)),
    "two sines": ((0.02, 0.3), (0.004, 1.1)),
    "slow sines": ((0.05, 0.1), (0.01, 0.4)),
}


def _sines(motion: str) -> Array:
    time = 1e-3 * np.arange(18000)
    begin = np.minimum(1.0, time / 0.5)
    waves = _SINES[motion]
    return np.asarray(begin * sum(a * np.sin(2 * math.pi * f * time) for a, f in waves))


def _minimum_jerk(time: Array) -> Array:
    """Moves of 40 to 90 mm in 0.9 s, there and back, with rests of 0.3 s."""
    move, phase = np.divmod(time, 1.2)
    part = np.minimum(phase / 0.9, 1.0)
    shape = part**3 * (10 - 15 * part + 6 * part**2)
    places = np.array([0.0, 0.04, -0.02, 0.07, 0.01, -0.05, 0.03])
    begin, end = (places[(move.astype(int) + k) % len(places)] for k in (0, 1))
    return np.asarray(begin + (end - begin) * shape)


def _filtered_noise(time: Array, hold: float, smooth: float, levels: Array) -> Array:
    """Random levels of a speed, held and smoothed by a second-order low-pass, as a position."""
    period = float(time[1])
    drawn = np.random.default_rng(7).choice(levels, size=int(time[-1] / hold) + 1)
    speed = drawn[(time / hold).astype(int)]
    kept = math.exp(-period / smooth)
    for _ in range(2):
        speed = lfilter([1 - kept], [1, -kept], speed)
    return np.asarray(np.cumsum(speed) * period)


def _multisine(time: Array) -> Array:
    begin = np.minimum(1.0, time / 0.5)
    of_each = range(1, 10, 2)
    waves = (np.sin(2 * math.pi * 0.3 * k * time + k * k) / k for k in of_each)
    return np.asarray(0.02 * begin * sum(waves))


@cache
def reference_of(motion: str, period: float = 1e-3) -> Array:
    """The commanded positions of a motion by its name."""
    time = period * np.arange(round(13.0 / period))
    match motion:
        case "dwells":
            return _moves(period, repeat=2, dwell=0.4)
        case "minimum jerk":
            return _minimum_jerk(time)
        case "prbs":
            return _filtered_noise(time, 0.25, 0.02, np.array([-0.1, 0.1]))
        case "joystick":
            return _filtered_noise(time, 0.6, 0.08, np.array([-0.12, -0.05, 0.0, 0.0, 0.05, 0.12]))
        case "multisine":
            return _multisine(time)
    if motion in _SINES:
        return _sines(motion)
    reference = _moves()
    return reference[:2000] if motion == "short moves" else reference


@cache
def declared(
    *, has_offset: bool, gains: Gains = _PLAIN, gain: float = 35.15, **drive: float
) -> GeneratedAxis:
    """The axis as it is declared, whatever the machine has besides."""
    q = Coordinate("q", unit="m")
    mass = Parameter("M", "kg", nominal=100.0, lower=0.0)
    fv, fc, f0 = Parameter("Fv", "N/(m/s)"), Parameter("Fc", "N"), Parameter("F0", "N")
    plain = Machine()
    return build(
        newton(
            "stage",
            coordinate=q,
            parameters=(mass, fv, fc, *((f0,) if has_offset else ())),
            inertia=mass,
            resistance=(viscous(fv, q), coulomb(fc, q), *((offset(f0),) if has_offset else ())),
            drive=Drive(gain=gain, unit="V", limit=plain.limit, **drive),  # type: ignore[arg-type]
            control=gains.law,
        )
    )


def axis_of(case: Case) -> GeneratedAxis:
    """The axis as a case declares it."""
    drive = {} if case.is_late else {name: getattr(case.machine, name) for name in OF_DRIVE}
    gains = case.gains or Gains.of(case.machine)
    axis = declared(has_offset=case.has_offset, gains=gains, gain=case.machine.gain, **drive)
    return build(leave_out(axis.axis, case.undeclared)) if case.undeclared else axis
