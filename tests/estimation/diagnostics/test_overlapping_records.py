"""Samples that are among several records more than once."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from axisid.estimation.diagnostics.overlapping_records import RepeatedSamples, repeated_check
from axisid.estimation.records import Record, Repairs, read_record
from tests.verdicts import finding_of


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
    ("records", "figure", "status", "pairs"),
    [
        *(
            (
                [cut(WHOLE, 0, 2000), cut(WHOLE, 1000, 3000, absolute=absolute)],
                *(1.5, "fail"),
                [(1000, (1.0, 1.999), there)],
            )
            for absolute, there in ((True, (1.0, 1.999)), (False, (0.0, 0.999)))
        ),
        (
            [log(step=1e-2)] * 3,
            3.0,
            "fail",
            [(3000, (0.0, 2.999), (0.0, 2.999))] * 3,
        ),
        (
            [WHOLE, WHOLE.windowed((None, 0.9995), (1.9995, None))],
            1.8,
            "fail",
            [(2000, (0.0, 2.999), (0.0, 2.999))],
        ),
        (
            [cut(LONG, 0, 10_100), cut(LONG, 10_000, 20_000)],
            1.01,
            "note",
            [(100, (10.0, 10.099), (10.0, 10.099))],
        ),
        (  # which rests elsewhere too, all samples of which are alike
            [cut(RESTING, 0, 10_100), cut(RESTING, 10_000, 20_000)],
            *(1.01, "note", [(100, (10.0, 10.099), (10.0, 10.099))]),
        ),
    ],
    ids=["same clock", "own clocks", "given three times", "two stretches", "of no weight", "rests"],
)
def test_samples_that_are_given_again_are_found_with_their_times(
    records: list[Record], figure: float, status: str, pairs: list[tuple[object, ...]]
) -> None:
    check = repeated_check(records)
    assert check.status == status
    assert check.figure == pytest.approx(figure, abs=2e-3)
    found = finding_of(check, RepeatedSamples).pairs
    assert [(each.samples, *each.spans) for each in found] == [
        (samples, pytest.approx(first), pytest.approx(second)) for samples, first, second in pairs
    ]


def test_every_pair_of_a_record_given_three_times_is_named() -> None:
    found = finding_of(repeated_check([log(step=1e-2)] * 3), RepeatedSamples)
    names = [f"arrays (record {i})" for i in (1, 2, 3)]
    assert [each.names for each in found.pairs] == [*combinations(names, 2)]
    assert found.repetitions == 3.0


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
