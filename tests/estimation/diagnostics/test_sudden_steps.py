"""A position that no body follows is named: lost samples, an encoder that stood still."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostics.sudden_steps import sudden_steps, sudden_steps_check
from axisid.estimation.records import wild_steps


@pytest.fixture(scope="module")
def fastest(twin: Record) -> int:
    """The sample about which the axis is fastest."""
    speed = np.convolve(np.abs(np.diff(twin.position)), np.ones(41) / 41, "valid")
    return 20 + int(np.argmax(speed))


def test_a_motion_has_none(emps2015: GeneratedAxis, twin: Record) -> None:
    assert sudden_steps(twin) == []
    check = sudden_steps_check(emps2015, twin)
    assert check is not None
    assert check.status == "pass"


@pytest.mark.parametrize("lost", [3, 40])
def test_lost_samples_are_a_step_of_position_and_reference(
    emps2015: GeneratedAxis, twin: Record, fastest: int, lost: int
) -> None:
    kept = np.delete(np.arange(len(twin)), np.arange(fastest, fastest + lost))
    assert twin.reference is not None
    shorter = replace(
        twin,
        time=twin.time[: len(kept)],
        position=twin.position[kept],
        reference=twin.reference[kept],
        control=np.asarray(twin.control)[kept],
    )
    (step,) = sudden_steps(shorter)
    assert (step.place, step.is_asked) == (fastest - 1, True)
    check = sudden_steps_check(emps2015, shorter)
    assert check is not None
    assert (check.status, check.figure) == ("fail", 1.0)


def test_an_encoder_that_stands_still_and_catches_up_is_a_step_of_the_position_alone(
    twin: Record, fastest: int
) -> None:
    position = np.array(twin.position)
    position[fastest : fastest + 10] = position[fastest]
    (step,) = sudden_steps(replace(twin, position=position))
    assert (step.place, step.held, step.is_asked) == (fastest + 9, 9, False)
    moved = twin.position[fastest + 10] - twin.position[fastest]
    assert step.size == pytest.approx(moved)


def test_a_gap_that_the_times_show_is_none(twin: Record, fastest: int) -> None:
    parts = twin.windowed((None, twin.time[fastest]), (twin.time[fastest + 40], None))
    assert sudden_steps(parts) == []


def test_masked_samples_are_no_steps(twin: Record, fastest: int) -> None:
    position = np.array(twin.position)
    position[fastest : fastest + 10] = position[fastest]
    masked = replace(twin, position=position, masked=((fastest, fastest + 10),))
    assert sudden_steps(masked) == []


def test_a_sample_that_is_recorded_twice_is_a_step_smaller_than_the_motion(
    twin: Record, fastest: int
) -> None:
    places = np.sort(np.append(np.arange(len(twin) - 1), fastest))
    assert twin.reference is not None
    again = replace(
        twin,
        position=twin.position[places],
        reference=twin.reference[places],
        control=np.asarray(twin.control)[places],
    )
    (step,) = sudden_steps(again)
    assert (step.place, step.is_asked, step.is_repeat) == (fastest, True, True)


def test_a_position_that_starts_again_steps_against_its_motion(twin: Record) -> None:
    turn = 0.7 * float(np.ptp(twin.position))
    wrapped = replace(twin, position=(twin.position - twin.position.min()) % turn, reference=None)
    steps = sudden_steps(wrapped)
    assert len(steps) == 6
    assert all(step.is_new_turn for step in steps)


def test_a_move_within_one_sample_period_from_rest_to_rest_is_none(twin: Record) -> None:
    position = np.array(twin.position)
    position[3000:] = position[3000]
    position[3500:] += 0.1
    assert sudden_steps(replace(twin, position=position)) == []


@pytest.mark.parametrize("length", range(1, 8))
def test_a_piece_of_a_few_samples_has_none(length: int) -> None:
    assert (
        wild_steps(np.array([0.0, 0.1, 0.2, 5.0, 0.4, 0.5, 0.6, 0.7])[:length], [(0, length)]).size
        == 0
    )


def test_rows_lost_in_every_buffer_do_not_hide_each_other(twin: Record) -> None:
    kept = np.delete(np.arange(len(twin)), np.arange(100, len(twin), 128))
    assert twin.reference is not None
    shorter = replace(
        twin,
        time=twin.time[: len(kept)],
        position=twin.position[kept],
        reference=twin.reference[kept],
        control=np.asarray(twin.control)[kept],
    )
    steps = sudden_steps(shorter)
    assert len(steps) > 1
    assert all(step.is_asked for step in steps)


def test_short_pieces_of_a_motion_have_none(twin: Record) -> None:
    pieces = [(twin.time[k], twin.time[k + 9]) for k in range(0, len(twin) - 15, 15)]
    assert sudden_steps(twin.windowed(*pieces)) == []
