"""The ready-made laws by name, and the cascades, which most drives run.

A cascade is a position loop over a velocity loop. The cascades without an integral include the law
of the paper and the law recovered from the EMPS record.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from axisid.modeling.quantities import MEASURED_POSITION, REFERENCE, Amount, number, within

from .control import ControlLaw, gain
from .control_blocks import added, in_range
from .single_loops import dynamixel_position, impedance, pid, pid_ideal, state_feedback
from .velocity_and_anti_windup import commanded, formed_velocity, joined, ready_law, without_zeros


def cascade_pd(*, kp: float, kv: float, period: float, continuous: bool = False) -> ControlLaw:
    """Return a position loop over a velocity loop, with an ideal velocity sensor.

    ``control = kv (kp (reference - q) - dq)``, evaluated once per period and held.

    Parameters
    ----------
    kp : float
        Position gain, 1/s.
    kv : float
        Velocity gain, control over velocity (V/(m/s)).
    period : float
        Sampling period, s.
    continuous : bool
        Evaluate the law continuously instead of holding its output: the equations as written.

    References
    ----------
    Equations (6) and (7) of [Brunot2015]_.
    """
    law = _cascade("ideal", "ideal velocity", kp=kp, kv=kv, period=period)
    return replace(law, continuous=continuous)


def cascade_pd_averaged(*, kp: float, kv: float, period: float) -> ControlLaw:
    """Return a cascade with averaged encoder velocity, the law of the EMPS drive.

    The velocity is the difference of the means of two successive positions,
    ``(q[k] - q[k-2]) / (2 period)``. The law was recovered from the record of [Janot2019]_: it
    reproduces the recorded control to 0.24 % of the norm of the control.
    """
    return _cascade("averaged", "averaged encoder velocity", kp=kp, kv=kv, period=period)


def cascade_pd_difference(*, kp: float, kv: float, period: float) -> ControlLaw:
    """Return a cascade whose velocity is the difference of two successive encoder positions.

    The velocity is ``(q[k] - q[k-1]) / period``, as in simple drives: it lags by half a sample, and
    is coarse because of the encoder's resolution.
    """
    return _cascade("difference", "encoder difference", kp=kp, kv=kv, period=period)


def _cascade(how: str, description: str, *, kp: float, kv: float, period: float) -> ControlLaw:
    """Return a position loop over a velocity loop, both proportional.

    Parameters
    ----------
    how : str
        Formation of the velocity, as in `formed_velocity`.
    description : str
        Description of the velocity, for the law's name.
    kp, kv : float
        Gains, 1/s and control over velocity.
    period : float
        Sampling period, s.
    """
    formed, _ = formed_velocity(how)
    return ControlLaw(
        name=f"cascade PD, {description}",
        period=period,
        output=gain("kv") * (gain("kp") * (REFERENCE - MEASURED_POSITION) - formed.value),
        gains={"kp": kp, "kv": kv},
        memory=formed.memory,
    )


#: The cascades by name, which differ in how the drive forms the velocity.
CASCADES: Mapping[str, Callable[..., ControlLaw]] = MappingProxyType(
    {law.__name__: law for law in (cascade_pd, cascade_pd_difference, cascade_pd_averaged)}
)


def velocity_variants(law: ControlLaw) -> dict[str, ControlLaw]:
    """Return the variants of a cascade that form the velocity differently, by name of the law.

    The result is empty for a law that is not one of `CASCADES`.
    """
    if set(law.gains) != {"kp", "kv"} or law.continuous or law.delay:
        return {}
    cascades = {name: make(**law.gains, period=law.period) for name, make in CASCADES.items()}
    others = {name: variant for name, variant in cascades.items() if variant.output != law.output}
    return others if len(others) < len(cascades) else {}


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
    """Return a position loop (P) over a velocity loop (PI), with feed-forward.

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
        Integral time, s; None for no integral.
    velocity : str
        Formation of v in the drive: ``difference`` of two encoder positions, ``averaged`` over two
        such differences, ``pll``, a phase-locked loop, or ``ideal``, a separate velocity sensor
        that no log contains.
    velocity_filter : float
        Time constant of a low-pass of v, s; 0 for none.
    pll_bandwidth : float
        Bandwidth of the phase-locked loop, rad/s.
    velocity_feed_forward : float
        f_v, without unit; 1 for full feed-forward of the reference velocity dr.
    acceleration_feed_forward : float
        f_a, control over acceleration: A/(rad/s^2).
    reference_velocity, reference_acceleration : Signal or expression, optional
        Recorded columns for dr and ddr, instead of differences of the reference.
    feed_forward : Signal or expression, optional
        Signal added to the control, in the control's unit, such as a recorded torque command.
    speed_limit : float
        Limit of w, m/s or rad/s.
    anti_windup : str
        Behaviour of the integral at the drive's limit. ``none``: no change. ``clamping``: the
        integral stands still where it would drive the control further beyond the limit.
        ``back_calculation``: ``T (u_limited - u) / (kv tracking_time)`` is added to I.
    tracking_time : float, optional
        Time constant of back-calculation, s; `tn` by default.

    Notes
    -----
    Gains of manufacturers, with the drive's control in Nm or A:

    ========================  ============================================  =================
    manufacturer              manufacturer's gain                           argument
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
    reference_rate, further = commanded("velocity", reference_velocity), added(feed_forward)
    # The commanded velocity, with its feed-forward and its limit.
    wanted = gain("kp") * (REFERENCE - MEASURED_POSITION)
    memory = [formed.memory]
    if velocity_feed_forward:
        wanted += gain("velocity_feed_forward") * reference_rate.value
        memory.append(reference_rate.memory)
    if acceleration_feed_forward:
        accelerated = commanded("acceleration", reference_acceleration)
        further += gain("acceleration_feed_forward") * accelerated.value
        memory.append(accelerated.memory)
    if number(speed_limit, "the speed limit of a law", finite=False) != math.inf:
        gains["speed_limit"] = in_range(speed_limit, "the speed limit of a law", positive=True)
        wanted = within(wanted, gain("speed_limit"))
    # The velocity loop, with an integral if its time is given.
    error = wanted - formed.value
    corrected = error
    if tn is not None:
        gains["tn"] = in_range(tn, "the integral time tn", positive=True)
        corrected += gain("integral") / gain("tn")
    output = gain("kv") * corrected + further
    return ready_law(
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


#: The ready-made laws, by their names in TOML declarations.
LAWS: Mapping[str, Callable[..., ControlLaw]] = MappingProxyType(
    {
        **CASCADES,
        **{
            law.__name__: law
            for law in (
                cascade_p_pi,
                pid,
                pid_ideal,
                impedance,
                state_feedback,
                dynamixel_position,
            )
        },
    }
)
