"""A position that no body follows is named: lost samples, an encoder that stood still."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.diagnostics.sudden_steps import sudden_steps, sudden_steps_check


@pytest.fixture(scope="module")
def axis() -> GeneratedAxis:
    return build(load_axis("emps2015"))


@pytest.fixture(scope="module")
def record(axis: GeneratedAxis) -> Record:
    return twin_record(axis, seed=3)


@pytest.fixture(scope="module")
def fastest(record: Record) -> int:
    """The sample about which the axis is fastest."""
    speed = np.convolve(np.abs(np.diff(record.position)), np.ones(41) / 41, "valid")
    return 20 + int(np.argmax(speed))


def test_a_motion_has_none(axis: GeneratedAxis, record: Record) -> None:
    assert sudden_steps(record) == []
    check = sudden_steps_check(axis.axis, record)
    assert check is not None
    assert check.status == "pass"


@pytest.mark.parametrize("lost", [1, 3, 40])
def test_lost_samples_are_a_step_of_position_and_reference(
    axis: GeneratedAxis, record: Record, fastest: int, lost: int
) -> None:
    kept = np.delete(np.arange(len(record)), np.arange(fastest, fastest + lost))
    assert record.reference is not None
    shorter = replace(
        record,
        time=record.time[: len(kept)],
        position=record.position[kept],
        reference=record.reference[kept],
        control=np.asarray(record.control)[kept],
    )
    (step,) = sudden_steps(shorter)
    assert (step.place, step.is_asked) == (fastest - 1, True)
    check = sudden_steps_check(axis.axis, shorter)
    assert check is not None
    assert (check.status, check.figure) == ("fail", 1.0)


def test_an_encoder_that_stands_still_and_catches_up_is_a_step_of_the_position_alone(
    record: Record, fastest: int
) -> None:
    position = np.array(record.position)
    position[fastest : fastest + 10] = position[fastest]
    (step,) = sudden_steps(replace(record, position=position))
    assert (step.place, step.held, step.is_asked) == (fastest + 9, 9, False)
    moved = record.position[fastest + 10] - record.position[fastest]
    assert step.size == pytest.approx(moved)


def test_a_gap_that_the_times_show_is_none(record: Record, fastest: int) -> None:
    parts = record.windowed((None, record.time[fastest]), (record.time[fastest + 40], None))
    assert sudden_steps(parts) == []


def test_masked_samples_are_no_steps(record: Record, fastest: int) -> None:
    position = np.array(record.position)
    position[fastest : fastest + 10] = position[fastest]
    masked = replace(record, position=position, masked=((fastest, fastest + 10),))
    assert sudden_steps(masked) == []
