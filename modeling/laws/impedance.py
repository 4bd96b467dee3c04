"""A virtual spring and damper: what drives of legged robots run."""

from axisid.modeling.declaration import ControlLaw, gain
from axisid.modeling.quantities import MEASURED_POSITION, REFERENCE

from .arguments import Amount, added, positive_among
from .velocity import commanded, formed_velocity, joined


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
    """Virtual spring and damper between reference and axis, with a torque added.

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
        How the drive forms v, as in `cascade_p_pi`.
    reference_velocity : Signal or expression, optional
        Recorded column for dr, in place of the reference's difference.
    feed_forward : Signal or expression, optional
        What is added to the control, in its unit.

    Notes
    -----
    moteus: ``kp`` [Nm/turn] and ``kd`` [Nm/(turn/s)], times their scales of the command, over 2 pi
    are those here. The MIT mode of T-Motor's AK drives has them in Nm/rad and Nm s/rad; its
    registers of 12 bits are ``kp / 500 x 4095`` and ``kd / 5 x 4095``.

    References
    ----------
    [Hogan1985]_; [Pieper2024]_.
    """
    formed, own = formed_velocity(velocity, velocity_filter, pll_bandwidth)
    along = commanded("velocity", reference_velocity)
    spring = gain("kp") * (REFERENCE - MEASURED_POSITION)
    damper = gain("kd") * (along.value - formed.value)
    return ControlLaw(
        name="impedance",
        period=period,
        output=spring + damper + added(feed_forward),
        gains={"kp": kp, "kd": kd, **own},
        memory=joined(formed.memory, along.memory),
        positive=positive_among(own),
    )
