"""What is said of times that are not even: jitter, gaps, clocks that jump or drift, few digits."""

from typing import Any

import numpy as np
import pytest

from axisid import Record, read_record
from axisid.estimation import Repairs
from tests.refusals import refuses

N = 2000
PERIOD = 1e-3
TIME = PERIOD * np.arange(N)


def log(time: np.ndarray, **changes: Any) -> dict[str, np.ndarray]:
    """A motion that goes on whatever its clock says."""
    motion = 30 * PERIOD * np.arange(len(time))
    return {"time": time, "position": np.sin(motion), "control": np.cos(motion)} | changes


def stepped(seconds: float) -> np.ndarray:
    time = TIME.copy()
    time[1200:] += seconds
    return time


def test_period_that_drifts_is_refused_and_may_be_resampled() -> None:
    drifting = np.cumsum(np.linspace(0.8e-3, 1.2e-3, N))
    wavy = log(drifting, position=np.sin(30 * drifting), control=np.cos(30 * drifting))
    with refuses("uneven-time", says=r"drifts from 0\.81\d+ to 1\.1\d+ ms.*resample="):
        read_record(wavy)
    record = read_record(wavy, repairs=Repairs(resample="auto"))
    assert record.position == pytest.approx(np.sin(30 * record.time), abs=1e-6)


def test_drift_is_that_of_each_segment() -> None:
    """Two pieces of a log may have their own times, but not their own periods."""
    pieces = np.concatenate([TIME, 10 + 1.1 * TIME])
    spans = ((0, N), (N, 2 * N))
    with refuses("uneven-time", says=r"drifts from 1 to 1\.1 ms"):
        Record(time=pieces, position=np.sin(np.arange(2.0 * N)), segments=spans)
    Record(
        time=np.concatenate([TIME, 10 + TIME]), position=np.sin(np.arange(2.0 * N)), segments=spans
    )


@pytest.mark.parametrize(
    ("time", "code"),
    [
        (stepped(0.5), "uneven-time"),
        (stepped(0.7e-3), "uneven-time"),
        (stepped(-0.7e-3), "uneven-time"),
        (stepped(-0.5), "time"),
        (np.concatenate([TIME, TIME]), "time"),
        (np.concatenate([TIME[:900], TIME[[901, 900]], TIME[902:]]), "time"),
        (np.repeat(TIME[:500:4], 4), "time"),
    ],
)
def test_times_that_are_not_even_are_refused(time: np.ndarray, code: str) -> None:
    with refuses(code):
        read_record(log(time))


@pytest.mark.parametrize(
    ("time", "segments"),
    [
        (stepped(0.5), ((0, 1200), (1200, N))),
        (stepped(0.7e-3), ((0, 1200), (1200, N))),
        (stepped(-0.7e-3), ((0, 1200), (1200, N))),
        (stepped(-0.5), ((0, 1200), (1200, N))),
        (np.concatenate([TIME, TIME, TIME]), ((0, N), (N, 2 * N), (2 * N, 3 * N))),
    ],
)
def test_advice_to_cut_gives_the_log_in_pieces(
    time: np.ndarray, segments: tuple[tuple[int, int], ...]
) -> None:
    columns = log(time)
    record = read_record(columns, repairs=Repairs(gaps="split"))
    assert record.segments == segments
    assert np.array_equal(record.position, columns["position"])
    assert record.period == pytest.approx(PERIOD, rel=1e-9)


def test_clock_that_was_set_back_is_told_and_counted() -> None:
    record = read_record(log(stepped(-0.5)), repairs=Repairs(gaps="split"))
    clock, gaps = record.provenance.repairs
    assert (clock.kind, clock.count, gaps.kind, gaps.count) == ("clock", 1, "gaps", 1)
    assert "first before data row 1201, from 1.199 s to 0.7 s" in clock.text
    columns = log(stepped(-0.5))
    columns["position"][300:340] = np.nan
    columns["control"][::2] = np.nan
    both = read_record(columns, repairs=Repairs(gaps="split", resample="auto"))
    assert [stop - start for start, stop in both.segments] == [299, 860, 800]


def test_coarse_stamps_are_counted_by_a_given_period_that_is_theirs() -> None:
    coarse = np.floor(TIME * 250 + 1e-9) / 250
    record = read_record(log(coarse), sample_period=PERIOD)
    assert record.time == pytest.approx(TIME, abs=1e-12)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("clock", N)
    with refuses("time", says="too coarse"):
        read_record(log(coarse), sample_period=1.05 * PERIOD)
