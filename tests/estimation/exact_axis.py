"""The closed form of ``M ddq = tau - Fv dq - Fc sign(dq) - tau0`` under a held force.

An oracle that shares nothing with the program: between events the velocity is an exponential, and
the time at which it reaches zero is a logarithm.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass
class ExactAxis:
    M: float
    Fv: float
    Fc: float
    tau0: float = 0.0

    def advance(self, q: float, dq: float, tau: float, span: float) -> tuple[float, float]:
        """Exact position and velocity after `span` seconds of the force `tau`."""
        while span > 0:
            push = tau - self.tau0
            if dq == 0 and abs(push) <= self.Fc:
                return q, 0.0
            sign = math.copysign(1.0, dq if dq else push)
            steady = (push - sign * self.Fc) / self.Fv
            rate = self.Fv / self.M
            stop = math.inf
            if dq and (dq - steady) * sign > 0 > steady * sign:
                stop = math.log((dq - steady) / -steady) / rate
            t = min(span, stop)
            decay = math.expm1(-rate * t)
            q += steady * t - (dq - steady) * decay / rate
            dq = 0.0 if t == stop else dq + (dq - steady) * decay
            span -= t
        return q, dq


def closed_loop(
    axis: ExactAxis, reference: np.ndarray, kp: float, kv: float, gain: float, period: float
) -> tuple[np.ndarray, np.ndarray]:
    """Position and force of the paper's sampled law, starting at the first reference."""
    q, dq = float(reference[0]), 0.0
    positions, forces = [], []
    for r in reference:
        tau = gain * min(max(kv * (kp * (r - q) - dq), -10.0), 10.0)
        positions.append(q)
        forces.append(tau)
        q, dq = axis.advance(q, dq, tau, period)
    return np.array(positions), np.array(forces)
