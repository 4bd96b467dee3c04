"""Samples that are among several records more than once are found by what they are."""

from dataclasses import replace

import numpy as np
import pytest

from axisid.estimation.diagnostics.records_alike import overlaps, repeated_check
from axisid.estimation.records import Record, Repairs, read_record


def log(size: int = 3000, *, seed: int = 0, step: float = 0.0) -> Record:
    """A motion with rests; the position and the control in steps where one is given."""
    rng = np.random.default_rng(seed)
    time = 1e-3 * np.arange(size)
    moving = np.sin(12 * time) * (np.sin(2 * time) > 0)
    position = moving + (0 if step else 1e-6 * rng.normal(size=size))
    control = np.gradient(moving, time) + (0.002 if step else 0.02) * rng.normal(size=size)
    if step:
        position, control = step * np.round(position / step), 0.01 * np.round(control / 0.01)
    return Record(time=time, position=position, reference=moving, control=control)


def cut(record: Record, start: int, stop: int, *, absolute: bool = True) -> Record:
    columns = {role: v[start:stop] for role, v in record.channels().items()}
    columns["time"] = columns["time"] - (0 if absolute else columns["time"][0])
    return record.with_channels(columns)


@pytest.mark.parametrize("absolute", [True, False])
def test_records_of_one_log_that_overlap_are_told_with_the_times(absolute: bool) -> None:
    whole = log()
    records = [cut(whole, 0, 2000), cut(whole, 1000, 3000, absolute=absolute)]
    (found,) = overlaps(records)
    assert [int(chosen.sum()) for chosen in found.samples] == [1000, 1000]
    assert found.times[0] == pytest.approx((1.0, 1.999))
    assert found.times[1] == pytest.approx((1.0, 1.999) if absolute else (0.0, 0.999))
    check = repeated_check(records)
    assert check.status == "fail"
    assert check.figure == pytest.approx(1.5)
    assert "1000 samples in common" in check.meaning


def test_a_record_given_three_times_counts_so() -> None:
    records = [log()] * 3
    found = overlaps(records)
    assert len(found) == 3
    assert all(each.is_whole for each in found)
    assert repeated_check(records).figure == 3.0


def test_an_overlap_of_no_weight_is_a_note() -> None:
    whole = log(20_000)
    check = repeated_check([cut(whole, 0, 10_100), cut(whole, 10_000, 20_000)])
    assert check.status == "note"


def test_numbers_may_be_written_with_other_digits() -> None:
    whole = log()
    other = cut(whole, 1000, 3000)
    rounded = replace(
        other,
        position=np.array([float(f"{x:.9g}") for x in other.position]),
        control=other.control * (1 + 3e-16),
    )
    (found,) = overlaps([cut(whole, 0, 2000), rounded])
    assert int(found.samples[0].sum()) == 1000


@pytest.mark.parametrize("step", [0.0, 1e-2, 1e-1])
def test_runs_of_one_motion_have_nothing_in_common(step: float) -> None:
    assert not overlaps([log(seed=seed, step=step) for seed in range(4)])


def test_parts_that_only_touch_have_nothing_in_common() -> None:
    whole = log()
    assert repeated_check([cut(whole, 0, 1500), cut(whole, 1500, 3000)]) is None


def test_without_what_the_drive_does_nothing_is_told() -> None:
    one, other = log(step=1e-2), log(step=1e-2)
    assert not overlaps([replace(one, control=None, force=one.control), other])


def test_records_resampled_to_other_times_are_told_by_their_rows_before() -> None:
    """Rows with 5 % jitter: each file is laid on a grid from its own first row."""
    whole = log()
    jitter = 5e-5 * np.random.default_rng(1).normal(size=len(whole))
    files = [
        {role: v[rows] for role, v in {**whole.channels(), "time": whole.time + jitter}.items()}
        for rows in (slice(0, 2000), slice(1000, 3000))
    ]
    first, second = (read_record(f, repairs=Repairs(resample="auto")) for f in files)
    assert not np.isin(first.control, second.control).any()
    (found,) = overlaps([first, second])
    assert [int(each.sum()) for each in found.samples] == pytest.approx([1000, 1000], abs=2)
    other = log(seed=1)
    again = read_record({**other.channels(), "time": other.time + jitter[::-1]})
    assert not overlaps([first, again])
