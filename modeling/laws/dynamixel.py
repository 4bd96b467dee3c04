"""The position mode of Dynamixel X servos, by the registers of its control table."""

import math

import sympy

from axisid.modeling.declaration import ControlLaw, Memory, gain
from axisid.modeling.quantities import MEASURED_POSITION, PERIOD, REFERENCE

from .arguments import in_range
from .velocity import without_zeros
from .windup import with_integral


def dynamixel_position(
    *,
    p: float,
    period: float,
    i: float = 0.0,
    d: float = 0.0,
    ff1: float = 0.0,
    ff2: float = 0.0,
    counts: float = 4096.0,
    anti_windup: str = "none",
) -> ControlLaw:
    """Position mode of Dynamixel X servos: PID and feed-forward in counts, a PWM out.

    ``u = p/128 e + i/65536 I + d/16 (e[k] - e[k-1]) + ff1/4 (r[k] - r[k-1])
    + ff2/4 (r[k] - 2 r[k-1] + r[k-2])`` with the error ``e = counts/(2 pi) (r - q)`` and the
    reference r in counts, and ``I[k+1] = I[k] + e[k]``.

    Parameters
    ----------
    p, i, d : float
        Registers 84, 82 and 80: Position P, I and D Gain.
    period : float
        Sampling period of the servo's control, s. The factors of the registers include it, so that
        no term has it.
    ff1, ff2 : float
        Registers 90 and 88: Feedforward 1st and 2nd Gain.
    counts : float
        Of the encoder to a turn of the axis, a rotary one.
    anti_windup : str
        ``none``, ``clamping`` or ``back_calculation``, with the gain ``65536 / i``: the servo has
        an anti-windup of which the manual does not say the gain.

    Notes
    -----
    The control is in units of the register Goal PWM, of 0.113 %: the drive's limit is 885, and its
    gain is that of a voltage, which falls with the speed.

    References
    ----------
    [Robotis2018]_, sections 2.4.26 and following.
    """
    registers = {"i": i, "d": d, "ff1": ff1, "ff2": ff2}
    gains = {"p": p, **without_zeros(registers)}
    by_count = in_range(counts, "the counts of a turn", positive=True) / (2 * math.pi)
    error, reference = by_count * (REFERENCE - MEASURED_POSITION), by_count * REFERENCE
    before = [sympy.Symbol(name, real=True) for name in ("q1", "reference1", "reference2")]
    q1, r1, r2 = (by_count * symbol for symbol in before)
    terms = {
        "p": error / 128,
        "d": (error - (r1 - q1)) / 16,
        "ff1": (reference - r1) / 4,
        "ff2": (reference - 2 * r1 + r2) / 4,
    }
    output = sympy.Add(*(gain(name) * term for name, term in terms.items() if name in gains))
    memory = [
        Memory("q1", following=MEASURED_POSITION, start=MEASURED_POSITION),
        Memory("reference1", following=REFERENCE, start=REFERENCE),
        Memory("reference2", following=before[1], start=REFERENCE),
    ]
    read = output.free_symbols | ({before[1]} if before[2] in output.free_symbols else set())
    kept = [each for each in memory if each.symbol in read]
    output += gain("i") / 65536 * gain("integral") if i else 0
    return with_integral(
        "Dynamixel position",
        period=period,
        output=output,
        gains=gains,
        memory=tuple(kept),
        error=error / PERIOD,
        time=PERIOD,
        anti_windup=anti_windup,
    )
