"""Rows of a sensor in steps, and of a simulated loop."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, identify, simulate, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.regression import InverseForm, sensor_steps
from axisid.estimation.regression.simulated_rows import loop_equations
from tests.axes.bodies import body, force_law

TRUTH = (100.2, 236.9, 24.8)
STEP = 5e-6


def stepped(axis: GeneratedAxis, twin: Record, place: float, step: float = STEP) -> Record:
    """A record with an encoder of a step, whose steps begin elsewhere each time."""
    away = place * step
    noise = np.full(len(twin), away)
    loop = simulate(
        axis, TRUTH, twin.reference + away, twin.period, position_noise=noise, resolution=step
    )
    return replace(twin, position=loop.measured_position - away, control=loop.control)


def test_steps_are_found_in_the_record(emps2015: GeneratedAxis, twin: Record) -> None:
    coarse = stepped(emps2015, twin, 0.3)
    assert sensor_steps(emps2015, coarse).position == pytest.approx(STEP, rel=1e-6)
    lawless = build(replace(emps2015.declared, control=None, experiment=None), native=False)
    assert sensor_steps(lawless, coarse).position == 0


@pytest.mark.slow
def test_intervals_hold_the_mass_that_steps_bias(emps2015: GeneratedAxis, twin: Record) -> None:
    places = (0.04, 0.18, 0.31, 0.47, 0.62, 0.73, 0.86, 0.95)
    held = 0
    for place in places:
        estimate = identify(emps2015, stepped(emps2015, twin, place), methods="idm-iv")["idm-iv"]
        mass = estimate.parameters["M"]
        held += mass.interval[0] < TRUTH[0] < mass.interval[1]
    assert held >= len(places) - 1


def test_a_velocity_in_coarse_steps_is_reckoned_with_unless_its_noise_averages_them(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    velocity = np.asarray(twin_record(emps2015, velocity_noise=0.0).velocity)
    step = 0.02 * float(np.sqrt(np.mean(velocity**2)))
    noise = np.random.default_rng(1).normal(0, 1.5 * step, len(velocity))
    coarse = replace(twin, velocity=step * np.round(velocity / step))
    assert sensor_steps(emps2015, coarse).velocity == pytest.approx(step, rel=1e-6)
    noisy = replace(twin, velocity=step * np.round((velocity + noise) / step))
    assert sensor_steps(emps2015, noisy).velocity == 0
    estimate = identify(emps2015, coarse, methods="idm-iv")["idm-iv"]
    (chain,) = estimate.inference.chains
    assert chain.velocity_step == pytest.approx(step, rel=1e-6)
    for value, true in zip(estimate.parameters.values(), TRUTH, strict=True):
        assert value.interval[0] < true < value.interval[1]


PERIOD = 1e-3


def test_a_held_force_moves_a_free_mass_by_the_mean_of_both_its_sides(
    rng: np.random.Generator,
) -> None:
    axis = build(body(control=force_law(PERIOD)), native=False)
    force = rng.normal(size=30)
    loop = simulate(axis, [2.0], force, PERIOD, start=0.0)
    rows = loop_equations(InverseForm(axis), loop, np.array([2.0]), "zoh")
    central = (loop.velocity[2:] - loop.velocity[:-2]) / (2 * PERIOD)
    np.testing.assert_allclose(rows.regressor[1:-1, 0], central, rtol=0, atol=1e-11)
    np.testing.assert_allclose(rows.left[1:], (force[1:] + force[:-1]) / 2, rtol=1e-12)
