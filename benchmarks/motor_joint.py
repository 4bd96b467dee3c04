"""A joint on a motor behind a gear, and an integrator of it that shares nothing with the program.

The winding's current is a state of its own, the gear's loss and the rotor before the gear are
solved for at every instant; the steps are a fiftieth of a sample, by the Runge-Kutta rule.
"""

import math
from dataclasses import dataclass

import numpy as np

from axisid import Axis, Coordinate, Parameter, newton
from axisid.control import cascade_pd_difference
from axisid.elements import Drive, back_emf, coulomb, gravity_moment, viscous, voltage_drive
from axisid.modeling.declaration import Experiment, back_and_forth

KT, OHMS, RATIO, PERIOD = 0.05, 1.2, 50.0, 1e-3
TRUTH = {"J": 0.17, "mgl": 1.2, "fv": 0.9, "fc": 1.6}
KE_TRUTH = 0.0512
ROTOR = 2e-5  # kg m^2, a third of J
NOISE, STEPS = 2.2e-6, 50
LAW = {"kp": 25.0, "kv": 10.0}
LIMIT = 24.0

q = Coordinate("q", unit="rad")
J = Parameter("J", "kg m^2", nominal=0.2, lower=0.0)
WEIGHT = Parameter("mgl", "N m")
FV = Parameter("fv", "N m/(rad/s)", lower=0.0)
FC = Parameter("fc", "N m", lower=0.0)
KE = Parameter("ke", "V/(rad/s)", nominal=0.04, lower=0.0)


@dataclass(frozen=True, kw_only=True)
class Motor:
    """What a record is made with.

    Attributes
    ----------
    ke : float
        Back-EMF constant; 0 for a current that is controlled.
    lag : float
        L/R, s.
    efficiency : float
    supply : float
        V, of a current that is controlled.
    rotor : float
        Inertia on the motor's side of the gear, kg m^2, a part of J.
    """

    ke: float = KT
    lag: float = 0.0
    efficiency: float = 1.0
    supply: float = math.inf
    rotor: float = 0.0

    def settled(self, control: float, velocity: float) -> float:
        """The motor's force on the load's side of a lossless gear, once its current is there."""
        emf = self.ke * RATIO * velocity
        if math.isfinite(self.supply):
            most, least = (self.supply - emf) / OHMS, (-self.supply - emf) / OHMS
            return KT * RATIO * min(max(control, least), most)
        return KT * RATIO / OHMS * (control - emf)

    def acceleration(self, tau: float, position: float, velocity: float, side: float) -> float:
        """In a friction direction, under the force of the motor."""
        theta = TRUTH
        load = theta["mgl"] * math.cos(position) + theta["fv"] * velocity + theta["fc"] * side
        turned = self.rotor * RATIO**2
        for share in (self.efficiency, 1 / self.efficiency):
            slope = (share * tau - load) / (theta["J"] - turned + share * turned)
            drives = (tau - turned * slope) * side >= 0
            if drives == (share == self.efficiency):
                break
        return slope


def integrated(motor: Motor, reference: np.ndarray, noise: np.ndarray) -> dict[str, np.ndarray]:
    """Position and control of the loop at the samples, by RK4 with three states, (N,) each."""
    state, before = [float(reference[0]), 0.0, 0.0], None
    kp, kv, limit = LAW["kp"], LAW["kv"], LIMIT
    positions, controls = [], []
    for r, e in zip(reference.tolist(), noise.tolist(), strict=True):
        measured = state[0] + e
        last = measured if before is None else before
        control = kv * (kp * (r - measured) - (measured - last) / PERIOD)
        control, before = min(max(control, -limit), limit), measured
        positions.append(state[0])
        controls.append(control)
        for _ in range(STEPS):
            state = _stepped(motor, control, state, PERIOD / STEPS)
    return {"position": np.array(positions), "control": np.array(controls)}


def _stepped(motor: Motor, control: float, state: list[float], step: float) -> list[float]:
    """A step through reversals; an axis at rest is looked at where a step begins."""
    left = step
    for _ in range(4):
        side = _side(motor, control, state)
        if side == 0:
            return [state[0], 0.0, _later(motor, control, state[2], left)]
        end = _moved(motor, control, state, side, left)
        if end[1] * side >= 0:
            return end
        low, high = 0.0, left
        for _ in range(50):
            middle = 0.5 * (low + high)
            ahead = _moved(motor, control, state, side, middle)[1] * side > 0
            low, high = (middle, high) if ahead else (low, middle)
        state = _moved(motor, control, state, side, low)
        state[1], left = 0.0, left - low
    return state


def _side(motor: Motor, control: float, state: list[float]) -> float:
    """Friction direction; 0 where it sticks."""
    if state[1]:
        return math.copysign(1.0, state[1])
    tau = state[2] if motor.lag else motor.settled(control, 0.0)
    if motor.acceleration(tau, state[0], 0.0, 1.0) > 0:
        return 1.0
    return -1.0 if motor.acceleration(tau, state[0], 0.0, -1.0) < 0 else 0.0


def _later(motor: Motor, control: float, tau: float, span: float) -> float:
    """The motor's force of an axis that stands still, some time on."""
    settled = motor.settled(control, 0.0)
    return settled + (tau - settled) * math.exp(-span / motor.lag) if motor.lag else settled


def _moved(
    motor: Motor, control: float, state: list[float], side: float, span: float
) -> list[float]:
    def slopes(s: list[float]) -> list[float]:
        settled = motor.settled(control, s[1])
        tau = s[2] if motor.lag else settled
        rate = (settled - s[2]) / motor.lag if motor.lag else 0.0
        return [s[1], motor.acceleration(tau, s[0], s[1], side), rate]

    def ahead(k: list[float], h: float) -> list[float]:
        return [s + h * each for s, each in zip(state, k, strict=True)]

    k1 = slopes(state)
    k2 = slopes(ahead(k1, span / 2))
    k3 = slopes(ahead(k2, span / 2))
    k4 = slopes(ahead(k3, span))
    mean = [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
    end = ahead(mean, span)
    return end if motor.lag else [*end[:2], motor.settled(control, end[1])]


MOTOR = {"kt": KT, "ratio": RATIO, "limit": LIMIT}


def on_voltage(**others: float) -> Drive:
    """The motor on a voltage, by its figures or others."""
    return voltage_drive(resistance=OHMS, **{"ke": KT, **MOTOR, **others})


def joint(drive: Drive, *, emf: bool = False) -> Axis:
    """The joint with a drive; with the back-EMF constant in place of the friction, then known."""
    friction = back_emf(KE, q, kt=KT, resistance=OHMS, ratio=RATIO) if emf else 0
    free = (J, WEIGHT, KE if emf else FV, FC)
    truth = {p.name: {**TRUTH, "ke": KE_TRUTH}[p.name] for p in free}
    damping = TRUTH["fv"] if emf else FV
    return newton(
        "motor_joint",
        coordinate=q,
        parameters=free,
        inertia=J,
        resistance=(gravity_moment(0, WEIGHT, q), viscous(damping, q), coulomb(FC, q), friction),
        drive=drive,
        control=cascade_pd_difference(**LAW, period=PERIOD),
        experiment=Experiment(
            moves=back_and_forth(speeds=(0.4, 0.9, 1.8), acceleration=12.0, seconds=0.5, repeat=2),
            truth=truth,
            position_noise=NOISE,
            seed=1,
        ),
    )
