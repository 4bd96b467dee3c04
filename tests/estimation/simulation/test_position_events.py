"""Kinks and jumps of the force over the position, against closed forms and SciPy with events."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from axisid import EstimationError, Parameter, build, simulate
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import cascade_pd
from axisid.elements import coulomb, end_stop, viscous
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move
from tests.axes.bodies import Fc, Fv, body, force_law, k, x
from tests.estimation.piecewise_axis import PiecewiseAxis, closed_loop
from tests.estimation.simulation.agreement import LANES, agree

q, J = x.symbol, Parameter("J", "N")
PERIOD, STOP = 1e-3, 0.05
KP, KV = 20.0, 30.0


@cache
def axis(kind: str, kv: float = KV, *, native: bool = True) -> GeneratedAxis:
    """A mass with friction under a cascade, with one force of the position."""
    stop = sympy.Float(STOP)
    force, parameter = {
        "stop": (k * sympy.Max(0, q - stop), k),
        "stops": (k * sympy.Max(0, q - stop) - k * sympy.Max(0, -q - stop), k),
        "bumper": (k * sympy.Piecewise((0, q < stop), (q - stop, True)), k),
        "jump": (J * sympy.sign(q), J),
        "leap": (J * (2 * sympy.Heaviside(q) - 1), J),
        "choice": (J * sympy.Piecewise((-1, q <= 0), (1, True)), J),
    }[kind]
    return build(
        body(
            viscous(Fv, x),
            coulomb(Fc, x),
            force,
            coordinate=x,
            parameters=(Fv, Fc, parameter),
            name=kind,
            control=cascade_pd(kp=KP, kv=kv, period=PERIOD),
        ),
        native=native,
    )


def exact(kind: str, theta: list[float], reference: np.ndarray, kv: float = KV) -> np.ndarray:
    """The same in closed form."""
    m, fv, fc, size = theta
    beyond, before = (size, -size * STOP), (size, size * STOP)
    edges, pieces = {
        "stop": ([STOP], [(0.0, 0.0), beyond]),
        "stops": ([-STOP, STOP], [before, (0.0, 0.0), beyond]),
        "jump": ([0.0], [(0.0, -size), (0.0, size)]),
    }[kind]

    def law(r: float, q: float, dq: float) -> float:
        return kv * (KP * (r - q) - dq)

    return closed_loop(PiecewiseAxis(m, fv, fc, edges, pieces), law, reference, PERIOD)


def sine(amplitude: float, frequency: float, samples: int = 1000) -> np.ndarray:
    return amplitude * np.sin(2 * np.pi * frequency * PERIOD * np.arange(samples))


@pytest.mark.parametrize(
    ("mass", "stiffness"), [(1.0, 1e8), (100.0, 1e11), (1.0, 1e3), (2.0, 1e11)]
)
@pytest.mark.parametrize("friction", [(0.0, 0.0), (3.0, 0.7)])
def test_contact_shorter_than_a_sample_is_met(
    mass: float, stiffness: float, friction: tuple[float, float]
) -> None:
    theta, reference, kv = [mass, *friction, stiffness], sine(0.0555, 1.0), KV * mass
    loop = simulate(axis("stop", kv), theta, reference, PERIOD)
    assert loop.position.max() < STOP + 2e-3 * (stiffness < 1e4) * 10 + 1e-4
    assert np.abs(loop.position - exact("stop", theta, reference, kv)).max() < 1e-9


def random_stops(rng: np.random.Generator) -> tuple[list[float], np.ndarray]:
    friction = rng.choice([0, 1], 2) * 10 ** rng.uniform([-1, -1], [2, 1])
    theta = [10 ** rng.uniform(-1, 1.5), *friction, 10 ** rng.uniform(3, 10)]
    return theta, sine(STOP * rng.uniform(1.01, 1.6), 10 ** rng.uniform(-0.3, 0.7), 800)


def random_jumps(rng: np.random.Generator) -> tuple[list[float], np.ndarray]:
    friction = np.array([rng.choice([0, 1]), 1]) * 10 ** rng.uniform([-1, -1], [1.5, 1])
    theta = [10 ** rng.uniform(-0.5, 1), *friction, 10 ** rng.uniform(-1, 2)]
    motion = sine(10 ** rng.uniform(-5, -1), 10 ** rng.uniform(-0.6, 0.7), 800)
    steps = np.round(motion / motion.max()) * motion.max()
    return theta, [motion, steps][rng.integers(2)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "drawn", "within"), [("stops", random_stops, 1e-6), ("jump", random_jumps, 1e-9)]
)
def test_random_events_are_met_as_in_closed_form_or_refused_with_a_sentence(
    kind: str, drawn: Callable[[np.random.Generator], Any], within: float
) -> None:
    """Stops, and jumps that are crossed or rested in; with friction, so that none is chaotic."""
    rng, met, rested = np.random.default_rng(1), 0, 0.0
    for _ in range(40):
        theta, reference = drawn(rng)
        try:
            loop = simulate(axis(kind), theta, reference, PERIOD)
        except EstimationError as error:
            assert "too fast to follow" in str(error)
            continue
        met += 1
        rested += np.mean((loop.velocity == 0) & (np.abs(loop.position) < 1e-12))
        assert np.abs(loop.position - exact(kind, theta, reference)).max() < within, theta
    assert met > 35
    assert rested > 5 * (kind == "jump")


def without_feedback(name: str, *resistance: sympy.Expr, native: bool = True) -> GeneratedAxis:
    """The reference is the drive's force."""
    law, offered = force_law(PERIOD), (Fv, J, k)
    made = body(*resistance, coordinate=x, parameters=offered, name=name, control=law)
    return build(made, native=native)


@pytest.mark.parametrize("native", [pytest.param(True, marks=pytest.mark.slow), False])
@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_an_axis_that_begins_in_a_jump_leaves_it_against_the_force_ahead(
    speed: float, native: bool
) -> None:
    made = without_feedback("swing", viscous(Fv, x), J * sympy.sign(q), native=native)
    still, theta, time = np.zeros(9), [1.0, 30.0, 40.0], PERIOD * np.arange(9)
    loop = simulate(made, theta, still, PERIOD, start=0.0, start_velocity=speed)
    slowed = (0.5 + 40 / 30) * np.exp(-30 * time) - 40 / 30
    assert loop.velocity == pytest.approx(slowed * np.sign(speed), abs=1e-9)


@pytest.mark.parametrize("native", [pytest.param(True, marks=pytest.mark.slow), False])
def test_an_axis_that_two_forces_push_back_into_a_jump_rests_there(native: bool) -> None:
    """At 2 um/s it comes back ten thousand times in a sample."""
    made = without_feedback("swing", viscous(Fv, x), J * sympy.sign(q), native=native)
    still, theta = np.zeros(5), [1.0, 30.0, 40.0]
    loop = simulate(made, theta, still, PERIOD, start=0.0, start_velocity=2e-6)
    assert np.all(loop.velocity[1:] == 0)
    assert np.abs(loop.position).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(
    ("other", "kind"), [("bumper", "stop"), ("leap", "jump"), ("choice", "jump")]
)
def test_other_ways_to_write_it_are_the_same(other: str, kind: str) -> None:
    theta = [1.0, 2.0, 0.3, 1e5 if kind == "stop" else 2.0]
    reference = sine(0.07, 1.0, 800)
    one, two = (simulate(axis(name), theta, reference, PERIOD) for name in (kind, other))
    assert np.abs(one.position - two.position).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "size"), [("stops", 1e6), ("jump", 2.0)])
def test_batch_and_virtual_machine_take_the_same_events(kind: str, size: float) -> None:
    sizes = np.linspace(0.5, 2.0, LANES)
    thetas, reference = np.outer(sizes, [1.0, 2.0, 0.3, size]), sine(0.0555, 2.0, 800)
    agree(axis(kind), thetas, reference, PERIOD, machine=axis(kind, native=False))


@pytest.mark.slow
def test_continuous_law_meets_the_stop_at_the_same_time_whatever_the_period() -> None:
    law = cascade_pd(kp=KP, kv=KV, period=PERIOD, continuous=True)
    stop = 1e7 * sympy.Max(0, q - sympy.Float(STOP))
    loose = body(coulomb(Fc, x), stop, coordinate=x, parameters=(Fc,), control=law)
    made = build(loose)
    coarse = np.linspace(0.0, 0.09, 301)
    fine = np.linspace(0.0, 0.09, 2401)
    one = simulate(made, [1.0, 0.2], coarse, PERIOD)
    two = simulate(made, [1.0, 0.2], fine, PERIOD / 8)
    assert one.position.max() > STOP
    assert np.abs(one.position - two.position[::8]).max() < 1e-9


def wavy(force: Callable[[sympy.Expr], sympy.Expr]) -> GeneratedAxis:
    return build(
        body(
            viscous(Fv, x),
            J * force(q),
            coordinate=x,
            parameters=(Fv, J),
            name="wavy",
            control=cascade_pd(kp=KP, kv=100.0, period=PERIOD),
        )
    )


WAVES: dict[str, Callable[[sympy.Expr], sympy.Expr]] = {
    "cogging once a sample": lambda q: sympy.sin(2 * sympy.pi * q / 1e-3),
    "a bump between two samples": lambda q: 300 * sympy.exp(-(((q - 0.1003) / 5e-5) ** 2)),
    "a step between two samples": lambda q: sympy.tanh((q - 0.1003) / 2e-5),
    "a notch": lambda q: 100 / (1 + ((q - 0.1003) / 5e-5) ** 2),
    "cogging and a stop": lambda q: (
        sympy.sin(2 * sympy.pi * q / 1e-3) + 1e6 * sympy.Max(0, q - sympy.Float(0.19))
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", WAVES)
def test_wave_of_the_position_is_resolved_however_fast_it_passes(name: str) -> None:
    """As far as the steps are meant to: a wave is right within 2e-6 of its size (`PHASE_PER_STEP`).

    Of the notch, 100 N, that is 2e-4 N, and 1e-7 m by the loop's stiffness of 2000 N/m; it keeps
    a tenth of it. The finest steps pass a fiftieth of its width, and limit nothing here.
    """
    made, theta = wavy(WAVES[name]), [2.0, 20.0, 1.0]
    reference = trajectory((Move(0.2, 1.0, 20.0),), PERIOD)
    chosen = simulate(made, theta, reference, PERIOD)
    exact = simulate(made, theta, reference, PERIOD, substeps=1024)
    assert np.abs(chosen.position - exact.position).max() < 1e-8
    assert np.abs(chosen.force - exact.force).max() < 1e-6 * np.abs(exact.force).max()


m = Parameter("m", "kg", nominal=2.0)
MASS, STIFFNESS, STOP, PERIOD = 2.0, 8e4, 0.05, 1e-3
TIME = PERIOD * np.arange(200)


def bouncing(dissipation: float, *, native: bool = True) -> GeneratedAxis:
    """A mass under a constant force: the law gives the reference as force, whatever it measures."""
    stops = end_stop(x, lower=-1.0, upper=STOP, stiffness=STIFFNESS, dissipation=dissipation)
    made = body(stops, coordinate=x, inertia=m, name="bouncing", control=force_law(PERIOD))
    return build(made, native=native)


FORCE = np.where(TIME < 0.02, 30.0, 0.0)  # a push, then free flight into the stop
SPEED = 30.0 * 0.02 / MASS


@pytest.mark.slow
@pytest.mark.parametrize("dissipation", [0.5, 4.0])
def test_impact_with_dissipation_is_that_of_scipy_with_events(dissipation: float) -> None:
    loop = simulate(bouncing(dissipation), [MASS], FORCE, PERIOD, start=0.0)

    def contact(_: float, state: np.ndarray) -> list[float]:
        depth = state[0] - STOP
        push = STIFFNESS * depth * max(0.0, 1 + dissipation * state[1])
        return [state[1], -push / MASS]

    def leaves(_: float, state: np.ndarray) -> float:
        return float(state[0] - STOP)

    leaves.terminal, leaves.direction = True, -1.0  # type: ignore[attr-defined]
    begins = 0.02 + (STOP - 30.0 / MASS * 0.02**2 / 2) / SPEED
    inside = solve_ivp(
        contact, (0, 1), [STOP, SPEED], "DOP853", events=leaves, rtol=1e-11, atol=1e-14
    )
    ends, speed = begins + inside.t[-1], inside.y[1, -1]
    after = ends < TIME
    assert loop.position[after] == pytest.approx(STOP + speed * (TIME[after] - ends), abs=2e-5)
    assert loop.velocity[-1] == pytest.approx(speed, rel=2e-3)
    assert 0 < -speed < SPEED
