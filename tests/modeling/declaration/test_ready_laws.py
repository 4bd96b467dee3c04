"""Ready laws give, sample by sample, what difference equations written down by hand give.

Blocks of laws give what scipy.signal, or a loop written by hand, gives of the same samples.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from axisid import Signal, build, load_axis
from axisid.codegen.generated_axes import law_functions
from axisid.control import (
    MEASURED_POSITION,
    REFERENCE,
    Block,
    ControlLaw,
    cascade_p_pi,
    dynamixel_position,
    gain,
    low_pass,
    notch,
    pid,
    pid_ideal,
    rate_limit,
    state_feedback,
)
from axisid.estimation.law_replay import LawInputs, control_along, state_at_rest
from axisid.estimation.law_replay.replay import run_law
from axisid.support.arrays import Array
from tests.axes.ready_laws import KP, KV, LAWS, PERIOD, with_law
from tests.refusals import refused

T = PERIOD


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _signals() -> tuple[Array, Array]:
    """A reference, and a position that follows it with an error of some volts, both from 0."""
    rng, time = np.random.default_rng(4), T * np.arange(600)
    reference = 0.1 * (1 - np.cos(9 * time))
    lag = 0.1 * (1 - np.cos(9 * np.maximum(time - 2e-3, 0)))
    return reference, lag + 2e-6 * np.cumsum(rng.normal(size=600)) * (time > 0)


def _cascade_pd_averaged(r: Array, q: Array, _: float) -> list[float]:
    control = []
    for k in range(len(r)):
        before = q[max(k - 2, 0)]
        control.append(KV * (KP * (r[k] - q[k]) - (q[k] - before) / (2 * T)))
    return control


def _cascade_p_pi(
    r: Array,
    q: Array,
    limit: float,
    *,
    kp: float = 60.0,
    tn: float = 0.03,
    ahead: float = 0.0,
    accelerated: float = 0.0,
    averaged: bool = False,
    smooth: float = 0.0,
    most: float = math.inf,
    windup: str = "",
    tracking: float = 0.02,
    bandwidth: float = 0.0,
) -> list[float]:
    """ODrive's order: the integral is used, then advanced by the error of this sample."""
    control, total, filtered = [], 0.0, 0.0
    place, speed = q[0], 0.0
    for k in range(len(r)):
        q1, q2, r1, r2 = (x[max(k - back, 0)] for x, back in ((q, 1), (q, 2), (r, 1), (r, 2)))
        velocity = (q[k] - q2) / (2 * T) if averaged else (q[k] - q1) / T
        if bandwidth:
            place += T * speed
            off = q[k] - place
            place += T * 2 * bandwidth * off
            speed += T * 0.25 * (2 * bandwidth) ** 2 * off
            velocity = speed
        if smooth:
            share = smooth / (smooth + T)
            filtered = share * filtered + (1 - share) * velocity
            velocity = filtered
        wanted = _clip(kp * (r[k] - q[k]) + ahead * (r[k] - r1) / T, most)
        error = wanted - velocity
        u = KV * (error + total) + accelerated * ((r[k] - r1) / T - (r1 - r2) / T) / T
        control.append(u)
        missing = _clip(u, limit) - u
        held = windup == "clamping" and missing * error < 0
        total += 0.0 if held else T * error / tn
        total += T * missing / (KV * tracking) if windup == "tracking" else 0.0
    return control


def _pid(
    r: Array,
    q: Array,
    limit: float,
    *,
    kp: float,
    ki: float,
    kd: float,
    smooth: float = 0.0,
    of_position: bool = False,
    clamped: bool = False,
) -> list[float]:
    control, total, rate = [], 0.0, 0.0
    for k in range(len(r)):
        r1, q1 = r[max(k - 1, 0)], q[max(k - 1, 0)]
        error, change = r[k] - q[k], -(q[k] - q1) + (0.0 if of_position else r[k] - r1)
        share = smooth / (smooth + T)
        rate = share * rate + (1 - share) * change / T
        u = kp * error + total + kd * rate
        control.append(u)
        if not (clamped and abs(u) > limit and u * error > 0):
            total += ki * T * error
    return control


def _impedance(r: Array, q: Array, _: float) -> list[float]:
    rates = [np.diff(x, prepend=x[0]) / T for x in (r, q)]
    return list(30000.0 * (r - q) + 243.0 * (rates[0] - rates[1]))


def _state_feedback(r: Array, q: Array, _: float) -> list[float]:
    total = T * np.concatenate([[0.0], np.cumsum(r - q)[:-1]])
    return list(39000.0 * (r - q) - 243.0 * np.diff(q, prepend=q[0]) / T + 2e5 * total)


def _dynamixel(r: Array, q: Array, _: float) -> list[float]:
    r, q = (np.asarray(x) * 4096 / (2 * math.pi) for x in (r, q))
    error = r - q
    total = np.concatenate([[0.0], np.cumsum(error)[:-1]])
    first = np.diff(r, prepend=r[0])
    second = np.diff(first, prepend=0.0)
    rate = np.diff(error, prepend=error[0])
    parts = (7000 / 128 * error, 2000 / 65536 * total, 6000 / 16 * rate)
    return list(sum(parts) + 30 / 4 * first + 20 / 4 * second)


BY_HAND: dict[str, Callable[[Array, Array, float], list[float]]] = {
    "cascade_p_pi, phase-locked loop, filter, clamped": lambda r, q, limit: _cascade_p_pi(
        r, q, limit, kp=40.0, tn=0.05, bandwidth=500.0, smooth=1e-3, windup="clamping"
    ),
    "cascade_pd_averaged": _cascade_pd_averaged,
    "cascade_p_pi": _cascade_p_pi,
    "cascade_p_pi, feed-forward": lambda r, q, limit: _cascade_p_pi(
        r, q, limit, kp=40.0, ahead=0.9, accelerated=2.0, averaged=True
    ),
    "cascade_p_pi, phase-locked loop": lambda r, q, limit: _cascade_p_pi(
        r, q, limit, kp=40.0, tn=0.05, bandwidth=500.0
    ),
    "cascade_p_pi, filter and speed limit": lambda r, q, limit: _cascade_p_pi(
        r, q, limit, tn=0.05, smooth=2e-3, most=0.16
    ),
    "cascade_p_pi, clamped": lambda r, q, limit: _cascade_p_pi(r, q, limit, windup="clamping"),
    "cascade_p_pi, back-calculation": lambda r, q, limit: _cascade_p_pi(
        r, q, limit, windup="tracking"
    ),
    "pid": lambda r, q, limit: _pid(r, q, limit, kp=39000.0, ki=2e5, kd=243.0, smooth=1e-3),
    "pid of the position, clamped": lambda r, q, limit: _pid(
        r, q, limit, kp=20000.0, ki=2e5, kd=243.0, of_position=True, clamped=True
    ),
    "pid_ideal": lambda r, q, limit: _pid(
        r, q, limit, kp=39000.0, ki=39000.0 / 0.2, kd=39000.0 * 0.006, smooth=1e-3
    ),
    "impedance": _impedance,
    "state_feedback": _state_feedback,
    "dynamixel_position": _dynamixel,
}


@pytest.mark.parametrize("name", BY_HAND)
def test_a_ready_law_is_its_difference_equation(name: str) -> None:
    reference, position = _signals()
    limit = float(np.median(np.abs(BY_HAND[name](reference, position, np.inf))))
    axis = with_law(name, limit)
    ticks = LawInputs.at_samples(reference, position, np.zeros_like(position))
    control = control_along(axis, ticks, state_at_rest(axis, ticks))
    wanted = np.array(BY_HAND[name](reference, position, limit))
    beyond = np.abs(wanted) > limit
    assert 0.05 < beyond.mean() < 0.95  # so that windup shows
    np.testing.assert_allclose(control, np.clip(wanted, -limit, limit), atol=1e-9 * limit)


Making = Callable[[str], ControlLaw]
#: Ready laws with an integral, by what it does at the limit.
INTEGRATING: dict[str, Making] = {
    "cascade_p_pi": lambda what: cascade_p_pi(
        kp=61.3, kv=KV, tn=0.031, period=T, anti_windup=what, speed_limit=0.16
    ),
    "cascade_p_pi, averaged": lambda what: cascade_p_pi(
        kp=41.7,
        kv=KV,
        tn=0.03,
        period=T,
        anti_windup=what,
        velocity="averaged",
        velocity_filter=1e-3,
        velocity_feed_forward=0.9,
        acceleration_feed_forward=-2.1,
    ),
    "cascade_p_pi, phase-locked loop": lambda what: cascade_p_pi(
        kp=40.0,
        kv=-KV,
        tn=0.05,
        period=T,
        anti_windup=what,
        velocity="pll",
        pll_bandwidth=500.0,
    ),
    "cascade_p_pi, ideal": lambda what: cascade_p_pi(
        kp=40.0, kv=KV, tn=0.05, period=T, anti_windup=what, velocity="ideal"
    ),
    "pid": lambda what: pid(
        kp=39000.0, ki=2.1e5, kd=243.0, filter_time=1e-3, period=T, anti_windup=what
    ),
    "pid of the position": lambda what: pid(
        kp=-39000.0, ki=-2.1e5, kd=-243.0, period=T, derivative_of="position", anti_windup=what
    ),
    "pid_ideal": lambda what: pid_ideal(k=39000.0, ti=0.21, td=0.006, period=T, anti_windup=what),
    "state_feedback": lambda what: state_feedback(
        k_position=39000.0, k_velocity=243.0, k_integral=2.1e5, period=T, anti_windup=what
    ),
    "state_feedback, averaged": lambda what: state_feedback(
        k_position=39000.0,
        k_velocity=243.0,
        k_integral=2.1e5,
        period=T,
        anti_windup=what,
        velocity="averaged",
    ),
    "dynamixel_position": lambda what: dynamixel_position(
        p=7000.0, i=2000.0, d=6000.0, ff1=30.0, ff2=20.0, period=T, anti_windup=what
    ),
}


def _run(law: ControlLaw, limit: float) -> tuple[Array, Array]:
    """What a law remembers after each sample, and its output."""
    reference, position = _signals()
    functions = law_functions(law, ())
    start = functions["law_start"](reference[0], position[0]).full().ravel()
    limits, gains = np.full(len(position), limit), np.array([[*law.gains.values()]])
    velocity = np.gradient(position, T)
    return run_law(functions["law_step"], start, (reference, position, velocity, limits, gains))


@pytest.mark.parametrize("name", INTEGRATING)
@pytest.mark.parametrize("anti_windup", ["clamping", "back_calculation"])
def test_anti_windup_does_nothing_where_the_limit_is_not_reached(
    name: str, anti_windup: str
) -> None:
    """To the last bit, as the output within the limit is then the output itself."""
    memory, output = _run(INTEGRATING[name]("none"), math.inf)
    for limit in (math.inf, 1.001 * float(np.abs(output).max())):
        held, limited = _run(INTEGRATING[name](anti_windup), limit)
        np.testing.assert_array_equal(held, memory)
        np.testing.assert_array_equal(limited, output)


test_contradictions_have_a_sentence = refused(
    ("law", "", make)
    for make in [
        lambda: cascade_p_pi(kp=1.0, kv=1.0, tn=0.0, period=T),
        lambda: cascade_p_pi(kp=1.0, kv=1.0, period=T, velocity="exact"),
        lambda: cascade_p_pi(kp=1.0, kv=1.0, period=T, velocity="pll"),
        lambda: cascade_p_pi(kp=1.0, kv=1.0, period=T, pll_bandwidth=9.0),
        lambda: cascade_p_pi(kp=1.0, kv=1.0, period=T, anti_windup="clamping"),
        lambda: pid(kp=1.0, ki=1.0, period=T, tracking_time=0.1),
        lambda: pid(kp=1.0, ki=1.0, period=T, anti_windup="limit"),
        lambda: pid(kp=1.0, kd=1.0, period=T, filter_time=-1.0),
        lambda: pid(kp=1.0, kd=1.0, period=T, derivative_of="r"),
        lambda: pid_ideal(k=1.0, ti=-1.0, period=T),
        lambda: low_pass(REFERENCE, time_constant=-1.0),
        lambda: notch(REFERENCE, frequency=50.0, quality=0.0),
        lambda: rate_limit(REFERENCE, rate=0.0),
        lambda: dynamixel_position(p=1.0, counts=0.0, period=T),
    ]
)


def test_a_recorded_column_takes_the_place_of_a_difference() -> None:
    speed, torque = Signal("dr", "m/s"), Signal("u_ff", "V")
    law = cascade_p_pi(
        kp=1.0,
        kv=2.0,
        period=T,
        velocity_feed_forward=1.0,
        reference_velocity=speed,
        feed_forward=torque,
    )
    assert law.signals == {speed.symbol, torque.symbol}
    assert [memory.name for memory in law.memory] == ["q1"]
    assert law.output.coeff(torque.symbol) == 1


@pytest.mark.parametrize("name", LAWS)
def test_laws_that_scale_by_products_of_gains_say_so(name: str) -> None:
    """Of these the law check needs no simulation."""
    remembers = "cascade_p_pi" in name or "clamped" in name
    filtered = name in ("pid", "pid_ideal")
    assert LAWS[name]().is_polynomial == (not (remembers or filtered))


PERIOD, SAMPLES = 1e-3, 400


def _values() -> tuple[Array, Array]:
    rng = np.random.default_rng(1)
    reference, position = (0.3 + 0.1 * np.cumsum(rng.normal(size=SAMPLES)) for _ in range(2))
    return reference, position


def _along(block: Block, **gains: float) -> Array:
    """What a block gives along a reference and a position."""
    law = ControlLaw(
        name="block", period=PERIOD, output=block.value, memory=block.memory, gains=gains
    )
    axis = load_axis("emps2015")
    axis = replace(axis, control=law, drive=replace(axis.drive, limit=np.inf))
    generated = build(axis, native=False)
    ticks = LawInputs.at_samples(*_values(), np.zeros(SAMPLES))
    return control_along(generated, ticks, state_at_rest(generated, ticks))


def test_low_pass_is_a_recursion_of_first_order() -> None:
    _, position = _values()
    block = low_pass(MEASURED_POSITION, time_constant=4e-3, start=MEASURED_POSITION)
    share = PERIOD / (PERIOD + 4e-3)
    rest = signal.lfilter_zi([share], [1, share - 1]) * position[0]
    wanted, _ = signal.lfilter([share], [1, share - 1], position, zi=rest)
    np.testing.assert_allclose(_along(block), wanted, rtol=1e-12)


@pytest.mark.parametrize(("frequency", "quality"), [(80.0, 1.0), (120.0, 5.0)])
def test_notch_is_that_of_scipy(frequency: float, quality: float) -> None:
    reference, _ = _values()
    block = notch(REFERENCE, frequency=frequency, quality=quality, start=REFERENCE)
    above, below = signal.iirnotch(frequency, quality, 1 / PERIOD)
    rest = signal.lfilter_zi(above, below) * reference[0]
    wanted, _ = signal.lfilter(above, below, reference, zi=rest)
    np.testing.assert_allclose(_along(block), wanted, rtol=1e-10)


def test_a_gain_may_be_the_number_of_a_block() -> None:
    plain = notch(REFERENCE, frequency=80.0, start=REFERENCE)
    named = notch(REFERENCE, frequency=gain("f"), start=REFERENCE)
    np.testing.assert_array_equal(_along(plain), _along(named, f=80.0))


def test_rate_limit_follows_no_faster() -> None:
    reference, _ = _values()
    along = _along(rate_limit(REFERENCE, rate=50.0, start=REFERENCE))
    last, wanted = reference[0], []
    for value in reference:
        last += min(max(value - last, -0.05), 0.05)
        wanted.append(last)
    np.testing.assert_allclose(along, wanted, rtol=1e-12)
    assert np.abs(np.diff(along)).max() <= 0.05 + 1e-12
