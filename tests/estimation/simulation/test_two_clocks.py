"""What a user simulates with a period of his own is the loop at its law's period, sampled so."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    UsageError,
    build,
    simulate,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.simulation import (
    TwoClocks,
    signals_about,
)
from axisid.modeling import Experiment, back_and_forth
from tests.estimation.loops.test_two_clocks import LOG, cascade, cascade_p_pi, stage
from tests.estimation.simulation.agreement import LANES, agree
from tests.estimation.simulation.test_loop_start import THETA, by_events

WAVE = 0.01 * np.sin(2 * np.pi * 6 * LOG * np.arange(160))
TRUTH = dict(zip(("M", "Fv", "Fc", "F0"), THETA, strict=True))


def twin_axis(ratio: float, between: str = "") -> GeneratedAxis:
    """The stage with an experiment, its loop so many times as fast as the log."""
    axis = stage(replace(cascade_p_pi(LOG / ratio), reference_between=between)).declared
    moves = back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=1.0, repeat=2)
    experiment = Experiment(moves=moves, truth=TRUTH, position_noise=0.0)
    return build(replace(axis, experiment=experiment))


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [4.0, 2.5, 0.4, 0.25])
def test_a_loop_of_another_period_follows_an_independent_integrator(ratio: float) -> None:
    law = replace(cascade_p_pi(LOG / ratio), reference_between="linear")
    axis = stage(law)
    loop = simulate(axis, THETA, WAVE, LOG, start=0.0)
    times = np.arange(np.ceil((len(WAVE) - 1) * ratio) + 1) / ratio
    expected = by_events(np.interp(times, np.arange(160), WAVE), law.period, LOG * np.arange(160))
    assert np.allclose(loop.time, LOG * np.arange(160))
    assert np.abs(loop.position - expected).max() < (2e-9 if ratio > 1 else 2e-7)


@pytest.mark.parametrize("ratio", [4, 0.25])
def test_before_a_sample_the_force_is_that_of_the_evaluation_before_it(ratio: float) -> None:
    law = replace(cascade_p_pi(LOG / ratio), reference_between="held")
    axis = build(stage(law).declared, native=False)
    wave = WAVE[:41]
    log = simulate(axis, THETA, wave, LOG, start=0.0)
    read = wave[np.floor(np.arange(40 * ratio + 1) / ratio).astype(int)]
    own = simulate(axis, THETA, read, law.period, start=0.0).force
    now = np.arange(41) * ratio
    before, after = signals_about(axis, np.array(THETA), log)[::-1]
    assert np.array_equal(after.force, own[np.floor(now).astype(int)])
    assert np.array_equal(before.force[1:], own[np.ceil(now[1:] - 1).astype(int)])


def test_what_is_held_enters_a_slower_law_by_its_mean_until_the_next_evaluation() -> None:
    clocks = TwoClocks(samples=6, log_period=1.0, law_period=2.2)
    mean = clocks.mean_held(np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0]))
    first, second, until_the_end = 1 + 2 + 0.2 * 4, 0.8 * 4 + 8 + 0.4 * 16, 0.6 * 16 + 32
    assert mean == pytest.approx([first / 2.2, second / 2.2, until_the_end / 1.6, 32.0])


RESTS = np.concatenate([np.linspace(0, 0.01, 40), np.full(60, 0.01), np.linspace(0.01, 0, 40)])


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
def test_a_log_between_evaluations_knows_of_every_stop(native: bool) -> None:
    law = replace(cascade_p_pi(10 * LOG), reference_between="held")
    axis = build(stage(law).declared, native=native)
    times = LOG * np.arange(10 * len(RESTS))
    expected = by_events(RESTS, law.period, times)
    loop = simulate(axis, THETA, np.repeat(RESTS, 10), LOG, start=0.0)
    assert np.abs(loop.position - expected).max() < 1e-7 * np.ptp(expected)
    still = np.diff(expected) == 0
    rests = np.flatnonzero(still[:-1] & still[1:]) + 1
    assert len(rests) > 50
    assert np.all(loop.velocity[rests] == 0)
    assert np.all(loop.acceleration[rests] == 0)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [4.0, 0.4])
def test_lanes_of_another_period_are_single_loops(ratio: float) -> None:
    sizes = np.linspace(0.5, 1.0, LANES)
    lanes, noise = (
        np.outer(1.1 * sizes, THETA),
        1e-6 * np.random.default_rng(0).normal(size=(160, LANES)),
    )
    axis = stage(cascade_p_pi(LOG / ratio))
    agree(axis, lanes, np.outer(WAVE, sizes), LOG, position_noise=noise)


@pytest.mark.parametrize("between", ["linear", "held"])
def test_a_twin_s_set_point_runs_between_samples_as_its_law_declares(between: str) -> None:
    axis = twin_axis(4.0, between)
    record = twin_record(axis, sample_period=LOG)
    loop = simulate(axis, THETA, record.reference, LOG)
    assert np.array_equal(loop.position, record.position)
    assert np.array_equal(loop.control, record.control)


def test_a_measured_velocity_and_acceleration_are_those_at_the_samples_of_the_log() -> None:
    record = twin_record(
        twin_axis(4.0), sample_period=LOG, velocity_noise=0.0, acceleration_noise=0.0
    )
    velocity, position = np.asarray(record.velocity), record.position
    central = (position[2:] - position[:-2]) / (2 * LOG)
    assert np.median(np.abs(velocity[1:-1] - central)) < 1e-5
    slope = (velocity[2:] - velocity[:-2]) / (2 * LOG)
    assert np.median(np.abs(np.asarray(record.acceleration)[1:-1] - slope)) < 1e-2


def test_a_period_in_another_unit_is_refused() -> None:
    with pytest.raises(UsageError, match=r"evaluated every 0\.001 s; give one that is at most 400"):
        simulate(stage(cascade(LOG)), THETA, WAVE, 1.0)
    with pytest.raises(UsageError, match=r"the sampling period is -1"):
        twin_record(twin_axis(4.0), sample_period=-1)
