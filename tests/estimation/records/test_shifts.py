"""Columns that a logger wrote too early or too late, moved against the others."""

from typing import Any

import numpy as np
import pytest

from axisid import Record, read_record
from axisid.estimation import Repairs
from tests.refusals import refuses

N, PERIOD = 1000, 1e-3
TIME = PERIOD * np.arange(N)
CONTROL = np.cos(30 * TIME)


def log(**changes: Any) -> dict[str, Any]:
    return {"time": TIME, "position": np.sin(30 * TIME), "control": CONTROL} | changes


@pytest.mark.parametrize(
    ("amount", "samples"),
    [(1, 1), (-2, -2), ("3", 3), ("2ms", 2), ("-0.001 s", -1), (2.0, 2), (0, 0)],
)
def test_a_column_moves_to_later_times_by_samples_or_a_time(amount: Any, samples: int) -> None:
    record = read_record(log(), repairs=Repairs(shift={"control": amount}))
    rows = np.arange(max(samples, 0), N + min(samples, 0))
    assert record.time == pytest.approx(TIME[rows])
    assert np.array_equal(np.asarray(record.control), CONTROL[rows - samples])
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("shift", N - abs(samples) if samples else 0)
    if samples:
        way = "later" if samples > 0 else "earlier"
        assert f"({abs(samples)} ms) {way}; {abs(samples)} row" in repair.text


def test_across_a_gap_nothing_is_moved() -> None:
    kept = np.r_[0:400, 600:N]
    gapped = {name: values[kept] for name, values in log().items()}
    record = read_record(gapped, repairs=Repairs(gaps="split", shift={"control": 2}))
    assert record.segments == ((0, 398), (398, 796))
    assert np.asarray(record.control) == pytest.approx(np.cos(30 * (record.time - 2 * PERIOD)))
    whole = read_record(gapped, repairs=Repairs(gaps="split"))
    assert whole.shifted(control=2).digest == record.digest


def test_a_masked_sample_goes_with_its_column() -> None:
    record = Record(time=TIME, position=np.sin(TIME), control=CONTROL, masked=((500, 501),))
    assert record.shifted(control=2).masked == ((498, 499), (500, 501))


def test_part_of_a_sample_needs_resampling() -> None:
    with refuses("shift", r"shifted by 0\.5 samples"):
        read_record(log(), repairs=Repairs(shift={"control": "0.5ms"}))
    record = read_record(log(), repairs=Repairs(shift={"control": "0.5ms"}, resample=1000.0))
    expected = np.cos(30 * (record.time - 0.5e-3))
    assert np.asarray(record.control) == pytest.approx(expected, abs=(30 * 1e-3) ** 2 / 8)


@pytest.mark.parametrize(
    ("shift", "said"),
    [
        ({"time": 1}, "'time' is no column that can be moved"),
        ({"torque": 1}, "there is no such column"),
        ({"control": "2mm"}, "give samples, such as 1, or a time"),
        ({"control": float("nan")}, "give samples"),
        ({"control": "1e-3"}, ""),
        ({"control": 1000}, "shifted by 1000 samples, and has 1000"),
        (3, "give samples by role"),
    ],
)
def test_a_shift_that_cannot_be_made_is_refused(shift: Any, said: str) -> None:
    with refuses("shift", said):
        read_record(log(), repairs=Repairs(shift=shift))
