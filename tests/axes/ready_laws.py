"""Every ready law on one axis, with gains that close its loop well."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache

from axisid import build, load_axis
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import (
    ControlLaw,
    cascade_p_pi,
    cascade_pd_averaged,
    dynamixel_position,
    impedance,
    pid,
    pid_ideal,
    state_feedback,
)

PERIOD = 1e-3
KP, KV = 160.18, 243.45

#: By a name that says what each has.
LAWS: Mapping[str, Callable[[], ControlLaw]] = {
    "cascade_pd_averaged": lambda: cascade_pd_averaged(kp=KP, kv=KV, period=PERIOD),
    "cascade_p_pi": lambda: cascade_p_pi(kp=60.0, kv=KV, tn=0.03, period=PERIOD),
    "cascade_p_pi, feed-forward": lambda: cascade_p_pi(
        kp=40.0,
        kv=KV,
        tn=0.03,
        period=PERIOD,
        velocity="averaged",
        velocity_feed_forward=0.9,
        acceleration_feed_forward=2.0,
    ),
    "cascade_p_pi, phase-locked loop": lambda: cascade_p_pi(
        kp=40.0, kv=KV, tn=0.05, period=PERIOD, velocity="pll", pll_bandwidth=500.0
    ),
    "cascade_p_pi, filter and speed limit": lambda: cascade_p_pi(
        kp=60.0, kv=KV, tn=0.05, period=PERIOD, velocity_filter=2e-3, speed_limit=0.16
    ),
    "cascade_p_pi, clamped": lambda: cascade_p_pi(
        kp=60.0, kv=KV, tn=0.03, period=PERIOD, anti_windup="clamping"
    ),
    "cascade_p_pi, phase-locked loop, filter, clamped": lambda: cascade_p_pi(
        kp=40.0,
        kv=KV,
        tn=0.05,
        period=PERIOD,
        velocity="pll",
        pll_bandwidth=500.0,
        velocity_filter=1e-3,
        anti_windup="clamping",
    ),
    "cascade_p_pi, back-calculation": lambda: cascade_p_pi(
        kp=60.0,
        kv=KV,
        tn=0.03,
        period=PERIOD,
        anti_windup="back_calculation",
        tracking_time=0.02,
    ),
    "pid": lambda: pid(kp=39000.0, ki=2e5, kd=243.0, filter_time=1e-3, period=PERIOD),
    "pid of the position, clamped": lambda: pid(
        kp=20000.0,
        ki=2e5,
        kd=243.0,
        period=PERIOD,
        derivative_of="position",
        anti_windup="clamping",
    ),
    "pid_ideal": lambda: pid_ideal(k=39000.0, ti=0.2, td=0.006, filter_time=1e-3, period=PERIOD),
    "impedance": lambda: impedance(kp=30000.0, kd=243.0, period=PERIOD),
    "state_feedback": lambda: state_feedback(
        k_position=39000.0, k_velocity=243.0, k_integral=2e5, period=PERIOD
    ),
    "dynamixel_position": lambda: dynamixel_position(
        p=7000.0, i=2000.0, d=6000.0, ff1=30.0, ff2=20.0, period=PERIOD
    ),
}


@cache
def with_law(name: str, limit: float = 10.0) -> GeneratedAxis:
    """The paper's axis under a ready law, in metres; its drive saturates at a limit, V."""
    axis = load_axis("emps2015")
    law = LAWS[name]()
    drive = replace(axis.drive, limit=limit)
    return build(replace(axis, name="ready", control=law, drive=drive))
