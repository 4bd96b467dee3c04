"""A record is checked once and then read-only."""

from typing import Any

import numpy as np
import pytest

from axisid import Record
from tests.refusals import refuses

N = 50
GOOD: dict[str, Any] = {
    "time": np.arange(N) * 1e-3,
    "position": np.sin(np.arange(N)),
    "control": np.cos(np.arange(N)),
}


def changed(role: str, row: int, value: float) -> dict[str, Any]:
    column = GOOD[role].copy()
    column[row] = value
    return {role: column}


def test_arrays_are_copied_and_read_only() -> None:
    position = GOOD["position"].copy()
    record = Record(**{**GOOD, "position": position})
    position[0] = 99.0
    assert record.position[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        record.position[0] = 1.0


def test_period_is_the_mean_step_unless_given() -> None:
    assert Record(**GOOD).period == pytest.approx(1e-3)
    assert Record(**GOOD, sample_period=1.001e-3).period == 1.001e-3


@pytest.mark.parametrize(
    ("change", "code", "says"),
    [
        (changed("position", 7, np.nan), "not-finite", "position is nan in data row 8"),
        (changed("control", 3, np.inf), "not-finite", "control is inf in data row 4"),
        (changed("control", 3, -1e300), "not-finite", "control is -1e.300 in data row 4"),
        (changed("time", 9, 0.0), "time", "10"),
        (changed("time", 9, 0.008), "time", "10"),
        (
            {"time": np.r_[GOOD["time"][:30], GOOD["time"][30:] + 0.01]},
            "uneven-time",
            "31",
        ),
        ({"time": np.cumsum(np.r_[np.full(30, 1e-3), np.full(20, 1.4e-3)])}, "uneven-time", ""),
        ({"position": np.ma.masked_less(GOOD["position"], 0)}, "record", "[0-9]+"),
        ({"position": GOOD["position"] + 1j}, "record", "complex"),
        ({"position": np.zeros(N)}, "not-shown", "position is 0"),
        ({"control": np.full(N, 2.5)}, "not-shown", "control is 2.5"),
        ({"reference": np.zeros(N)}, "not-shown", "reference is 0"),
        ({"position": np.zeros(N - 1)}, "record", "time 50, position 49"),
        ({"position": np.zeros((N, 2))}, "record", r"\(50, 2\)"),
        ({"position": ["a"] * N}, "record", "text"),
        ({"sample_period": 1.0}, "time", "1 s, but the time column steps by 0.001"),
        ({"sample_period": -1e-3}, "time", ""),
        ({k: v[:2] for k, v in GOOD.items()}, "too-short", "3 rows or more, not 2"),
    ],
)
def test_bad_records_are_explained(change: dict[str, Any], code: str, says: str) -> None:
    with refuses(code, says):
        Record(**{**GOOD, **change})
