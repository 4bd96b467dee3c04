"""Laws with one loop: PID, impedance, state feedback, and the position mode of Dynamixel."""

import math

import sympy

from axisid.modeling.quantities import MEASURED_POSITION, PERIOD, REFERENCE, Amount

from .control import ControlLaw, Memory, gain
from .control_blocks import Block, added, chosen, difference, in_range
from .velocity_and_anti_windup import (
    commanded,
    formed_velocity,
    joined,
    ready_law,
    smoothed,
    without_zeros,
)

_ERROR = REFERENCE - MEASURED_POSITION


def pid(
    *,
    kp: float,
    period: float,
    ki: float = 0.0,
    kd: float = 0.0,
    filter_time: float = 0.0,
    derivative_of: str = "error",
    feed_forward: Amount | None = None,
    anti_windup: str = "none",
    tracking_time: float | None = None,
) -> ControlLaw:
    """Return a PID in parallel form.

    ``u = kp e + ki I + kd D + feed_forward`` with ``e = r - q``, ``I[k+1] = I[k] + T e[k]`` and
    ``D[k] = (Tf D[k-1] + e[k] - e[k-1]) / (Tf + T)``. With ``derivative_of="position"``, D has
    ``-q`` instead of e.

    Parameters
    ----------
    kp : float
        Control over position: N m/rad, V/m.
    period : float
        Sampling period T, s.
    ki : float
        Control over position and time: N m/(rad s).
    kd : float
        Control over velocity: N m s/rad.
    filter_time : float
        Tf, time constant of the derivative's filter, s; 0 for plain differences.
    derivative_of : str
        Signal of the derivative: ``error`` or ``position``.
    feed_forward : Signal or expression, optional
        Signal added to the control, in its unit.
    anti_windup : str
        Behaviour of the integral at the drive's limit. ``none``: no change. ``clamping``: the
        integral stands still where it would drive the control further beyond the limit.
        ``back_calculation``: ``T (u_limited - u) / tracking_time`` is added to ``ki I``.
    tracking_time : float, optional
        Time constant of back-calculation, s; ``kp / ki`` by default.

    Notes
    -----
    moteus: divide its ``kp`` [Nm/turn], ``kd`` [Nm/(turn/s)] and ``ki`` [Nm/(turn s)] by 2 pi.
    TwinCAT's D-T1 has the filter time ``Tv / n``.

    References
    ----------
    [AstromHagglund2006]_, chapter 3, implicit differences; [Pieper2024]_.
    """
    derivative, own = _derivative(derivative_of, filter_time, "kd", kd)
    output = gain("kp") * _ERROR + gain("kd") * derivative.value + added(feed_forward)
    if ki:
        output += gain("ki") * gain("integral")
    return ready_law(
        _name(ki, kd),
        period=period,
        output=output,
        gains={"kp": kp, **own, **without_zeros({"ki": ki})},
        memory=derivative.memory,
        error=_ERROR,
        time=gain("kp") / gain("ki"),
        anti_windup=anti_windup,
        tracking_time=tracking_time,
    )


def pid_ideal(
    *,
    k: float,
    period: float,
    ti: float | None = None,
    td: float = 0.0,
    filter_time: float = 0.0,
    derivative_of: str = "error",
    feed_forward: Amount | None = None,
    anti_windup: str = "none",
    tracking_time: float | None = None,
) -> ControlLaw:
    """Return a PID in ideal form, also called standard or ISA.

    ``u = k (e + I / ti + td D) + feed_forward``, with e, I and D of `pid`.

    Parameters
    ----------
    k : float
        Control over position: N m/rad, V/m.
    period : float
        Sampling period T, s.
    ti : float, optional
        Integral time, s; None for no integral.
    td : float
        Derivative time, s.
    filter_time, derivative_of, feed_forward, anti_windup
        As in `pid`.
    tracking_time : float, optional
        Time constant of back-calculation, s; `ti` by default.

    Notes
    -----
    TwinCAT's PID: ``Kp``, ``Tn``, ``Tv`` and ``Td`` are `k`, `ti`, `td` and `filter_time`.

    References
    ----------
    [AstromHagglund2006]_, equation (3.1).
    """
    in_range(td, "the derivative time td")
    derivative, own = _derivative(derivative_of, filter_time, "td", td)
    gains = {"k": k, **own}
    output = gain("k") * (_ERROR + gain("td") * derivative.value) + added(feed_forward)
    if ti is not None:
        gains["ti"] = in_range(ti, "the integral time ti", positive=True)
        output += gain("k") * gain("integral") / gain("ti")
    return ready_law(
        f"{_name(0 if ti is None else 1, td)}, ideal form",
        period=period,
        output=output,
        gains=gains,
        memory=derivative.memory,
        error=_ERROR,
        time=gain("ti"),
        anti_windup=anti_windup,
        tracking_time=tracking_time,
    )


def _derivative(
    of: str, filter_time: float, name: str, value: float
) -> tuple[Block, dict[str, float]]:
    """Return the filtered derivative that a PID uses, and its gains by name.

    The derivative is 0, with no gains, if its gain is 0.

    Parameters
    ----------
    of : str
        Signal of the derivative: ``error``, or ``position`` with the opposite sign.
    filter_time : float
        Time constant of the filter, s; 0 for none.
    name : str
        Name of the derivative's gain.
    value : float
        Value of the derivative's gain.
    """
    chosen(of, "derivative_of", ("error", "position"))
    in_range(filter_time, "the filter time of a derivative")
    if not value:
        return Block(sympy.S.Zero), {}
    signal = _ERROR if of == "error" else -MEASURED_POSITION
    slope = difference(signal, name="last", start=signal)
    formed = smoothed(slope, filter_time, "filter_time", "derivative")
    return formed, {name: value, **without_zeros({"filter_time": filter_time})}


def _name(integral: float, derivative: float) -> str:
    """Return ``P``, ``PI``, ``PD`` or ``PID``, according to the gains that are not 0."""
    return f"P{'I' if integral else ''}{'D' if derivative else ''}"


def impedance(
    *,
    kp: float,
    kd: float,
    period: float,
    velocity: str = "difference",
    velocity_filter: float = 0.0,
    pll_bandwidth: float = 0.0,
    reference_velocity: Amount | None = None,
    feed_forward: Amount | None = None,
) -> ControlLaw:
    """Return an impedance law: a virtual spring and damper between reference and axis.

    ``u = kp (r - q) + kd (dr - v) + feed_forward``.

    Parameters
    ----------
    kp : float
        Stiffness, control over position: N m/rad.
    kd : float
        Damping, control over velocity: N m s/rad.
    period : float
        Sampling period, s.
    velocity, velocity_filter, pll_bandwidth
        Formation of v in the drive, as in `cascade_p_pi`.
    reference_velocity : Signal or expression, optional
        Recorded column for dr, instead of the difference of the reference.
    feed_forward : Signal or expression, optional
        Signal added to the control, in its unit.

    Notes
    -----
    moteus: multiply its ``kp`` [Nm/turn] and ``kd`` [Nm/(turn/s)] by their scales in the command,
    and divide them by 2 pi. The MIT mode of T-Motor's AK drives has the gains in Nm/rad and
    Nm s/rad; its registers of 12 bits are ``kp / 500 x 4095`` and ``kd / 5 x 4095``.

    References
    ----------
    [Hogan1985]_; [Pieper2024]_.
    """
    formed, own = formed_velocity(velocity, velocity_filter, pll_bandwidth)
    reference_rate = commanded("velocity", reference_velocity)
    spring = gain("kp") * _ERROR
    damper = gain("kd") * (reference_rate.value - formed.value)
    return ready_law(
        "impedance",
        period=period,
        output=spring + damper + added(feed_forward),
        gains={"kp": kp, "kd": kd, **own},
        memory=joined(formed.memory, reference_rate.memory),
    )


def state_feedback(
    *,
    k_position: float,
    k_velocity: float,
    period: float,
    k_reference: float | None = None,
    k_integral: float = 0.0,
    velocity: str = "difference",
    velocity_filter: float = 0.0,
    pll_bandwidth: float = 0.0,
    feed_forward: Amount | None = None,
    anti_windup: str = "none",
    tracking_time: float | None = None,
) -> ControlLaw:
    """Return a state feedback, as a regulator designed by pole placement or by LQR.

    ``u = k_reference r - k_position q - k_velocity v + k_integral I + feed_forward`` with
    ``I[k+1] = I[k] + T (r[k] - q[k])``.

    Parameters
    ----------
    k_position : float
        Control over position: N m/rad, V/m.
    k_velocity : float
        Control over velocity.
    period : float
        Sampling period T, s.
    k_reference : float, optional
        Control over reference; `k_position` by default, so that an axis without load comes to rest
        at its reference.
    k_integral : float
        Control over position and time.
    velocity, velocity_filter, pll_bandwidth
        Formation of v in the drive, as in `cascade_p_pi`.
    feed_forward : Signal or expression, optional
        Signal added to the control, in its unit.
    anti_windup, tracking_time
        As in `pid`; the tracking time is ``k_position / k_integral`` by default.

    References
    ----------
    [FranklinPowellWorkman1998]_, chapter 8.
    """
    formed, own = formed_velocity(velocity, velocity_filter, pll_bandwidth)
    gains = {"k_position": k_position, "k_velocity": k_velocity, **own}
    if k_reference is None:
        output = gain("k_position") * _ERROR
    else:
        gains["k_reference"] = k_reference
        output = gain("k_reference") * REFERENCE - gain("k_position") * MEASURED_POSITION
    output += added(feed_forward) - gain("k_velocity") * formed.value
    if k_integral:
        gains["k_integral"] = k_integral
        output += gain("k_integral") * gain("integral")
    return ready_law(
        "state feedback",
        period=period,
        output=output,
        gains=gains,
        memory=formed.memory,
        error=_ERROR,
        time=gain("k_position") / gain("k_integral"),
        anti_windup=anti_windup,
        tracking_time=tracking_time,
    )


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
    """Return the position mode of Dynamixel X servos: PID and feed-forward, from counts to PWM.

    ``u = p/128 e + i/65536 I + d/16 (e[k] - e[k-1]) + ff1/4 (r[k] - r[k-1])
    + ff2/4 (r[k] - 2 r[k-1] + r[k-2])`` with the error ``e = counts/(2 pi) (r - q)`` and the
    reference r in counts, and ``I[k+1] = I[k] + e[k]``.

    Parameters
    ----------
    p, i, d : float
        Registers 84, 82 and 80: Position P, I and D Gain.
    period : float
        Sampling period of the servo's control, s. It is contained in the factors of the registers.
    ff1, ff2 : float
        Registers 90 and 88: Feedforward 1st and 2nd Gain.
    counts : float
        Counts of the encoder per turn of the axis, which must be rotary.
    anti_windup : str
        ``none``, ``clamping`` or ``back_calculation`` with the gain ``65536 / i``. The servo has an
        anti-windup, but the manual does not state its gain.

    Notes
    -----
    The control is in units of the register Goal PWM, 0.113 % each: the drive's limit is 885. The
    PWM is a voltage, so the force at a given control falls with the speed.

    References
    ----------
    [Robotis2018]_, sections 2.4.26 and following.
    """
    gains = {"p": p, **without_zeros({"i": i, "d": d, "ff1": ff1, "ff2": ff2})}
    counts_per_rad = in_range(counts, "the counts of a turn", positive=True) / (2 * math.pi)
    error, reference = counts_per_rad * _ERROR, counts_per_rad * REFERENCE
    # Position and reference at the last samples, as symbols in rad and as terms in counts.
    before = [sympy.Symbol(name, real=True) for name in ("q1", "reference1", "reference2")]
    q1, r1, r2 = (counts_per_rad * symbol for symbol in before)
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
    # Keep the memories that occur; reference2 is updated from reference1.
    used = set(output.free_symbols)
    if before[2] in used:
        used.add(before[1])
    kept = [each for each in memory if each.symbol in used]
    if i:
        output += gain("i") / 65536 * gain("integral")
    return ready_law(
        "Dynamixel position",
        period=period,
        output=output,
        gains=gains,
        memory=tuple(kept),
        error=error / PERIOD,
        time=PERIOD,
        anti_windup=anti_windup,
    )
