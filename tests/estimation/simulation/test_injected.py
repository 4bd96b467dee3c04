"""A test signal that is added to the control of a simulated loop."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import build, load_axis, simulate
from axisid.codegen.artefacts import GeneratedAxis
from axisid.control import ControlLaw, cascade_pd

PERIOD = 1e-3
TIME = PERIOD * np.arange(1500)
SINE = 0.005 * (1 - np.cos(2 * np.pi * TIME))
ADDED = 0.3 * np.sin(2 * np.pi * 7 * TIME) + 0.2 * np.sin(2 * np.pi * 23 * TIME)


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
