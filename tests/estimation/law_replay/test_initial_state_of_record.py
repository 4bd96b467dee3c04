"""A law runs along a record, and its loop begins as the record does, not only at rest."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import Record, build, load_axis, simulate, twin_record
from axisid.codegen import GeneratedAxis
from axisid.control import BALANCED
from axisid.estimation import law_agreement
from axisid.estimation.law_replay import (
    LawInputs,
    LawReplay,
    control_along,
    law_along,
    law_ticks,
    start_of_law,
    state_at_rest,
)
from axisid.estimation.law_replay.initial_state_of_record import (
    START_SAMPLES,
    first_memory,
    loop_starts,
)
from axisid.estimation.law_replay.initial_velocity import first_velocity
from axisid.estimation.regression.simulated_instruments import simulated_loops
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import LIBRARY
from axisid.modeling.declaration.experiment import back_and_forth
from tests.axes.ready_laws import LAWS, with_law
from tests.axes.simulated import AXES
from tests.estimation.simulation.test_initial_state import THETA, T, vertical

REFERENCE = trajectory(
    back_and_forth(speeds=(0.05, 0.1), acceleration=0.8, seconds=1.0, repeat=2), T
)
HUNDREDTH_MM = 1e-5


def carried(delay: int, noise: float = 0.0, cut: int = 0) -> tuple[Record, np.ndarray]:
    """A record of a vertical axis whose integral holds its load, and its true positions."""
    added = noise * np.random.default_rng(1).normal(size=len(REFERENCE))
    loop = simulate(vertical(BALANCED, delay), THETA, REFERENCE, T, position_noise=added)
    record = Record(
        time=loop.time[cut:],
        position=loop.measured_position[cut:],
        reference=REFERENCE[cut:],
        control=loop.control[cut:],
        sample_period=T,
    )
    return record, loop.position[cut:]


@pytest.mark.slow
@pytest.mark.parametrize(("delay", "noise"), [(0, 1e-6), (2, 0.0)])
@pytest.mark.parametrize("start", [0, BALANCED], ids=["at zero", "balanced"])
@pytest.mark.parametrize("cut", [0, 300, 1500], ids=["from rest", "in motion", "going back"])
def test_a_load_that_an_integral_holds_neither_drops_nor_disturbs_the_law(
    delay: int, start: object, cut: int, noise: float
) -> None:
    record, position = carried(delay, noise, cut)
    axis = vertical(start, delay)
    check = law_agreement(axis, record)
    assert check.passed
    assert check.residual_percent < 1e-6
    (loop,) = simulated_loops(axis, record, THETA)
    assert np.abs(loop.position - position).max() < HUNDREDTH_MM


def test_each_segment_begins_with_what_its_drive_remembers_there() -> None:
    record, position = carried(0)
    gap = 700
    kept = np.r_[0:gap, gap + 400 : len(record)]
    parted = replace(
        record,
        **{role: values[kept] for role, values in record.channels().items()},
        segments=((0, gap), (gap, len(kept))),
    )
    axis = vertical(0)
    loops = simulated_loops(axis, parted, THETA)
    assert np.abs(np.concatenate([s.position for s in loops]) - position[kept]).max() < HUNDREDTH_MM


# The integral of the servo joint's law holds its load from the first sample on; the valve's drive
# remembers commands that are to act.
@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in LIBRARY if n not in ("servo_joint", "valve")])
def test_records_that_start_at_rest_start_at_rest(name: str) -> None:
    axis = build(load_axis(name))
    for seed in range(3):
        (start,) = loop_starts(axis, twin_record(axis, seed=seed))
        assert start.velocity == 0.0
        assert start.memory is None


def test_the_velocity_of_a_record_that_moves_is_found_within_noise(
    emps2015: GeneratedAxis, rng: np.random.Generator
) -> None:
    time = 1e-3 * np.arange(400)
    for _ in range(30):
        velocity, acceleration = rng.uniform(0.01, 0.2), rng.normal()
        jerk = 20 * rng.normal()
        motion = velocity * time + acceleration * time**2 / 2 + jerk * time**3 / 6
        measured = motion + 1e-7 * rng.normal(size=len(time))
        assert first_velocity(measured, 1e-3) == pytest.approx(velocity, abs=1.5e-3)


@pytest.mark.parametrize("count", [2, 5, 9, 1000])
def test_an_axis_that_stands_has_no_velocity(count: int, rng: np.random.Generator) -> None:
    assert first_velocity(np.full(count, 0.1), 1e-3) == 0.0
    assert first_velocity(1e-6 * rng.normal(size=count), 1e-3) == 0.0
    assert first_velocity(1e-5 * np.round(rng.normal(size=count)), 1e-3) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 1e-6])
@pytest.mark.parametrize("name", ["vertical_screw", "belt_axis", "rotary_table", "servo_joint"])
def test_a_record_cut_from_a_fast_move_begins_with_what_its_law_remembers(
    name: str, noise: float
) -> None:
    """From rest the law takes it for a leap, and is at its limit whatever it remembers."""
    declared = load_axis(name)
    experiment = replace(declared.experiment, position_noise=noise, resolution=0.0)
    axis = build(replace(declared, experiment=experiment))
    whole = twin_record(axis)
    assert whole.control is not None
    moves = np.abs(np.diff(whole.position, append=whole.position[-1]))
    first = int(np.flatnonzero(moves > 0.7 * moves.max())[20])
    record = whole.windowed((first * whole.period, (first + 4000) * whole.period))
    ticks = law_ticks(axis, record, (0, len(record))).first(START_SAMPLES)
    memory = first_memory(axis, record, (0, len(record)))
    there = control_along(axis, ticks, memory)
    np.testing.assert_allclose(there, record.control[:START_SAMPLES], rtol=1e-6)
    leap = control_along(axis, ticks, state_at_rest(axis, ticks))
    assert np.abs(leap - there).max() > 3.0


def test_a_late_law_with_an_integral_is_the_sum_by_hand(rng: np.random.Generator) -> None:
    axis = build(AXES["delayed"], native=False)
    reference, position, velocity = rng.normal(size=(3, 50))
    ticks = LawInputs.at_samples(reference, position, velocity)
    error = reference - position
    total = np.cumsum(error) - error  # before each evaluation
    made = 150.0 * (60.0 * error + 1e-5 * total / 1e-3 - velocity)
    late = np.concatenate([made[:1], made[:1], made[:-2]])
    along = law_along(axis, ticks, state_at_rest(axis, ticks))
    np.testing.assert_allclose(along, late, rtol=1e-12, atol=1e-12)


def test_what_is_added_to_a_late_law_is_as_late(rng: np.random.Generator) -> None:
    added = rng.normal(size=9)
    ticks = LawInputs.at_samples(*np.zeros((3, 9)), added=added)
    assert ticks.added_at_samples(2).tolist() == [0.0, 0.0, *added[:-2]]


@cache
def _along(name: str, limit: float = 10.0) -> LawReplay:
    axis = with_law(name, limit)
    record = twin_record(axis)
    whole = (0, len(record))
    ticks = law_ticks(axis, record, whole)
    along = LawReplay.of(axis, LAWS[name](), ticks, record)
    start = start_of_law(axis, record, whole, ticks)
    return replace(along, start=start)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "limit"),
    [("cascade_p_pi, feed-forward", 10.0), ("cascade_p_pi, back-calculation", 3.2), ("pid", 10.0)],
)
def test_a_run_by_gains_is_the_generated_law(name: str, limit: float) -> None:
    along = _along(name, limit)
    wanted = control_along(with_law(name, limit), along.ticks, along.start)
    given = np.clip(along.output, -limit, limit)
    np.testing.assert_allclose(given, wanted, atol=1e-9)
    np.testing.assert_allclose(given, along.control, atol=1e-9)


def test_slopes_are_those_of_the_output() -> None:
    along = _along("cascade_p_pi")
    by_gain, by_start = along.jacobian_by_gain(), along.slopes_by_start(np.asarray)
    assert by_gain.shape == (len(along.control), 3)
    # All of the output is a multiple of kv; the integral's start stands in it over tn.
    np.testing.assert_allclose(by_gain[:, 1], along.output, rtol=1e-6, atol=1e-6)
    kv, tn = along.law.gains["kv"], along.law.gains["tn"]
    np.testing.assert_allclose(by_start[1], kv / tn, rtol=1e-5)
    assert len(by_start) == 2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cascade_p_pi, clamped", "pid_ideal"])
def test_gains_that_are_7_percent_off_are_found_again(name: str) -> None:
    along = _along(name)
    off = replace(along, gains=1.07 * along.gains)
    found = off.fitted(lambda control: control[10:], range(len(along.gains)))
    np.testing.assert_allclose(found.gains, along.gains, rtol=1e-6)
