"""The loop for every kind of friction, load and law, against independent solutions; its twins."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import Axis, build, load_axis, simulate, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import MEASURED_POSITION, cascade_pd, state_feedback
from axisid.elements import Drive
from axisid.estimation import simulate_batch
from axisid.estimation.simulation import signals_about, twin_plan
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move, back_and_forth
from benchmarks.event_integrator import EventIntegrator
from tests.axes.bodies import body, force_law
from tests.axes.simulated import AXES
from tests.estimation.piecewise_axis import PiecewiseAxis, closed_loop
from tests.estimation.simulation.agreement import LANES, agree, followed_by
from tests.refusals import refuses

PERIOD = 1e-3


def sine(frequency: float, amplitude: float, seconds: float) -> np.ndarray:
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    return amplitude * np.sin(2 * np.pi * frequency * t)


THERE = trajectory((Move(0.05, 0.1, 1.0),), PERIOD)
MOTIONS = {
    "1 Hz, 0.1 m sine": sine(1.0, 0.1, 3.0),
    "move, hold, return": np.r_[THERE, 0 * THERE + THERE[-1], THERE[-1] - THERE, 0 * THERE],
    "0.1 Hz, 5 mm stick-slip": sine(0.1, 5e-3, 10.0),
    "5 Hz, 2 mm reversals": sine(5.0, 2e-3, 2.0),
}


@cache
def built(name: str, *, native: bool = True) -> GeneratedAxis:
    return build(AXES[name], native=native)


def motion_of(axis: GeneratedAxis, seconds: float = 0.6) -> np.ndarray:
    """A motion with rests and reversals, of a size that suits the axis."""
    size = 0.02 if axis.axis.coordinate.unit == "m" else 0.8
    t = np.arange(round(seconds / axis.axis.control.period)) * axis.axis.control.period
    return size * np.clip(1.5 * np.sin(2 * np.pi * t / 0.4), -1, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", AXES)
def test_rows_satisfy_the_model_and_a_stuck_axis_rests(name: str) -> None:
    axis = built(name)
    theta = axis.nominal
    loop = simulate(axis, theta, motion_of(axis), axis.axis.control.period)
    for s in (loop.signals, signals_about(axis, theta, loop)[1]):
        row, known = axis.evaluate(
            "idm_regressor", s.position, s.velocity, s.acceleration, s.direction
        )
        error = np.abs(row @ theta + known[:, 0] - s.force)
        assert error.max() < 1e-9 * np.abs(s.force).max()
    assert set(np.unique(loop.mode)) <= {-1.0, 0.0, 1.0}
    stuck = loop.mode == 0
    # While it sticks it may not move until the next sample, unless the law is continuous.
    if not axis.axis.control or not axis.axis.control.continuous:
        still = stuck[:-1]
        assert np.all(loop.position[1:][still] == loop.position[:-1][still])
    sliding = loop.velocity != 0
    assert np.array_equal(loop.direction[sliding], np.sign(loop.velocity[sliding]))


@pytest.mark.parametrize("offset", [0.0, -7.0])
@pytest.mark.parametrize("motion", MOTIONS)
def test_position_is_within_a_nanometre_of_the_closed_form(motion: str, offset: float) -> None:
    theta = np.array([100.2, 236.9, 24.8, offset])
    loop = simulate(built("offset"), theta, MOTIONS[motion], PERIOD)
    exact = PiecewiseAxis(*theta[:3], [], [(0.0, offset)])

    def law(r: float, q: float, dq: float) -> float:
        return 35.15 * min(max(243.45 * (160.18 * (r - q) - dq), -10.0), 10.0)

    position = closed_loop(exact, law, MOTIONS[motion], PERIOD)
    assert np.abs(loop.position - position).max() < 1e-9


@pytest.mark.slow
def test_pendulum_with_coulomb_friction_is_within_1e_8_rad_of_another_integrator() -> None:
    axis, time = built("open_pendulum"), np.arange(800) * 5e-3
    J, mgl, fc = theta = np.array([0.0626, 1.0, 0.2])
    forces = 0.6 * np.sin(2 * np.pi * 0.8 * time) * (time < 1.6)
    loop = simulate(axis, theta, forces, 5e-3, start=0.3)
    body = EventIntegrator(lambda q, _, tau, s, __: (tau - mgl * math.sin(q) - fc * s) / J, 0.3)
    expected, _ = followed_by(body, 800, 5e-3, lambda k: lambda *_: float(forces[k]))
    assert (loop.mode == 0).sum() > 50
    assert (np.diff(np.sign(loop.velocity)) != 0).sum() > 6
    assert np.abs(loop.position - expected).max() < 1e-8


def test_error_falls_with_the_fourth_power_of_the_step() -> None:
    axis = built("open_pendulum")
    theta = np.array([0.0626, 1.0, 0.12])
    forces = 0.6 + 0.5 * np.sin(np.arange(60) / 9.0)  # it swings out without a reversal
    exact = simulate(axis, theta, forces, 5e-3, substeps=64).position
    errors = [
        np.abs(simulate(axis, theta, forces, 5e-3, substeps=n).position - exact).max()
        for n in (1, 2, 4)
    ]
    assert errors[0] / errors[1] > 2**3.8
    assert errors[1] / errors[2] > 2**3.8


@pytest.mark.slow
def test_continuous_law_is_the_differential_equation() -> None:
    """The loop as one equation, friction crossings and breakaway located."""
    axis = built("continuous")
    M, Fv, Fc = theta = np.array([100.2, 236.9, 24.8])
    reference = 0.006 - 0.006 * np.cos(2 * np.pi * np.arange(800) / 400)
    loop = simulate(axis, theta, reference, PERIOD)
    assert np.abs(loop.control).max() < 9
    body = EventIntegrator(lambda _, v, tau, s, __: float((tau - Fv * v - Fc * s) / M), 0.0)
    rates = np.diff(reference, append=reference[-1]) / PERIOD

    def force(k: int) -> Callable[..., float]:
        return lambda t, q, v: float(
            35.15 * 243.45 * (160.18 * (reference[k] + rates[k] * t - q) - v)
        )

    position, _ = followed_by(body, len(reference), PERIOD, force, held=False)
    assert np.abs(loop.position - position).max() < 2e-9


def test_encoder_counts_are_what_the_law_measures() -> None:
    axis, resolution = built("offset"), 1e-5
    loop = simulate(axis, axis.nominal, sine(1.0, 0.01, 0.5), PERIOD, resolution=resolution)
    counts = loop.measured_position / resolution
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    assert np.abs(loop.measured_position - loop.position).max() <= resolution / 2 * (1 + 1e-9)
    expected = 243.45 * (160.18 * (sine(1.0, 0.01, 0.5) - loop.measured_position) - loop.velocity)
    assert loop.control == pytest.approx(np.clip(expected, -10, 10), abs=1e-6)


def test_noise_enters_through_the_measured_position(
    emps2015: GeneratedAxis, rng: np.random.Generator
) -> None:
    reference = MOTIONS["1 Hz, 0.1 m sine"]
    noise = 1e-5 * rng.normal(size=len(reference))
    clean = simulate(emps2015, TRUTH, reference, PERIOD)
    loop = simulate(emps2015, TRUTH, reference, PERIOD, position_noise=noise)
    assert loop.measured_position - loop.position == pytest.approx(noise, abs=1e-15)
    first = 35.15 * 243.45 * 160.18 * -noise[0]
    assert loop.force[0] - clean.force[0] == pytest.approx(first, rel=1e-9)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_batch_is_the_simulations_one_by_one(threads: int, rng: np.random.Generator) -> None:
    axis = built("offset")
    theta = axis.nominal * rng.uniform(0.7, 1.3, (LANES, 4))
    reference = motion_of(axis)[:, None] * rng.uniform(0.5, 1.5, LANES)
    noise, start = 1e-6 * rng.normal(size=reference.shape), 1e-4 * rng.normal(size=LANES)
    own = {"start": start, "position_noise": noise, "injected": 1e3 * noise}
    whole = simulate_batch(axis, theta, reference, PERIOD, threads=threads, **own)
    assert np.array_equal(
        whole["force"], simulate_batch(axis, theta, reference, PERIOD, **own)["force"]
    )
    agree(axis, theta, reference, PERIOD, rel=0.0, **own)


@pytest.mark.slow
@pytest.mark.parametrize("anti_windup", ["clamping", "back_calculation"])
def test_anti_windup_moves_no_loop_that_stays_within_its_limit(anti_windup: str) -> None:
    """To the last bit, alone and in a batch, compiled and in the virtual machine."""
    reference = MOTIONS["1 Hz, 0.1 m sine"][:800]

    def motions(what: str, limit: float) -> list[np.ndarray]:
        law = state_feedback(
            k_position=39000.0,
            k_velocity=243.0,
            k_integral=2e5,
            period=PERIOD,
            velocity="averaged",
            anti_windup=what,
        )
        axis = replace(AXES["offset"], control=law, drive=Drive(gain=35.15, limit=limit))
        native, virtual = build(axis), build(axis, native=False)
        theta = native.nominal
        return [
            simulate(native, theta, reference, PERIOD).position,
            simulate_batch(native, theta[None], reference, PERIOD)["position"][:, 0],
            simulate(virtual, theta, reference[:200], PERIOD).position,
        ]

    expected = motions("none", math.inf)
    for limit in (math.inf, 1e6):
        for found, wanted in zip(motions(anti_windup, limit), expected, strict=True):
            np.testing.assert_array_equal(found, wanted)


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False], ids=["native", "virtual machine"])
def test_control_that_is_not_a_number_ends_the_simulation(native: bool) -> None:
    axis = AXES["offset"]
    root = sympy.sqrt(MEASURED_POSITION - 1e-5)
    law = replace(axis.control, output=axis.control.output + root)
    broken = build(replace(axis, control=law), native=native)
    with refuses("simulation", says="position is not finite at sample"):
        simulate(broken, broken.nominal, motion_of(broken), PERIOD)


@pytest.mark.parametrize("native", [pytest.param(True, marks=pytest.mark.slow), False])
def test_rounding_moves_no_axis_from_rest(native: bool, rng: np.random.Generator) -> None:
    """Held at its friction to the last bit, its first step may end before it has begun."""
    axis = build(replace(AXES["root_of_speed"], control=force_law(PERIOD)), native=native)
    for _ in range(40):
        theta = axis.nominal * 10 ** rng.uniform(-0.3, 0.3, 3)
        push = np.full(3, rng.choice([-1, 1]) * theta[2] / 35.15)
        loop = simulate(axis, theta, push, PERIOD, start=0.1)
        assert np.abs(loop.position - 0.1).max() < 1e-12


TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}
LOADED, TWO = {**TRUTH, "F0": 0.0}, np.ones((2, 4))
REFERENCE = 0.01 * np.sin(np.arange(200) / 20.0)


def test_parameters_by_name_are_those_in_order(emps2015: GeneratedAxis) -> None:
    turned = dict(reversed(TRUTH.items()))
    ordered = [TRUTH[name] for name in emps2015.names]
    alone = simulate(emps2015, turned, REFERENCE, 1e-3)
    assert alone == simulate(emps2015, ordered, REFERENCE, 1e-3)
    masses = np.array([20.0, 24.8, 30.0])  # the others are shared
    lanes = simulate_batch(emps2015, {**TRUTH, "Fc": masses}, REFERENCE, 1e-3)
    np.testing.assert_array_equal(lanes["position"][:, 1], alone.position)


WRONG = [
    ({"parameters": [1.0, 2.0]}, r"4 parameters .* the shape \(2,\)"),
    ({"parameters": [[1.0]]}, r"\(1, 1\)"),
    ({"parameters": {"M": 1.0, "Fv": 2.0, "Fc": 1.0}}, "F0 is missing"),
    (
        {"parameters": {**LOADED, "m": 1.0}},
        r"'m' is no parameter\. Give a value for each of M, Fv, Fc",
    ),
    ({"parameters": {**LOADED, "M": np.ones(2), "Fc": np.ones(3)}}, r"M \(2,\), .* Fc \(3,\)"),
    ({"reference": []}, r"reference has the shape \(0,\)"),
    ({"reference": [0.0, np.nan]}, ""),
    ({"position_noise": [0.0]}, r"noise has the shape \(1,\)\. Give .*\(3,\)"),
    ({"position_noise": [0.0, np.nan, 0.0]}, ""),
    ({"injected": [0.0]}, r"injected signal has the shape \(1,\)"),
    ({"resolution": -1.0}, "-1.0"),
    ({"axis": "continuous", "resolution": 1e-6}, "1e-06"),
    ({"substeps": -2}, "-2"),
    ({"substeps": 10**19}, "1000"),
    ({"start_velocity": np.nan}, r"the start velocity is nan\. Give one finite number"),
    ({"axis": "delayed", "memory": [1.0]}, r"memory \(total, .*\) has .* Give .*\(3,\)"),
    ({"axis": "delayed", "memory": [0.0, np.inf, 0.0]}, "not finite"),
    ({"lanes": np.ones((2, 3))}, "has 4 parameters"),
    ({"lanes": np.ones((0, 4))}, ""),
    ({"lanes": TWO, "reference": np.zeros((3, 3))}, r"\(3, 3\)"),
    ({"lanes": TWO, "position_noise": np.zeros((3, 3))}, ""),
    ({"lanes": TWO, "injected": np.zeros(4)}, ""),
    ({"lanes": TWO, "wanted": ("speed",)}, "speed"),
    ({"lanes": TWO, "wanted": "position"}, ""),
    ({"lanes": TWO, "wanted": ("before",)}, "direction_before"),
    ({"lanes": TWO, "start": [0.0]}, ""),
    ({"lanes": TWO, "start_velocity": [np.nan, 0.0]}, "not finite"),
    ({"lanes": TWO, "memory": [[1.0]]}, r"shape \(1, 1\)"),
    ({"code": "time", "period": 0.0}, "0.0"),
    ({"code": "time", "period": np.nan}, "nan"),
]


@pytest.mark.parametrize(("arguments", "says"), WRONG)
def test_bad_arguments_are_explained(arguments: dict[str, Any], says: str) -> None:
    given: dict[str, Any] = {"reference": [0.0, 1e-3, 0.0], "period": PERIOD, **arguments}
    axis, lanes = built(given.pop("axis", "offset")), given.pop("lanes", None)
    with refuses(given.pop("code", "simulation-input"), says):
        if lanes is None:
            simulate(axis, **{"parameters": axis.nominal, **given})
        else:
            simulate_batch(axis, lanes, **given)


def test_axis_without_law_cannot_be_simulated() -> None:
    with refuses("no-control-law"):
        simulate(build(body()), np.array([1.0]), np.zeros(5), PERIOD)
    with refuses("twin", says="experiment"):
        twin_record(body())


SECONDS = PERIOD * np.arange(1500)
SINE = 0.005 * (1 - np.cos(2 * np.pi * SECONDS))
ADDED = 0.3 * np.sin(2 * np.pi * 7 * SECONDS) + 0.2 * np.sin(2 * np.pi * 23 * SECONDS)


def _law(axis: GeneratedAxis, reference: np.ndarray, position: np.ndarray) -> np.ndarray:
    law = axis.axis.control
    before = np.concatenate([position[:1], position[:1], position[:-2]])
    speed = (position - before) / (2 * PERIOD)
    return np.asarray(law.gains["kv"] * (law.gains["kp"] * (reference - position) - speed))


@pytest.mark.parametrize("times", [1, 40])
def test_control_is_the_law_and_what_is_added_to_it_within_the_limit(
    emps: GeneratedAxis, times: int
) -> None:
    drive = emps.axis.drive
    loop = simulate(emps, emps.nominal, SINE, PERIOD, injected=times * ADDED)
    expected = _law(emps, SINE, loop.position) + times * ADDED
    np.testing.assert_allclose(
        loop.control, np.clip(expected, -drive.limit, drive.limit), atol=1e-9
    )
    np.testing.assert_allclose(loop.force, drive.gain * loop.control, rtol=1e-13)
    assert (np.abs(loop.control).max() == drive.limit) == (times > 1)


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
def test_a_continuous_law_has_it_held_over_the_sample(*, native: bool) -> None:
    axis = load_axis("emps")
    laws = (
        cascade_pd(kp=160.18, kv=243.45, period=period, continuous=True)
        for period in (PERIOD, PERIOD / 5)
    )
    coarse, fine = (
        build(replace(axis, control=law, experiment=None), native=native) for law in laws
    )
    reference = np.interp(np.arange(991) / 5, np.arange(199), SINE[:199])
    loop = simulate(coarse, coarse.nominal, SINE[:199], PERIOD, injected=ADDED[:199])
    held = np.repeat(ADDED[:199], 5)[:991]
    five = simulate(fine, fine.nominal, reference, PERIOD / 5, injected=held)
    np.testing.assert_allclose(loop.position, five.position[::5], atol=1e-10)
    without = simulate(coarse, coarse.nominal, SINE[:199], PERIOD)
    assert np.abs(loop.position - without.position).max() > 1e-6


def test_a_loop_that_only_the_signal_moves_is_no_runaway(emps: GeneratedAxis) -> None:
    still = np.zeros(1500)
    still[0] = 1e-12
    loop = simulate(emps, emps.nominal, still, PERIOD, start=0.0, injected=ADDED)
    assert np.ptp(loop.position) > 1e-6


def test_a_trajectory_rests_as_long_as_each_move_dwells() -> None:
    there = Move(0.05, 0.1, 1.0)
    q = trajectory(back_and_forth(speeds=(0.1,), acceleration=1.0, seconds=0.5, dwell=0.25), PERIOD)
    moving, resting = round(there.duration / PERIOD), round(0.25 / PERIOD)
    np.testing.assert_allclose(q[: moving + 1], trajectory((there,), PERIOD), atol=1e-15)
    np.testing.assert_allclose(q[moving : moving + resting + 1], 0.05, atol=1e-15)
    assert q[moving + resting + 2] < 0.05
    assert len(q) == 2 * (moving + resting) + 1


def test_trajectory_keeps_its_speed_and_acceleration() -> None:
    moves = (Move(0.1, 0.2, 2.0), Move(-0.001, 0.2, 2.0), Move(0.0, 1.0, 1.0), Move(0.3, 0.5, 1.0))
    q = trajectory(moves, PERIOD)
    assert q[0] == 0
    assert q[-1] == pytest.approx(0.399, abs=1e-6)
    assert np.abs(np.diff(q)).max() / PERIOD == pytest.approx(0.5, rel=1e-6)
    assert np.abs(np.diff(q, 2)).max() / PERIOD**2 <= 2.0 + 1e-6


def test_twin_is_reproducible_and_its_seed_matters(emps2015: GeneratedAxis) -> None:
    first, again = twin_record(emps2015), twin_record(emps2015)
    assert np.array_equal(first.position, again.position)
    assert not np.array_equal(first.position, twin_record(emps2015, seed=7).position)
    quiet = twin_record(emps2015, position_noise=0.0)
    assert np.std(first.position - quiet.position) == pytest.approx(3.8e-6, rel=0.3)


def loaded(counterbalance: float) -> Axis:
    """A vertical axis whose drive holds 22.6 kN, with a load of so much less."""
    axis = load_axis("vertical_screw")
    experiment = axis.experiment
    truth = {**experiment.truth, "Fb": counterbalance}
    return replace(axis, experiment=replace(experiment, truth=truth))


def test_a_twin_whose_drive_cannot_hold_its_load_is_refused_with_numbers() -> None:
    holds = 22619.467 - 180.0 * 9.80665  # beside the weight, without friction, which holds 160 N
    twin_plan(build(loaded(-holds - 100.0), native=False))
    for beyond in (-holds - 200.0, 25000.0):
        with refuses("twin", says=rf"limit of 30 A .* gives -2.* Fb = {beyond:g} N"):
            twin_plan(build(loaded(beyond), native=False))
