"""The paper's axis in closed form, in complex numbers: an independent derivative of its loop.

Between samples the force is held, and the velocity goes exponentially to what balances it. It
reaches zero at a logarithm, where the axis stops or goes on in the other direction. All of it is
analytic in the parameters, and what is decided is decided by real parts: an imaginary step of a
parameter comes out as the derivative, events included.
"""

import numpy as np

from axisid.support.arrays import Array

KP, KV, GAIN, LIMIT, PERIOD = 160.18, 243.45, 35.15, 10.0, 1e-3
_STEP = 1e-30


def control_of(parameters: Array, reference: Array, start: complex = 0.0) -> Array:
    """Control of the cascade with parameters M, Fv, Fc, (N,), complex."""
    q, v = complex(start), 0j
    found = np.empty(len(reference), dtype=complex)
    for k, commanded in enumerate(reference):
        u = KV * (KP * (commanded - q) - v)
        if abs(u.real) > LIMIT:
            u = complex(np.sign(u.real) * LIMIT)
        found[k] = u
        q, v = _moved(parameters, q, v, GAIN * u, PERIOD)
    return found


def derivative_of(parameters: Array, reference: Array, start: float) -> Array:
    """Of the control by each parameter, (N, 3)."""
    columns = []
    for j in range(len(parameters)):
        moved = parameters.astype(complex)
        moved[j] += 1j * _STEP
        columns.append(control_of(moved, reference, start).imag / _STEP)
    return np.column_stack(columns)


def _moved(
    p: Array, q: complex, v: complex, force: complex, left: complex
) -> tuple[complex, complex]:
    mass, viscous, coulomb = p
    for _ in range(4):
        direction = np.sign(v.real) or np.sign(force.real)
        if not v.real and abs(force.real) <= coulomb.real:
            return q, 0j
        end = (force - direction * coulomb) / viscous
        rate = viscous / mass
        later = end + (v - end) * np.exp(-rate * left)
        if v.real == 0 or later.real * direction >= 0:
            return q + end * left + (v - end) / rate * (1 - np.exp(-rate * left)), later
        until = np.log((v - end) / (-end)) / rate
        q += end * until + (v - end) / rate * (1 - np.exp(-rate * until))
        v, left = 0j, left - until
    raise AssertionError("more events in a sample than there can be")
