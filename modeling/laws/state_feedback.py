"""State feedback of position and velocity, with a reference and an integral."""

from axisid.modeling.declaration import ControlLaw, gain
from axisid.modeling.quantities import MEASURED_POSITION, REFERENCE

from .arguments import Amount, added
from .velocity import formed_velocity
from .windup import with_integral


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
    """State feedback, as a regulator designed by poles or by LQR.

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
        Control over reference; `k_position` by default, with which an axis without load stands on
        its reference.
    k_integral : float
        Control over position and time.
    velocity, velocity_filter, pll_bandwidth
        How the drive forms v, as in `cascade_p_pi`.
    feed_forward : Signal or expression, optional
        What is added to the control, in its unit.
    anti_windup, tracking_time
        As in `pid`; the tracking time is ``k_position / k_integral`` by default.

    References
    ----------
    [FranklinPowellWorkman1998]_, chapter 8.
    """
    formed, own = formed_velocity(velocity, velocity_filter, pll_bandwidth)
    gains = {"k_position": k_position, "k_velocity": k_velocity, **own}
    error = REFERENCE - MEASURED_POSITION
    if k_reference is None:
        output = gain("k_position") * error
    else:
        gains["k_reference"] = k_reference
        output = gain("k_reference") * REFERENCE - gain("k_position") * MEASURED_POSITION
    output += added(feed_forward) - gain("k_velocity") * formed.value
    if k_integral:
        gains["k_integral"] = k_integral
        output += gain("k_integral") * gain("integral")
    return with_integral(
        "state feedback",
        period=period,
        output=output,
        gains=gains,
        memory=formed.memory,
        error=error,
        time=gain("k_position") / gain("k_integral"),
        anti_windup=anti_windup,
        tracking_time=tracking_time,
    )
