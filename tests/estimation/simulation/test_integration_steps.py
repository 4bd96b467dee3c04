"""The steps that a simulation chooses by itself, and when its loop counts as running away."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy

from axisid import (
    Constant,
    Coordinate,
    EstimationError,
    Parameter,
    build,
    simulate,
)
from axisid.codegen import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.control import (
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    REFERENCE,
    ControlLaw,
    cascade_pd,
    gain,
)
from axisid.elements import Drive, coulomb, end_stop, gravity, stribeck, viscous
from axisid.estimation import simulate_batch
from axisid.estimation.simulation import (
    LoopInputs,
    StepBudget,
    simulate_loop,
)
from tests.axes.bodies import M, b, body, q, rotor, turn
from tests.estimation.simulation.agreement import agree
from tests.refusals import refuses

PERIOD = 1e-3
TIME = PERIOD * np.arange(600)
SINE = 0.05 * np.sin(2 * np.pi * 2 * TIME)
STEP = np.where(TIME < 0.1, 0.0, 0.04)  # the loop overshoots it
REST = np.zeros(600)
p = Parameter("p", "N", nominal=1.0)


def light(*terms: sympy.Expr, value: float = 1.0) -> GeneratedAxis:
    """A light axis under forces of one parameter."""
    own = replace(p, nominal=value)
    law = cascade_pd(kp=40.0, kv=100.0, period=PERIOD)
    return build(body(*terms, parameters=(own,), name="light", control=law))


def error_of(
    axis: GeneratedAxis, reference: np.ndarray, period: float = PERIOD, start: float | None = None
) -> float:
    """Largest, of positions with the steps that are chosen, by those with the most there are."""
    chosen, exact = (
        simulate(axis, axis.nominal, reference, period, start=start, substeps=substeps).position
        for substeps in (None, 1024)
    )
    return float(np.abs(chosen - exact).max())


def stiff(term: Callable[[Coordinate], sympy.Expr], value: float) -> GeneratedAxis:
    """With one stiff term ``value * term``; the 4 leaves its unit unchecked."""
    return light(4 * p * term(q), value=value / 4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("term", "value", "reference", "start", "allowed"),
    [
        (lambda x: x.velocity, 4000.0, SINE, 0.0, 1e-9),
        (lambda x: sympy.Max(0, x.symbol - 0.03), 1e6, SINE, 0.0, 1e-6),
        (lambda x: sympy.Max(0, x.symbol - 0.0402), 1e7, STEP, 0.0, 1e-6),
        (lambda x: x.velocity * sympy.Abs(x.velocity), 2e4, SINE, 0.0, 1e-8),
        (lambda x: x.velocity * sympy.Abs(x.velocity), 2e4, REST, 0.05, 1e-8),
        (lambda x: sympy.tanh(x.velocity / 1e-4), 5.0, SINE, 0.0, 1e-9),
        (lambda x: sympy.cos(2 * sympy.pi * x.symbol / 0.003125), 50.0, SINE, 0.0, 1e-9),
        (
            lambda x: sympy.sign(x.velocity) * sympy.exp(-sympy.Abs(x.velocity) / 1e-3),
            5.0,
            SINE,
            0.0,
            1e-9,
        ),
    ],
    ids=[
        "damping",
        "end stop",
        "end stop met by the overshoot only",
        "quadratic drag",
        "quadratic drag, released away from a constant reference",
        "smoothed friction",
        "cogging finer than a grid",
        "Stribeck",
    ],
)
def test_stiff_terms_are_resolved_by_themselves(
    term: Callable[[Coordinate], sympy.Expr],
    value: float,
    reference: np.ndarray,
    start: float,
    allowed: float,
) -> None:
    assert error_of(stiff(term, value), reference, start=start) < allowed


@pytest.mark.slow
def test_lane_takes_the_steps_it_takes_alone_whatever_the_other_references() -> None:
    axis = stiff(lambda x: x.velocity * sympy.Abs(x.velocity), 400.0)
    references = np.column_stack([0.1 * SINE, SINE, STEP, REST, 5 * STEP] * 7)
    theta = axis.nominal * np.tile([1.0, 1.1, 0.9, 1.0, 1.3], 7)[:, None]
    agree(axis, theta, references, PERIOD, rel=0.0)


@pytest.mark.slow
def test_steps_that_were_too_few_to_survive_are_taken_anew() -> None:
    """With one step a sample the drag throws the axis out of range at once."""
    axis = stiff(lambda x: x.velocity**3, 1e10)
    theta = np.vstack([axis.nominal, [1.0, 0.0]])
    few = simulate_batch(axis, theta, SINE, PERIOD, substeps=1)
    assert set(few.failures) == {0}
    enough = simulate_batch(axis, theta, SINE, PERIOD)
    assert not enough.failures
    assert np.all(np.isfinite(enough["position"]))


@pytest.mark.slow
@pytest.mark.parametrize("uniform", [True, False])
def test_axis_too_stiff_for_any_allowed_step_is_refused_by_name(*, uniform: bool) -> None:
    """Its steps would be unstable, and the result wrong."""
    axis = stiff(lambda x: x.velocity * (1 if uniform else 1 + x.symbol**2), 1e9)
    assert axis.uniform == uniform
    with pytest.raises(EstimationError, match="too stiff to simulate"):
        simulate(axis, axis.nominal, SINE, PERIOD)
    theta = np.vstack([axis.nominal, [1.0, 10.0]])
    batch = simulate_batch(axis, theta, SINE, PERIOD)
    assert set(batch.failures) == {0}
    assert "too stiff to simulate" in batch.failures[0]
    assert np.all(np.isnan(batch["position"][:, 0]))
    alone = simulate(axis, theta[1], SINE, PERIOD)
    assert np.array_equal(batch["position"][:, 1], alone.position)


@pytest.mark.slow
def test_stiffness_of_a_continuous_law_counts_alone_and_in_a_batch() -> None:
    """Nothing but the law's position gain is fast here."""
    b = Parameter("b", "N/(m/s)", nominal=2.0)
    spring = ControlLaw(
        name="spring",
        period=PERIOD,
        gains={"kp": 1e5},
        output=gain("kp") * (REFERENCE - MEASURED_POSITION),
        continuous=True,
    )
    axis = build(body(viscous(b, q), parameters=(b,), name="sprung", control=spring))
    assert error_of(axis, SINE) < 1e-8
    alone = simulate(axis, axis.nominal, SINE, PERIOD).position
    batch = simulate_batch(axis, np.tile(axis.nominal, (3, 1)), SINE, PERIOD)
    assert np.array_equal(batch["position"][:, 1], alone)


INERTIA = Parameter("J", "kg m^2", nominal=2.0)
TORQUE = Parameter("c", "N m", nominal=3.0)
C, ANGLE, SPEED = TORQUE.symbol, turn.symbol, turn.velocity * Constant(1.0, "s").symbol


@cache
def loaded(resistance: sympy.Expr) -> GeneratedAxis:
    """An inertia under a resistance."""
    return build(
        rotor(
            viscous(Constant(0.5, "N m/(rad/s)"), turn),
            resistance,
            inertia=INERTIA,
            parameters=(TORQUE,),
            name="loaded",
            control=cascade_pd(kp=40.0, kv=100.0, period=PERIOD),
        ),
        native=False,
    )


@pytest.mark.parametrize(
    ("resistance", "start", "says"),
    [
        (
            C / SPEED,
            0.0,
            r"force has no finite value at rest at q = 0 rad with J = 2 kg m\^2, c = 3 N m\. "
            r"See the term c/.*dq\S*\. Write a term that is finite wherever",
        ),
        (C * sympy.log(ANGLE), 0.0, r"no finite value .* See the term c\*log\(q\)\."),
        (C * sympy.sqrt(ANGLE - 1), 0.5, r"at q = 0\.5 rad .* c\*sqrt\(q - 1\)\."),
        (
            1e300 * C * sympy.exp(ANGLE),
            0.0,
            r"its force is 3e\+300 N m at rest at q = 0 rad with .*, beyond the range of any drive"
            r"\. "
            r"See the term \S*c\*exp\(q\)\. Correct its factor, its units",
        ),
        (C * sympy.exp(-900 * ANGLE), -0.5, r"its force is .* c\*exp\(-900\*q\)\."),
    ],
    ids=str,
)
def test_axis_whose_force_at_rest_no_motion_starts_from_is_refused_by_the_term(
    resistance: sympy.Expr, start: float, says: str
) -> None:
    axis = loaded(resistance)
    with refuses("simulation", says=f"^axis 'loaded' cannot be simulated: .*{says}"):
        simulate(axis, axis.nominal, start + REST, PERIOD)
    batch = simulate_batch(axis, axis.nominal[None, :], start + REST, PERIOD)
    assert set(batch.failures) == {0}
    with pytest.raises(EstimationError, match=says):
        raise EstimationError(batch.failures[0])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("period", "velocity", "stops"), [(1e-3, 3e-4, False), (1e-3, 3e-3, True), (5e-3, 3e-4, True)]
)
def test_a_stribeck_peak_within_one_sample_is_resolved(
    period: float, velocity: float, stops: bool
) -> None:
    fs, fc = Parameter("Fs", "N", nominal=5.0), Parameter("Fc", "N", nominal=7.5)
    terms = [coulomb(fc, q), stribeck(fs, q, velocity=velocity)]
    terms += [end_stop(q, lower=-1.0, upper=1.0, stiffness=1e6)] * stops
    law = cascade_pd(kp=20.0, kv=60.0, period=period)
    axis = build(body(*terms, parameters=(fc, fs), name="peaked", control=law))
    reference = 0.05 * np.sin(2 * np.pi * 4 * period * np.arange(int(1 / period)))
    size = np.ptp(simulate(axis, axis.nominal, reference, period).position)
    assert error_of(axis, reference, period) < 2e-8 * size


LENGTH, NEWTON = Constant(1.0, "m", "x0"), Constant(1.0, "N", "f0")
LONG = np.tile(SINE, 20)
WAVES = {
    "p*tan(4000*q/x0)": (p * sympy.tan(4000 * q.symbol / LENGTH),),
    "p*sin(3000000.0*q/x0)": (
        p * sympy.sin(3e6 * q.symbol / LENGTH),
        NEWTON * sympy.Abs(q.symbol - LENGTH / 50) / LENGTH,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("term", WAVES)
def test_what_takes_more_steps_than_a_simulation_has_is_refused_by_its_term(term: str) -> None:
    axis = light(*WAVES[term])
    with pytest.raises(EstimationError) as alone:
        simulate(axis, axis.nominal, LONG, PERIOD)
    assert f"the term {term} at q = " in str(alone.value)
    batch = simulate_batch(axis, axis.nominal[None, :], LONG, PERIOD)
    assert batch.failures == {0: str(alone.value)}


@pytest.mark.slow
def test_simulations_of_one_search_share_their_steps_and_the_last_is_refused_by_its_term() -> None:
    axis = light(p * sympy.sin(5e4 * q.symbol / LENGTH))
    inputs = LoopInputs(reference=SINE, period=PERIOD, start=LoopStart(position=0.0))
    budget = StepBudget(left=200 * len(SINE))
    simulate_loop(axis, axis.nominal, inputs, budget=budget)
    assert 64 * len(SINE) > budget.left > 0
    said = r"the term p\*sin\(50000.0\*q/x0\) .* than 64 steps .* other simulations of the search"
    with pytest.raises(EstimationError, match=said):
        simulate_loop(axis, axis.nominal, inputs, budget=budget)
    simulate_loop(axis, axis.nominal, inputs)


PERIOD, KP, MASS, GRAVITY, SAG = 1e-3, 40.0, 1.0, 9.80665, 2.3e-3
KV = MASS * GRAVITY / (KP * SAG)
LONG_TIME = PERIOD * np.arange(1500)
SMALL = 1e-5 * np.sin(2 * np.pi * LONG_TIME)
THETA = np.array([MASS, 1.0])


@cache
def vertical(sign: float = 1.0, kind: str = "cascade") -> GeneratedAxis:
    """A weight on an axis whose loop has no integral part, so that it hangs below its reference."""
    cascade = cascade_pd(kp=KP, kv=KV, period=PERIOD)
    law = {
        "cascade": cascade,
        "late": replace(cascade, delay=2),
        "brake": ControlLaw(name="brake", period=PERIOD, output=-50 * MEASURED_VELOCITY),
    }[kind]
    resistance, drive = (viscous(b, q), gravity(M)), Drive(gain=sign)
    return build(body(*resistance, parameters=(b,), name="vertical", drive=drive, control=law))


@pytest.mark.slow
def test_an_axis_that_sags_further_than_its_reference_moves_is_simulated() -> None:
    loop = simulate(vertical(), THETA, SMALL, PERIOD)
    assert np.abs(loop.position - SMALL).max() > 100 * np.ptp(SMALL)
    assert loop.position[500:] == pytest.approx(-SAG, abs=3e-5)
    batch = simulate_batch(vertical(), np.array([THETA, THETA * 1.1]), SMALL, PERIOD)
    assert not batch.failures
    assert batch["position"][500:, 1] == pytest.approx(-1.1 * SAG, abs=3e-5)


@pytest.mark.slow
@pytest.mark.parametrize("reference", [SMALL, 1e3 * SMALL], ids=["small", "large"])
def test_a_loop_that_runs_away_is_refused_however_far_its_load_moves_it(
    reference: np.ndarray,
) -> None:
    with refuses("simulation", says=r"diverges: the position leaves the range at sample"):
        simulate(vertical(-1.0), THETA, reference, PERIOD)
    light = THETA * 0.03  # the sampled loop swings ever further
    batch = simulate_batch(vertical(), np.array([THETA, light]), reference, PERIOD)
    assert set(batch.failures) == {1}
    stopped = int(np.flatnonzero(np.isnan(batch["position"][:, 1]))[0])
    assert re.search(f"diverges: .* at sample {stopped} .* with M = 0.03 kg", batch.failures[1])
    alone = simulate(vertical(), THETA, reference, PERIOD)
    assert np.array_equal(batch["position"][:, 0], alone.position)


@pytest.mark.slow
def test_an_axis_moved_by_the_noise_of_its_encoder_alone_is_simulated() -> None:
    level = 1e-9 * np.sin(2 * np.pi * LONG_TIME)
    noise = np.random.default_rng(1).normal(0.0, 1e-5, len(LONG_TIME))
    still = build(vertical().axis)
    loop = simulate(still, [MASS, 1.0], level - SAG, PERIOD, start=-SAG, position_noise=noise)
    assert np.abs(loop.position).max() > 0


@pytest.mark.slow
def test_a_law_that_brakes_alone_has_no_distance_of_its_own() -> None:
    loop = simulate(vertical(kind="brake"), THETA, SMALL, PERIOD)
    assert loop.position[-1] < -100 * np.ptp(SMALL), "it sinks, as slowly as it is braked"
