"""A mass with friction whose drive is not what its gain says, and what it does by other means."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from axisid import Axis, Coordinate, Parameter, newton
from axisid.control import cascade_pd_averaged
from axisid.elements import Drive, coulomb, viscous
from axisid.modeling import Experiment, back_and_forth
from axisid.support.arrays import Array
from benchmarks.event_integrator import EventIntegrator

GAIN, LIMIT, PERIOD = 35.0, 10.0, 1e-3
KP, KV = 160.0, 243.0
TRUTH = {"M": 95.0, "Fv": 200.0, "Fc": 20.0}
THETA = np.array(list(TRUTH.values()))

q = Coordinate("q")
M = Parameter("M", "kg", nominal=95.0)
Fv = Parameter("Fv", "N/(m/s)", nominal=200.0)
Fc = Parameter("Fc", "N", nominal=20.0)
LAW = cascade_pd_averaged(kp=KP, kv=KV, period=PERIOD)


def lagging(**timing: Any) -> Axis:
    """The axis with a drive of such a lag, delay and logged control."""
    return newton(
        "lagging",
        coordinate=q,
        parameters=(M, Fv, Fc),
        inertia=M,
        resistance=(viscous(Fv, q), coulomb(Fc, q)),
        drive=Drive(gain=GAIN, limit=LIMIT, **timing),
        control=LAW,
        experiment=Experiment(
            moves=back_and_forth(
                speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=1.0, repeat=2
            ),
            truth=TRUTH,
            position_noise=0.0,
        ),
    )


def noisy(axis: Axis, deviation: float, seed: int = 1) -> Axis:
    """The same with a noise of the position in its twin."""
    return replace(axis, experiment=replace(axis.experiment, position_noise=deviation, seed=seed))


def integrated(
    reference: Array,
    lag: float,
    delay: float,
    *,
    rate_limit: float = math.inf,
    quantisation: float = 0.0,
    deadband: float = 0.0,
) -> tuple[Array, Array]:
    """Position and force at the samples, by an integrator that shares nothing with the program."""
    mass, viscous_, coulomb_ = THETA

    def acceleration(_: float, v: float, tau: float, s: float, __: Any) -> float:
        return float((tau - viscous_ * v - coulomb_ * s) / mass)

    body = EventIntegrator(acceleration, float(reference[0]))
    whole = math.floor(delay / PERIOD + 1e-9)
    late = delay - whole * PERIOD
    forces, tau, last, before, slow = [0.0] * (whole + 2), 0.0, body.q, body.q, 0.0
    found = []
    for r in reference:
        found.append((body.q, tau))
        control = KV * (KP * (r - body.q) - (body.q - before) / (2 * PERIOD))
        before, last = last, body.q
        control = max(-LIMIT, min(LIMIT, control))
        slow = max(slow - rate_limit * PERIOD, min(slow + rate_limit * PERIOD, control))
        acting = slow if not quantisation else math.floor(slow / quantisation + 0.5) * quantisation
        acting = 0.0 if abs(acting) <= deadband else acting - math.copysign(deadband, acting)
        forces = [GAIN * acting, *forces[: whole + 1]]
        parts = [(forces[whole + 1], late), (forces[whole], PERIOD - late)]
        for target, span in parts if late > 1e-9 else [(forces[whole], PERIOD)]:
            tau = _moved(body, tau, target, span, lag)
        if not lag:  # the force at the next sample, before its command
            tau = forces[whole]
    return np.array(found)[:, 0], np.array(found)[:, 1]


def _moved(body: EventIntegrator, tau: float, target: float, span: float, lag: float) -> float:
    if not lag:
        body.advance(lambda *_: target, span, held=True)
        return target
    body.advance(lambda t, *_: target + (tau - target) * math.exp(-t / lag), span, held=False)
    return target + (tau - target) * math.exp(-span / lag)
