"""A position loop over a velocity loop with an integral: what most drives run."""

import math

from axisid.modeling.declaration import ControlLaw, gain
from axisid.modeling.quantities import MEASURED_POSITION, REFERENCE, number, within

from .arguments import Amount, added, in_range
from .velocity import commanded, formed_velocity, joined, without_zeros
from .windup import with_integral


def cascade_p_pi(
    *,
    kp: float,
    kv: float,
    period: float,
    tn: float | None = None,
    velocity: str = "difference",
    velocity_filter: float = 0.0,
    pll_bandwidth: float = 0.0,
    velocity_feed_forward: float = 0.0,
    acceleration_feed_forward: float = 0.0,
    reference_velocity: Amount | None = None,
    reference_acceleration: Amount | None = None,
    feed_forward: Amount | None = None,
    speed_limit: float = math.inf,
    anti_windup: str = "none",
    tracking_time: float | None = None,
) -> ControlLaw:
    """Position loop (P) over a velocity loop (PI), with feed-forward.

    ``w = kp (r - q) + f_v dr``, within the speed limit; ``e = w - v``;
    ``u = kv (e + I) + f_a ddr + feed_forward``, and ``I[k+1] = I[k] + T e[k] / tn``.

    Parameters
    ----------
    kp : float
        Position gain, 1/s.
    kv : float
        Velocity gain, control over velocity: A/(rad/s), V/(m/s).
    period : float
        Sampling period T, s.
    tn : float, optional
        Integral time, s; no integral without it.
    velocity : str
        How the drive forms v: ``difference`` of two encoder positions, ``averaged`` over two of
        these, ``pll``, a phase-locked loop, or ``ideal``, a sensor of its own that no log has.
    velocity_filter : float
        Time constant of a low-pass of v, s; 0 for none.
    pll_bandwidth : float
        Of the phase-locked loop, rad/s.
    velocity_feed_forward : float
        f_v, 1 for the whole reference velocity dr.
    acceleration_feed_forward : float
        f_a, control over acceleration: A/(rad/s^2).
    reference_velocity, reference_acceleration : Signal or expression, optional
        Recorded columns for dr and ddr, in place of differences of the reference.
    feed_forward : Signal or expression, optional
        What is added to the control, in its unit: a recorded torque command.
    speed_limit : float
        Of w, m/s or rad/s.
    anti_windup : str
        What the integral does at the drive's limit: ``none``, ``clamping``, it stands still where
        it would drive the control further beyond; ``back_calculation``, it also gets
        ``T (u_limited - u) / (kv tracking_time)``.
    tracking_time : float, optional
        Of back-calculation, s; `tn` by default.

    Notes
    -----
    Gains of makers, with the drive's control in Nm or A:

    ========================  ============================================  =================
    maker                     theirs                                        here
    ========================  ============================================  =================
    ODrive                    ``pos_gain`` [1/s]                            ``kp``
    ODrive                    ``vel_gain`` [Nm/(turn/s)] / (2 pi)           ``kv``, Nm s/rad
    ODrive                    ``vel_gain / vel_integrator_gain``            ``tn``, s
    Beckhoff EP7047           Kp velocity [0.1 mA/(rad/s)] x 1e-4           ``kv``, A s/rad
    Beckhoff EP7047           Tn [0.01 ms] x 1e-5                           ``tn``, s
    SimpleFOC                 ``P_angle.P``, ``PID_velocity.P``             ``kp``, ``kv``
    SimpleFOC                 ``PID_velocity.P / PID_velocity.I``           ``tn``, s
    ========================  ============================================  =================

    SimpleFOC integrates by trapezoids, half a sample earlier.

    References
    ----------
    [ODrive2023]_, [Beckhoff2023]_, [Skuric2022]_; [AstromHagglund2006]_ for anti-windup.
    """
    formed, own = formed_velocity(velocity, velocity_filter, pll_bandwidth)
    advance = {
        "velocity_feed_forward": velocity_feed_forward,
        "acceleration_feed_forward": acceleration_feed_forward,
    }
    gains = {"kp": kp, "kv": kv, **own, **without_zeros(advance)}
    along, further = commanded("velocity", reference_velocity), added(feed_forward)
    wanted = gain("kp") * (REFERENCE - MEASURED_POSITION)
    memory = [formed.memory]
    if velocity_feed_forward:
        wanted += gain("velocity_feed_forward") * along.value
        memory.append(along.memory)
    if acceleration_feed_forward:
        accelerated = commanded("acceleration", reference_acceleration)
        further += gain("acceleration_feed_forward") * accelerated.value
        memory.append(accelerated.memory)
    if number(speed_limit, "the speed limit of a law", finite=False) != math.inf:
        gains["speed_limit"] = in_range(speed_limit, "the speed limit of a law", positive=True)
        wanted = within(wanted, gain("speed_limit"))
    error = wanted - formed.value
    corrected = error
    if tn is not None:
        gains["tn"] = in_range(tn, "the integral time tn", positive=True)
        corrected += gain("integral") / gain("tn")
    output = gain("kv") * corrected + further
    return with_integral(
        "cascade P-P" if tn is None else "cascade P-PI",
        period=period,
        output=output,
        gains=gains,
        memory=joined(*memory),
        error=error,
        time=gain("tn"),
        anti_windup=anti_windup,
        tracking_time=tracking_time,
    )
