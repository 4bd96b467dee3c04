"""A law whose clock is not the log's is simulated as it runs and sampled as the log is."""

import re
from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Axis,
    Record,
    UsageError,
    build,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import BALANCED, ControlLaw, cascade_pd_averaged
from axisid.estimation import law_agreement
from axisid.estimation.diagnostics.control_law import LawReproduced
from axisid.estimation.law_replay import two_clocks
from axisid.estimation.regression.simulated_instruments import simulated_loops
from axisid.estimation.simulation import TwoClocks, signals_about
from axisid.modeling import Experiment, Move, back_and_forth
from axisid.support.missing import Missing
from benchmarks.motor_joint import joint, on_voltage
from tests.axes.lagging import lagging
from tests.axes.remembering import dahl_axis
from tests.estimation.simulation.agreement import LANES, agree
from tests.estimation.simulation.test_initial_state import THETA, by_events, p_pi, stage
from tests.law_findings import law_finding_of
from tests.refusals import refuses
from tests.unjudged import identify

MOVES = back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=1.0, repeat=2)
SHORT = back_and_forth(speeds=(0.04, 0.12), acceleration=0.8, seconds=0.5, repeat=1)
LOG = 1e-3
TRUTH = dict(zip(("M", "Fv", "Fc", "F0"), THETA, strict=True))


def cascade(period: float) -> ControlLaw:
    return cascade_pd_averaged(kp=160.18, kv=243.45, period=period)


def cascade_p_pi(period: float) -> ControlLaw:
    return replace(p_pi(BALANCED), period=period)


def logged(
    axis: GeneratedAxis, period: float, noise: float = 0.0, moves: tuple[Move, ...] = MOVES
) -> Record:
    """The axis's loop with its set point made at every evaluation, as a log of another period."""
    experiment = Experiment(moves=moves, truth=TRUTH, position_noise=noise)
    twin = build(replace(axis.declared, experiment=experiment))
    return twin_record(twin, sample_period=period)


@pytest.mark.parametrize(
    ("between", "expected"),
    [("linear", [0, 4, 8, 36, 64, 64]), ("held", [0, 0, 8, 8, 64, 64])],
)
def test_a_reference_runs_between_samples_as_declared_or_smoothly(
    between: str, expected: list[float]
) -> None:
    clocks = TwoClocks(samples=3, log_period=1.0, law_period=0.5, between=between)
    assert clocks.reference(np.array([0.0, 8.0, 64.0])).tolist() == expected
    smooth = TwoClocks(samples=6, log_period=1.0, law_period=0.5)
    assert smooth.reference(np.arange(6.0) ** 3) == pytest.approx(smooth.times.clip(max=5.0) ** 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "log"),
    [
        (cascade(0.25e-3), 1e-3),
        (cascade_p_pi(1 / 16e3), 1e-3),
        (cascade_p_pi(0.4e-3), 1e-3),
        (cascade(1e-3), 0.25e-3),
        (cascade_p_pi(1e-3), 0.4e-3),
    ],
    ids=["4 kHz at 1 kHz", "P-PI of 16 kHz at 1 kHz", "2.5 times", "slower", "0.4 times"],
)
def test_instruments_are_within_a_fifth_of_a_percent(law: ControlLaw, log: float) -> None:
    axis = stage(law)
    record = logged(axis, log)
    estimate = identify(axis, record, methods=["idm-iv"])["idm-iv"]
    assert estimate.physical == pytest.approx(THETA, rel=2e-3)
    check = law_agreement(axis, record)
    assert check.passed
    assert check.residual_percent < 0.1
    (loop,) = simulated_loops(axis, record, THETA)
    assert np.abs(loop.position - record.position).max() < 1e-5


@pytest.mark.slow
def test_the_law_check_says_what_the_log_leaves_open_and_finds_a_wrong_law() -> None:
    law = cascade_p_pi(1 / 16e3)
    axis = stage(law)
    check = law_agreement(axis, logged(axis, 1e-3, noise=1e-8))
    assert check.passed
    assert 0 < law_finding_of(check, LawReproduced).open_percent < 1
    blurred = law_agreement(axis, logged(axis, 1e-3, noise=1e-6))
    assert isinstance(blurred, Missing)
    assert re.search(r"[0-9.]+ % of the control", blurred.reason)
    record = logged(axis, 1e-3, noise=1e-8, moves=SHORT)
    for name in ("kp", "kv"):
        wrong = replace(law, gains={**law.gains, name: 1.1 * law.gains[name]})
        assert not law_agreement(stage(wrong), record).passed


@pytest.mark.slow
@pytest.mark.parametrize("late", range(4))
def test_a_faster_log_tells_when_its_law_is_evaluated(late: int) -> None:
    axis = stage(cascade(1e-3))
    record = logged(axis, 0.25e-3)
    part = record.windowed((late * record.period, None))
    clocks = two_clocks(axis, part, (0, len(part)))
    assert clocks.first == pytest.approx(-late * 0.25e-3)
    check = law_agreement(axis, part)
    assert check.passed
    assert check.delay == 0


WAVE = 0.01 * np.sin(2 * np.pi * 6 * LOG * np.arange(160))


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
    noise = 1e-6 * np.random.default_rng(0).normal(size=(160, LANES))
    given = np.outer(1.1 * sizes, THETA), np.outer(WAVE, sizes), LOG
    agree(stage(cascade_p_pi(LOG / ratio)), *given, position_noise=noise)


@pytest.mark.slow
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
    with pytest.raises(UsageError, match=r"evaluated every 0\.001 s\. .* at most 400"):
        simulate(stage(cascade(LOG)), THETA, WAVE, 1.0)
    with pytest.raises(UsageError, match=r"the sampling period is -1"):
        twin_record(twin_axis(4.0), sample_period=-1)


@pytest.mark.parametrize(
    "declared", [lagging(lag=1e-3), joint(on_voltage()), dahl_axis()], ids=lambda axis: axis.name
)
def test_a_drive_or_a_friction_that_remembers_is_known_at_the_clock_of_its_law_alone(
    declared: Axis,
) -> None:
    axis = build(declared, native=False)
    with refuses("loop-period"):
        simulate(axis, axis.nominal, np.zeros(30), 0.7 * axis.axis.control.period)
