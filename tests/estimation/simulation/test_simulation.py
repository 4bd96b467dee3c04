"""The loop for every kind of friction, load and law, against independent solutions."""

import math
import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid import (
    build,
    load_axis,
    simulate,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.control import MEASURED_POSITION, ControlLaw, cascade_pd
from axisid.elements import Drive
from axisid.estimation import simulate_batch
from axisid.estimation.simulation.simulated import (
    signals_about,
)
from benchmarks.event_integrator import EventIntegrator
from tests.axes.bodies import force_law
from tests.axes.simulated import AXES
from tests.estimation.piecewise_axis import PiecewiseAxis, closed_loop
from tests.estimation.simulation.agreement import LANES, agree
from tests.estimation.simulation.test_closed_loop import MOTIONS, sine
from tests.refusals import refuses

PERIOD = 1e-3
FIELDS = ("position", "velocity", "acceleration", "force", "control", "direction")


@cache
def built(name: str, *, native: bool = True) -> GeneratedAxis:
    return build(AXES[name], native=native)


def motion_of(axis: GeneratedAxis, seconds: float = 0.6) -> np.ndarray:
    """A motion with rests and reversals, of a size that suits the axis."""
    size = 0.02 if axis.axis.coordinate.unit == "m" else 0.8
    t = np.arange(round(seconds / axis.axis.control.period)) * axis.axis.control.period
    return size * np.clip(1.5 * np.sin(2 * np.pi * t / 0.4), -1, 1)


def period_of(axis: GeneratedAxis) -> float:
    return axis.axis.control.period


@pytest.mark.slow
@pytest.mark.parametrize("name", AXES)
@settings(max_examples=8)
@given(data=st.data())
def test_native_code_and_virtual_machine_agree(name: str, data: st.DataObject) -> None:
    axis, machine = built(name), built(name, native=False)
    factors = data.draw(st.lists(st.floats(0.5, 1.5), min_size=len(axis.parameters)))
    theta = axis.nominal * factors[: len(axis.parameters)]
    seed = data.draw(st.integers(0, 1000))
    reference = motion_of(axis)
    law = axis.axis.control
    noise = 1e-6 * np.random.default_rng(seed).normal(size=len(reference))
    options: dict[str, Any] = {
        "position_noise": data.draw(st.sampled_from([None, noise])),
        "injected": data.draw(st.sampled_from([None, 0.2 * np.sin(np.arange(len(reference)))])),
        "resolution": 0.0 if law.continuous else data.draw(st.sampled_from([0.0, 1e-6])),
        "substeps": data.draw(st.sampled_from([None, 1, 3])),
    }
    native = simulate(axis, theta, reference, law.period, **options)
    virtual = simulate(machine, theta, reference, law.period, **options)
    for field in (*FIELDS, "direction_before", "measured_position"):
        got, expected = getattr(native, field), getattr(virtual, field)
        scale = max(np.abs(expected).max(), 1e-12)
        assert np.abs(got - expected).max() <= 1e-9 * scale, field


@pytest.mark.slow
@pytest.mark.parametrize("name", AXES)
def test_rows_satisfy_the_model_and_a_stuck_axis_rests(name: str) -> None:
    axis = built(name)
    theta = axis.nominal
    loop = simulate(axis, theta, motion_of(axis), period_of(axis))
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


def pendulum_events(
    theta: np.ndarray, forces: np.ndarray, period: float, start: float
) -> np.ndarray:
    """Positions of the open pendulum by an integrator that locates its reversals."""
    J, mgl, fc = map(float, theta)
    body = EventIntegrator(lambda q, _, tau, s, __: (tau - mgl * math.sin(q) - fc * s) / J, start)
    positions = []
    for tau in forces:
        positions.append(body.q)
        body.advance(lambda *_, tau=float(tau): tau, period, held=True)
    return np.array(positions)


def pendulum_forces() -> np.ndarray:
    t = np.arange(800) * 5e-3
    return 0.6 * np.sin(2 * np.pi * 0.8 * t) * (t < 1.6)


def test_pendulum_with_coulomb_friction_is_within_1e_8_rad_of_another_integrator() -> None:
    axis = built("open_pendulum")
    theta = np.array([0.0626, 1.0, 0.2])
    forces = pendulum_forces()
    loop = simulate(axis, theta, forces, 5e-3, start=0.3)
    expected = pendulum_events(theta, forces, 5e-3, 0.3)
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


def test_continuous_law_is_the_differential_equation() -> None:
    """The loop as one equation, friction crossings and breakaway located."""
    axis = built("continuous")
    M, Fv, Fc = theta = np.array([100.2, 236.9, 24.8])
    reference = 0.006 - 0.006 * np.cos(2 * np.pi * np.arange(800) / 400)
    loop = simulate(axis, theta, reference, PERIOD)
    assert np.abs(loop.control).max() < 9
    body = EventIntegrator(lambda _, v, tau, s, __: float((tau - Fv * v - Fc * s) / M), 0.0)
    positions = []
    for here, ahead in zip(reference, np.append(reference[1:], reference[-1]), strict=True):

        def force(
            t: float, q: float, v: float, r: float = here, rate: float = ahead - here
        ) -> float:
            return float(35.15 * 243.45 * (160.18 * (r + rate * t / PERIOD - q) - v))

        positions.append(body.q)
        body.advance(force, PERIOD, held=False)
    assert np.abs(loop.position - positions).max() < 2e-9


def test_encoder_counts_are_what_the_law_measures() -> None:
    axis, resolution = built("offset"), 1e-5
    loop = simulate(axis, axis.nominal, sine(1.0, 0.01, 0.5), PERIOD, resolution=resolution)
    counts = loop.measured_position / resolution
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    assert np.abs(loop.measured_position - loop.position).max() <= resolution / 2 * (1 + 1e-9)
    expected = 243.45 * (160.18 * (sine(1.0, 0.01, 0.5) - loop.measured_position) - loop.velocity)
    assert loop.control == pytest.approx(np.clip(expected, -10, 10), abs=1e-6)


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
def test_failing_lane_does_not_end_the_others() -> None:
    axis = build(replace(AXES["offset"], drive=Drive(gain=35.15)))
    theta = np.tile(axis.nominal, (3, 1))
    theta[1, 0] = 0.1
    reference = motion_of(axis)
    batch = simulate_batch(axis, theta, reference, PERIOD)
    assert set(batch.failures) == {1}
    stopped = int(np.flatnonzero(np.isnan(batch["force"][:, 1]))[0])
    assert re.search(f"at sample {stopped} .* with M = 0.1 kg", batch.failures[1])
    single = simulate(axis, theta[0], reference, PERIOD)
    # The light lane asks for more steps in a sample, of all lanes.
    for lane in (0, 2):
        assert batch["position"][:, lane] == pytest.approx(single.position, abs=1e-10)


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


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        ({"parameters": [1.0, 2.0]}, "simulation-input", r"4 parameters .* the shape \(2,\)"),
        ({"parameters": [[1.0]]}, "simulation-input", r"\(1, 1\)"),
        ({"reference": []}, "simulation-input", r"reference \(0,\)"),
        ({"reference": [0.0, np.nan]}, "simulation-input", ""),
        ({"period": 0.0}, "time", "0.0"),
        ({"period": np.nan}, "time", "nan"),
        ({"position_noise": [0.0]}, "simulation-input", r"noise has the shape \(1,\); give \(3,\)"),
        ({"position_noise": [0.0, np.nan, 0.0]}, "simulation-input", ""),
        ({"injected": [0.0]}, "simulation-input", r"injected signal has the shape \(1,\)"),
        ({"resolution": -1.0}, "simulation-input", "-1.0"),
        ({"axis": "continuous", "resolution": 1e-6}, "simulation-input", "1e-06"),
        ({"substeps": -2}, "simulation-input", "-2"),
        ({"substeps": 10**19}, "simulation-input", "1000"),
    ],
)
def test_bad_arguments_are_explained(arguments: dict[str, Any], code: str, says: str) -> None:
    given: dict[str, Any] = {"reference": [0.0, 1e-3, 0.0], "period": PERIOD, **arguments}
    axis = built(given.pop("axis", "offset"))
    with refuses(code, says):
        simulate(axis, **{"parameters": axis.nominal, **given})


@pytest.mark.parametrize(
    ("change", "code", "says"),
    [
        ({"parameters": np.ones((2, 3))}, "simulation-input", "has 4 parameters"),
        ({"reference": np.zeros((5, 3))}, "simulation-input", r"\(5, 3\)"),
        ({"position_noise": np.zeros((5, 3))}, "simulation-input", ""),
        ({"injected": np.zeros(4)}, "simulation-input", ""),
        ({"wanted": ("speed",)}, "simulation-input", "speed"),
        ({"start": [0.0]}, "simulation-input", ""),
        ({"parameters": np.ones((0, 4))}, "simulation-input", ""),
        ({"wanted": "position"}, "simulation-input", ""),
        ({"wanted": ("before",)}, "simulation-input", "direction_before"),
    ],
)
def test_bad_batches_are_explained(change: dict[str, Any], code: str, says: str) -> None:
    given: dict[str, Any] = {
        "parameters": np.tile(built("offset").nominal, (2, 1)),
        "reference": np.zeros(5),
        **change,
    }
    with refuses(code, says):
        simulate_batch(built("offset"), period=PERIOD, **given)


TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}
REFERENCE = 0.01 * np.sin(np.arange(200) / 20.0)


def test_parameters_by_name_are_those_in_order(emps2015: GeneratedAxis) -> None:
    turned = dict(reversed(TRUTH.items()))
    ordered = [TRUTH[name] for name in emps2015.names]
    alone = simulate(emps2015, turned, REFERENCE, 1e-3)
    assert alone == simulate(emps2015, ordered, REFERENCE, 1e-3)
    masses = np.array([20.0, 24.8, 30.0])  # the others are shared
    lanes = simulate_batch(emps2015, {**TRUTH, "Fc": masses}, REFERENCE, 1e-3)
    np.testing.assert_array_equal(lanes["position"][:, 1], alone.position)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"M": 100.0, "Fv": 200.0}, "Fc is missing"),
        ({**TRUTH, "m": 1.0}, "'m' is no parameter; give a value of each of M, Fv, Fc"),
        ({**TRUTH, "M": np.ones(2), "Fc": np.ones(3)}, r"M \(2,\), Fv \(\), Fc \(3,\)"),
    ],
)
def test_names_that_are_not_those_of_the_axis_are_refused(
    emps2015: GeneratedAxis, given: dict[str, Any], says: str
) -> None:
    with refuses("simulation-input", says=says):
        simulate(emps2015, given, REFERENCE, 1e-3)


PERIOD = 1e-3
SECONDS = PERIOD * np.arange(1500)
SINE = 0.005 * (1 - np.cos(2 * np.pi * SECONDS))
ADDED = 0.3 * np.sin(2 * np.pi * 7 * SECONDS) + 0.2 * np.sin(2 * np.pi * 23 * SECONDS)


@pytest.fixture(scope="module")
def loop_axis() -> GeneratedAxis:
    return build(load_axis("emps"))


def _law(axis: GeneratedAxis, reference: np.ndarray, position: np.ndarray) -> np.ndarray:
    law = axis.axis.control
    before = np.concatenate([position[:1], position[:1], position[:-2]])
    speed = (position - before) / (2 * PERIOD)
    return np.asarray(law.gains["kv"] * (law.gains["kp"] * (reference - position) - speed))


def test_control_is_the_law_and_what_is_added_to_it(loop_axis: GeneratedAxis) -> None:
    loop = simulate(loop_axis, loop_axis.nominal, SINE, PERIOD, injected=ADDED)
    expected = _law(loop_axis, SINE, loop.position) + ADDED
    np.testing.assert_allclose(loop.control, expected, atol=1e-9)
    gain = loop_axis.axis.drive.gain
    np.testing.assert_allclose(loop.force, gain * loop.control, rtol=1e-13)


def test_what_is_added_is_within_the_limit_with_the_law(loop_axis: GeneratedAxis) -> None:
    limit = loop_axis.axis.drive.limit
    loop = simulate(loop_axis, loop_axis.nominal, SINE, PERIOD, injected=40 * ADDED)
    expected = np.clip(_law(loop_axis, SINE, loop.position) + 40 * ADDED, -limit, limit)
    np.testing.assert_allclose(loop.control, expected, atol=1e-9)
    assert np.abs(loop.control).max() == limit


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
def test_a_continuous_law_has_it_held_over_the_sample(*, native: bool) -> None:
    axis = load_axis("emps")
    coarse, fine = (
        build(replace(axis, control=_continuous(period), experiment=None), native=native)
        for period in (PERIOD, PERIOD / 5)
    )
    reference = np.interp(np.arange(991) / 5, np.arange(199), SINE[:199])
    loop = simulate(coarse, coarse.nominal, SINE[:199], PERIOD, injected=ADDED[:199])
    held = np.repeat(ADDED[:199], 5)[:991]
    five = simulate(fine, fine.nominal, reference, PERIOD / 5, injected=held)
    np.testing.assert_allclose(loop.position, five.position[::5], atol=1e-10)
    without = simulate(coarse, coarse.nominal, SINE[:199], PERIOD)
    assert np.abs(loop.position - without.position).max() > 1e-6


def _continuous(period: float) -> ControlLaw:
    return cascade_pd(kp=160.18, kv=243.45, period=period, continuous=True)


def test_a_loop_that_only_the_signal_moves_is_no_runaway(loop_axis: GeneratedAxis) -> None:
    still = np.zeros(1500)
    still[0] = 1e-12
    loop = simulate(loop_axis, loop_axis.nominal, still, PERIOD, start=0.0, injected=ADDED)
    assert np.ptp(loop.position) > 1e-6
