"""Recorded signals in a loop: held or straight between samples, events where they are or move."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import Coordinate, Parameter, Signal, build, newton, simulate
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import REFERENCE, ControlLaw, gain
from axisid.elements import TIME, Drive, coulomb
from axisid.estimation.simulation import Simulation, twin_record
from axisid.estimation.simulation.twin import trajectory
from axisid.support.arrays import Array
from benchmarks.event_integrator import EventIntegrator
from tests.axes.bodies import body, c, force_law, m, x
from tests.axes.recorded import MOVES, TRUTH, recorded_axis, recorded_values
from tests.estimation.simulation.agreement import LANES, agree, followed_by
from tests.refusals import refuses

T = 1e-3


def free_axis(between: str, *, native: bool = True) -> GeneratedAxis:
    """A mass with dry friction that nothing but a signal pushes: M ddq + Fc sign(dq) = A p."""
    q, p = Coordinate("q"), Signal("p", "N", between)
    mass, friction = Parameter("M", "kg", nominal=1.0), Parameter("Fc", "N", nominal=1.0)
    area = Parameter("A", "1", nominal=1.0)
    nothing = ControlLaw(name="nothing", period=T, output=gain("k") * REFERENCE, gains={"k": 0.0})
    axis = newton(
        f"free_{between}",
        coordinate=q,
        parameters=(mass, friction, area),
        signals=(p,),
        inertia=mass,
        resistance=(friction * sympy.sign(q.velocity), -area * p),
        drive=Drive(gain=1.0),
        control=nothing,
    )
    return build(axis, native=native)


def pushed(
    push: Array,
    velocity: float = 0.0,
    between: str = "linear",
    *,
    native: bool = True,
    substeps: int | None = None,
) -> Simulation:
    axis = free_axis(between, native=native)
    still = np.zeros(len(push))
    given: dict[str, Any] = {"signals": {"p": push}, "start_velocity": velocity}
    return simulate(axis, [2.0, 3.0, 1.0], still, T, substeps=substeps, **given)


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
def test_a_held_signal_jumps_at_its_sample_and_the_motion_with_it(native: bool) -> None:
    time, jump = T * np.arange(300), 100
    push = np.where(np.arange(300) < jump, 2.9, 5.0)
    loop = pushed(push, between="held", native=native)
    moving = np.maximum(time - jump * T, 0.0)
    assert loop.position == pytest.approx((5.0 - 3.0) / 2.0 * moving**2 / 2, abs=1e-13)
    assert loop.acceleration[jump - 1] == 0.0
    assert loop.acceleration[jump] == pytest.approx(1.0, abs=1e-12)
    assert loop.direction_before[jump] == pytest.approx(2.9 / 3.0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
def test_a_reversal_after_a_jump_is_located_within_its_sample(native: bool) -> None:
    """M = 2, Fc = 3: pushed back with 9, it slows at 6 m/s^2 and comes back at 3 m/s^2."""
    time = T * np.arange(200)
    push, jump, speed = np.where(np.arange(200) < 50, 3.0, -9.0), 50, 0.1234
    loop = pushed(push, speed, "held", native=native)  # it coasts: the push is the friction
    since = np.maximum(time - jump * T, 0.0)
    stops = speed / 6.0
    away = speed * np.minimum(since, stops) - 3.0 * np.minimum(since, stops) ** 2
    back = -1.5 * np.maximum(since - stops, 0.0) ** 2
    assert loop.position == pytest.approx(
        speed * jump * T * (time >= jump * T) + speed * time * (time < jump * T) + away + back,
        abs=1e-12,
    )
    assert (stops / T) % 1 > 0.1  # within a sample


def ramped(push: Array, velocity: float) -> tuple[Array, int]:
    """Positions of M = 2, Fc = 3 under a straight push, in closed form, and dips of the velocity.

    In a dip it comes to zero between two samples of one direction.
    """
    q, v, found, dips = 0.0, velocity, [0.0], 0
    for begin, rate in zip(push[:-1], np.diff(push) / T, strict=True):
        t, turned, before = 0.0, False, v
        while t < T:
            now = begin + rate * t
            s = np.sign(v) if v else np.sign(rate if abs(now) <= 3.0 * (1 + 1e-12) else now)
            if v == 0 and now * s < 3.0 * (1 - 1e-12):  # it rests until the push overcomes friction
                t = min(T, t + (3.0 - now * s) / abs(rate)) if rate else T
                continue
            speed = np.polynomial.Polynomial([v, (now - 3.0 * s) / 2, rate / 4])
            zeros = [z.real for z in speed.roots() if abs(z.imag) < 1e-12 and z.real > 1e-9 * T]
            left, turns = T - t, min(zeros, default=np.inf) < T - t
            span = min(zeros) if turns else left
            q, v, t = q + speed.integ()(span), 0.0 if turns else speed(span), t + span
            turned |= turns
        found.append(q)
        dips += turned and before * v > 0
    return np.array(found), dips


def followed(push: Array, velocity: float, *, native: bool) -> Simulation:
    """The same mass under a law without feedback, whose reference is the push, straight too."""
    law = ControlLaw(name="push", period=T, output=REFERENCE, continuous=True)
    made = body(coulomb(c, x), coordinate=x, inertia=m, parameters=(c,), control=law)
    start = {"start": 0.0, "start_velocity": velocity}
    return simulate(build(made, native=native), [2.0, 3.0], push, T, **start)


#: Straight pushes, velocities at the start, and the least number of dips, by name.
PULSES = {
    "any": (np.random.default_rng(3).uniform(-15.0, 15.0, 80), 0.0, 5),
    "early": (np.array([-4.0, 40.0, 3.0]), 2e-4, 1),
    "late": (np.array([-34.0, 10.0, 3.0]), 7.7e-3, 1),
    # leaves rest between two samples
    "from rest": (20.0 * (T * np.arange(200) - 0.3 * T), 0.0, 0),
}


@pytest.mark.parametrize("native", [pytest.param(True, marks=pytest.mark.slow), False])
@pytest.mark.parametrize("run", [pushed, followed], ids=["signal", "law"])
@pytest.mark.parametrize(("push", "velocity", "least"), PULSES.values(), ids=PULSES)
def test_a_pulse_that_turns_the_velocity_back_within_a_sample_is_followed(
    push: Array, velocity: float, least: int, run: Callable[..., Simulation], native: bool
) -> None:
    position, dips = ramped(push, velocity)
    loop = run(push, velocity, native=native)
    assert dips >= least
    assert loop.position == pytest.approx(position, abs=1e-13)
    rests = (loop.mode == 0) & (np.abs(push) < 3.0)
    assert loop.direction[rests] == pytest.approx(push[rests] / 3.0, abs=1e-12)
    rests[0] = False  # nothing was before it
    assert loop.direction_before[rests] == pytest.approx(push[rests] / 3.0, abs=1e-12)


@pytest.mark.parametrize("native", [True, False])
@pytest.mark.parametrize("name", PULSES)
def test_a_pulse_is_followed_in_steps_within_a_sample(name: str, native: bool) -> None:
    """Most steps then have no event, and one after another begins at rest or in a dip."""
    push, velocity, _ = PULSES[name]
    loop = pushed(push, velocity, native=native, substeps=4)
    assert loop.position == pytest.approx(ramped(push, velocity)[0], abs=1e-13)


@pytest.mark.parametrize(("least", "most"), [(4.0, 30.0), (-15.0, 15.0)], ids=["ahead", "about"])
def test_lanes_in_steps_within_a_sample_are_the_single_loops(least: float, most: float) -> None:
    """Where a signal goes on within a sample, with reversals and without."""
    push = np.random.default_rng(7).uniform(least, most, (60, LANES))
    theta = np.tile([2.0, 3.0, 1.0], (LANES, 1))
    given = {"signals": {"p": push}, "start": np.zeros(LANES), "substeps": 4}
    speed = np.full(LANES, 0.01)
    agree(free_axis("linear"), theta, np.zeros(60), T, start_velocity=speed, **given)


@pytest.mark.parametrize("between", ["linear", "held"])
def test_a_loop_is_that_of_another_integrator(between: str) -> None:
    """The law between samples, the signal as it is declared."""
    axis = build(recorded_axis("pressure", between))
    reference = 0.2 * T * np.arange(300)  # it never turns: one friction direction
    push = recorded_values("pressure")["pressure"][:300]
    theta = np.array([TRUTH[name] for name in axis.names])
    loop = simulate(axis, theta, reference, T, signals={"pressure": push}, start_velocity=0.2)
    kp, kv = (axis.axis.control.gains[name] for name in ("kp", "kv"))
    body = EventIntegrator(
        lambda _, v, tau, s, __: (tau - TRUTH["Fv"] * v - TRUTH["Fc"] * s) / TRUTH["M"], 0.0, v=0.2
    )
    ahead = push if between == "held" else np.append(push[1:], push[-1])
    rates, read = (ahead - push) / T, [body.q]  # the law has the position before

    def force(k: int) -> Callable[..., float]:
        read.append(body.q)
        made = kv * (kp * (reference[k] - read[-1]) - (read[-1] - read[-2]) / T)
        return lambda t, *_: 35.0 * made - TRUTH["off"] - TRUTH["A"] * (push[k] + rates[k] * t)

    positions, velocities = followed_by(body, 300, T, force, held=False)
    assert velocities.min() > 0.01
    assert loop.position == pytest.approx(positions, abs=1e-11)
    assert loop.velocity == pytest.approx(velocities, abs=1e-9)


@pytest.mark.slow
def test_steps_in_a_sample_are_as_many_as_the_stiffest_signal_asks_for() -> None:
    """A spring whose stiffness is recorded: 4 000 N/m in one half, 4e7 N/m in the other."""
    q, stiffness = Coordinate("q"), Signal("stiffness", "N/m", "held")
    mass = Parameter("M", "kg", nominal=1.0)
    law = ControlLaw(name="none", period=T, gains={"k": 0.0}, output=gain("k") * REFERENCE)
    axis = build(
        newton(
            "sprung",
            coordinate=q,
            parameters=(mass,),
            signals=(stiffness,),
            inertia=mass,
            resistance=(stiffness * q,),
            drive=Drive(gain=1.0),
            control=law,
        )
    )
    values = np.where(np.arange(200) < 100, 4e3, 4e6)
    loop = simulate(axis, [1.0], np.zeros(200), T, signals={"stiffness": values}, start=1e-3)
    energy = loop.velocity**2 / 2 + values * loop.position**2 / 2
    assert np.ptp(energy[:100]) < 1e-6 * energy[0]
    assert np.ptp(energy[100:]) < 1e-4 * energy[100]


def test_a_twin_takes_its_signals_from_the_experiment() -> None:
    axis = recorded_axis("pressure")
    experiment = replace(axis.experiment, signals={"pressure": 6e5 + 1e5 * sympy.sin(8 * TIME)})
    record = twin_record(replace(axis, experiment=experiment))
    expected = 6e5 + 1e5 * np.sin(8 * record.time)
    assert record.signals["pressure"] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("signals", "says"),
    [
        (None, "not given: pressure"),
        ({"pressure": np.zeros(50), "temperature": np.zeros(50)}, "not declared: temperature"),
        ({"pressure": np.zeros(49)}, r"\(49,\)"),
        ({"pressure": np.r_[np.zeros(49), np.nan]}, "not finite"),
        (["position"], r"the signals are .*\. Give arrays by name"),
        (5, r"the signals are 5\. Give arrays by name"),
    ],
)
def test_signals_that_do_not_fit_the_axis_are_refused(signals: Any, says: str) -> None:
    axis = build(recorded_axis("pressure"))
    theta = [TRUTH[name] for name in axis.names]
    with refuses("simulation-input", says):
        simulate(axis, theta, trajectory(MOVES, T)[:50], T, signals=signals)
    with refuses("twin", "pressure"):
        twin_record(axis)


TIMES = T * np.arange(400)
MASS, FRICTION, STIFFNESS = 2.0, 1.0, 3e6


@cache
def placed_axis(*, native: bool = True) -> GeneratedAxis:
    """A mass with dry friction, and forces of several kinds whose places signals move."""
    names = {"stop": "N/m", "jump": "N", "slip": "N/(m/s)", "gate": "N/m"}
    sizes = {name: Parameter(name, unit, nominal=1.0) for name, unit in names.items()}
    place, belt = Signal("place", "m"), Signal("belt", "m/s", "held")
    forces = (
        sizes["stop"] * sympy.Max(0, x.symbol - place),
        sizes["jump"] * sympy.sign(x.symbol - place),
        sizes["slip"] * sympy.Max(0, x.velocity - belt),
        sizes["gate"] * sympy.Max(0, -place),
    )
    made = newton(
        "moved",
        coordinate=x,
        parameters=(m, c, *sizes.values()),
        signals=(place, belt),
        inertia=m,
        resistance=(coulomb(c, x), *forces),
        drive=Drive(gain=1.0),
        control=force_law(T),
    )
    return build(made, native=native)


def theta(*, friction: float = 0.0, **sizes: float) -> list[float]:
    return [MASS, friction, *(sizes.get(name, 0.0) for name in ("stop", "jump", "slip", "gate"))]


def moved(
    parameters: list[float], place: Array, push: Array, *, native: bool = True, **others: Any
) -> Array:
    given = {"start": 0.0, "signals": {"place": place, "belt": 0.03 * np.cos(17 * TIMES)}}
    return simulate(placed_axis(native=native), parameters, push, T, **given, **others).position


@pytest.mark.parametrize("native", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_stop_that_comes_and_goes_within_a_sample_is_met(native: bool) -> None:
    """In its frame a push throws the mass back into it, on a parabola from a half wave to a third.

    Before and after the sample they are apart.
    """
    comes, push, stiffness, speed = 0.3, 2000.0, 3e8, 0.15
    away, w = push / MASS, np.sqrt(stiffness / MASS)
    first = (comes**2 - speed**2) / (2 * away)  # they meet at this speed
    place, forces = first + comes * (T - TIMES), np.where(TIMES == T, -push, 0.0)
    found = moved(theta(stop=stiffness), place, forces, native=native)
    contact = 2 / w * np.arctan(speed * stiffness / (w * push))
    left = T - (comes - speed) / away - contact
    assert 0 < left < T / 2 + T / 4
    apart, parting = speed * left + away * left**2 / 2, speed + away * left
    expected = place[2] - apart - (comes + parting) * (TIMES[2:6] - TIMES[2])
    assert found[2:6] == pytest.approx(expected, abs=1e-9)


#: What each kind of force is declared with.
FORCES = {"stop": 2e4, "slip": 50.0, "jump": 1.5, "gate": 200.0}


@pytest.mark.slow
@pytest.mark.parametrize("kind", FORCES)
def test_steps_lanes_and_the_virtual_machine_agree(kind: str) -> None:
    parameters, push = theta(friction=FRICTION, **{kind: FORCES[kind]}), 3.0 * np.sin(9 * TIMES)
    place = 0.004 * np.cos(31 * TIMES)
    one, fine = moved(parameters, place, push), moved(parameters, place, push, substeps=32)
    assert np.ptp(one) > 1e-4
    assert one == pytest.approx(fine, abs=1e-9)
    signals, start = {"place": place, "belt": 0.03 * np.cos(17 * TIMES)}, np.zeros(LANES)
    given = np.tile(parameters, (LANES, 1)), push, T
    agree(placed_axis(), *given, machine=placed_axis(native=False), start=start, signals=signals)


@pytest.mark.slow
def test_an_axis_rests_in_a_jump_while_it_stands_still_and_not_while_it_moves() -> None:
    push = np.where(TIMES < 0.2, 1.0, 0.0)
    assert np.all(moved(theta(jump=5.0), 0 * TIMES, push) == 0)
    leaps = moved(theta(jump=5.0), np.where(TIMES < 0.1, 0.0, 0.01), push)
    assert np.all(leaps[TIMES < 0.0995] == 0)
    assert leaps[150] > 1e-3
    carried = moved(theta(friction=0.5, jump=5.0), 1e-3 * TIMES, push)
    assert carried == pytest.approx(1e-3 * TIMES, abs=1e-6)  # the jump takes it along
