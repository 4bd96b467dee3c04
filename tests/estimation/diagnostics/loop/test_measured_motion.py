"""A measured velocity beside the position's derivative: what is wrong is named, no more."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, identify, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics.loop import (
    ColumnComparison,
    compared_motion,
    motion_check,
)
from axisid.estimation.records import Record as _Record
from axisid.support.errors import Missing

SIZE = 0.08  # m/s


@pytest.fixture(scope="module")
def right(emps: GeneratedAxis) -> Record:
    return twin_record(emps, seed=3, velocity_noise=0.01 * SIZE, acceleration_noise=0.05)


def compared(record: _Record, role: str = "velocity") -> ColumnComparison:
    found = compared_motion(record, role)
    assert isinstance(found, ColumnComparison)
    return found


def checked(axis: GeneratedAxis, record: Record, role: str = "velocity") -> Check | Missing | None:
    found = compared_motion(record, role) if role in record.motion else None
    return motion_check(axis, record, role, found)


def changed(record: Record, factor: float = 1.0, offset: float = 0.0) -> Record:
    return replace(record, velocity=factor * np.asarray(record.velocity) + offset)


@pytest.mark.parametrize("seed", range(1, 6))
def test_a_right_one_passes(emps: GeneratedAxis, seed: int) -> None:
    record = twin_record(emps, seed=seed, velocity_noise=0.01 * SIZE, acceleration_noise=0.05)
    for role in ("velocity", "acceleration"):
        check = checked(emps, record, role)
        assert check.status == "pass", check.meaning


def test_factor_delay_and_offset_are_measured(right: Record) -> None:
    found = compared(changed(right.shifted(velocity=2), 1.05, 0.004))
    assert found.factor == pytest.approx(1.05, abs=3 * found.factor_deviation + 5e-4)
    assert found.delay == pytest.approx(2, abs=3 * found.delay_deviation)
    assert found.offset == pytest.approx(0.004, abs=3 * found.offset_deviation)
    *wrong, left = found.distances.values()
    assert min(wrong) > 1 > left


def test_part_of_a_sample_is_measured(emps: GeneratedAxis) -> None:
    record = twin_record(emps, velocity_noise=0.0)
    behind = np.gradient(record.position, record.period)  # central, so in time
    difference = np.concatenate([[0.0], np.diff(record.position) / record.period])
    assert compared(replace(record, velocity=behind)).delay == pytest.approx(0, abs=0.01)
    assert compared(replace(record, velocity=difference)).delay == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    ("factor", "late", "offset", "advice"),
    [
        (1.0, 3, 0.0, "shift.velocity = -3"),
        (1000.0, 0, 0.0, "columns velocity=NAME:mm/s"),
        (-1.0, 0, 0.0, "columns velocity=NAME:UNIT*-1"),
        (1.0, 0, 0.005, "columns velocity=NAME:UNIT-0.005"),
        (1.05, 0, 0.0, "check its unit and scale"),
    ],
)
def test_what_is_wrong_is_told_with_what_to_do(
    emps: GeneratedAxis, right: Record, factor: float, late: int, offset: float, advice: str
) -> None:
    check = checked(emps, changed(right.shifted(velocity=late), factor, offset))
    assert check.status == "fail"
    assert advice in check.meaning


@pytest.mark.parametrize("what", ["control", "position", "noise", "walk", "constant"])
def test_another_signal_is_no_velocity(emps: GeneratedAxis, right: Record, what: str) -> None:
    noise = np.random.default_rng(1).normal(0, SIZE, len(right))
    others = {
        "control": right.control,
        "position": right.position,
        "noise": noise,
        "walk": np.cumsum(noise) / 30,
        "constant": 0.01 + 1e-9 * right.position,
    }
    check = checked(emps, replace(right, velocity=others[what]))
    assert check.status == "fail"
    assert "is not the position's derivative" in check.meaning


def test_a_noisy_encoder_is_no_factor(emps: GeneratedAxis) -> None:
    for seed in range(4):
        record = twin_record(emps, seed=seed, position_noise=2e-5, velocity_noise=0.01 * SIZE)
        assert compared(record).worst < 1


@pytest.mark.slow
def test_it_stands_in_the_verdict_before_what_follows_from_it(right: Record) -> None:
    emps = build(load_axis("emps"))
    result = identify(emps, changed(right, 1.05), methods="idm-ls")
    assert result.verdict
    failing = [check.name for check in result.verdict if check.status == "fail"]
    assert "measured velocity" in failing
