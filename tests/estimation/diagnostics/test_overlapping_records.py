"""Samples that are among several records more than once."""

from dataclasses import replace

import numpy as np
import pytest

from axisid.estimation.diagnostics.overlapping_records import repeated_check
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


WHOLE, LONG = log(), log(20_000)
AT_REST = np.isin(np.arange(len(LONG)) // 1000, (3, 15))
RESTING = LONG.with_values(
    **{role: np.where(AT_REST, 0.5, getattr(LONG, role)) for role in ("position", "control")}
)


@pytest.mark.parametrize(
    ("records", "figure", "status", "said"),
    [
        *(
            (
                [cut(WHOLE, 0, 2000), cut(WHOLE, 1000, 3000, absolute=absolute)],
                *(1.5, "fail"),
                f"1000 samples in common, from 1 to 1.999 s of the first and from {there} s",
            )
            for absolute, there in ((True, "1 to 1.999"), (False, "0 to 0.999"))
        ),
        (
            [log(step=1e-2)] * 3,
            3.0,
            "fail",
            "(record 1) and arrays (record 3) have 3000 samples in common",
        ),
        ([WHOLE, WHOLE.windowed((None, 0.9995), (1.9995, None))], 1.8, "fail", "in common"),
        ([cut(LONG, 0, 10_100), cut(LONG, 10_000, 20_000)], 1.01, "note", "100 samples in common"),
        (  # which rests elsewhere too, all samples of which are alike
            [cut(RESTING, 0, 10_100), cut(RESTING, 10_000, 20_000)],
            *(1.01, "note", "100 samples in common"),
        ),
    ],
    ids=["same clock", "own clocks", "given three times", "two stretches", "of no weight", "rests"],
)
def test_samples_that_are_given_again_are_told_with_the_times(
    records: list[Record], figure: float, status: str, said: str
) -> None:
    check = repeated_check(records)
    assert check.status == status
    assert check.figure == pytest.approx(figure, abs=2e-3)
    assert said in check.meaning


@pytest.mark.parametrize(
    "records",
    [
        *([log(seed=seed, step=step) for seed in range(4)] for step in (0.0, 1e-2, 1e-1)),
        [cut(WHOLE, 0, 1500), cut(WHOLE, 1500, 3000)],
        [replace(WHOLE, control=None, force=WHOLE.control), WHOLE],
    ],
)
def test_runs_of_one_motion_and_parts_that_only_touch_have_nothing_in_common(
    records: list[Record],
) -> None:
    assert repeated_check(records) is None


def test_records_resampled_to_other_times_are_told_by_their_rows_before() -> None:
    """Rows with 5 % jitter: each file is laid on a grid from its own first row."""
    whole = log()
    jitter = 5e-5 * np.random.default_rng(1).normal(size=len(whole))
    columns = {**whole.channels(), "time": whole.time + jitter}
    first, second = (
        read_record({n: v[rows] for n, v in columns.items()}, repairs=Repairs(resample="auto"))
        for rows in (slice(0, 2000), slice(1000, 3000))
    )
    assert not np.isin(first.control, second.control).any()
    assert repeated_check([first, second]).figure == pytest.approx(1.5, abs=2e-3)
    other = log(seed=1)
    again = read_record({**other.channels(), "time": other.time + jitter[::-1]})
    assert repeated_check([first, again]) is None
