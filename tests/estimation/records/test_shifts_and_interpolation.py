"""Columns that a logger wrote too early, too late or seldom: moved, told, drawn between."""

import re
from typing import Any

import numpy as np
import pytest

from axisid import Record, read_record
from axisid.estimation import Repairs
from axisid.estimation.records import samples_apart
from tests.refusals import refuses

N, PERIOD = 2000, 1e-3
TIME = PERIOD * np.arange(N)
CONTROL = np.cos(30 * TIME)
VELOCITY = 30 * np.cos(30 * TIME)
HELD = np.repeat(VELOCITY[::4], 4)
EMPTY = np.where(np.arange(N) % 4 == 0, VELOCITY, np.nan)
LOG = {"time": TIME, "position": np.sin(30 * TIME), "control": CONTROL}


def read(velocity: np.ndarray, how: str | None = None, **more: Any) -> Any:
    repairs = Repairs(between={} if how is None else {"velocity": how}, **more)
    return read_record({**LOG, "v": velocity}, columns={"velocity": "v"}, repairs=repairs)


@pytest.mark.parametrize(
    ("values", "apart"),
    [
        *((VELOCITY, 1), (HELD, 4), (EMPTY, 4), (np.round(VELOCITY / 4), 1)),
        *((np.round(VELOCITY + np.random.default_rng(k).normal(0, 0.3, N)), 1) for k in range(10)),
    ],
)
def test_how_often_a_column_is_written_is_found(values: np.ndarray, apart: int) -> None:
    assert samples_apart(values) == apart


def test_a_column_that_holds_its_values_is_told() -> None:
    (doubt,) = read(HELD).provenance.doubts
    assert "in every 4th sample" in doubt
    assert not read(VELOCITY).provenance.doubts


@pytest.mark.parametrize("values", [HELD, EMPTY])
@pytest.mark.parametrize(("how", "off"), [("spline", 1e-4), ("linear", 0.06), ("held", 3.0)])
def test_it_is_drawn_between_its_values(values: np.ndarray, how: str, off: float) -> None:
    record = read(values, how)
    assert off / 10 < np.abs(np.asarray(record.velocity) - VELOCITY)[8:-8].max() < off
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("between", N - N // 4)
    assert not record.provenance.doubts


@pytest.mark.parametrize("how", ["spline", "linear"])
def test_resampled_it_is_drawn_likewise(how: str) -> None:
    found = np.asarray(read(HELD, how, resample=1000.0).velocity)
    even = np.asarray(read(HELD, how).velocity)[: len(found)]
    assert found[8:-8] == pytest.approx(even[8:-8], abs=1e-6)


@pytest.mark.parametrize(
    ("amount", "samples"),
    [(1, 1), (-2, -2), ("3", 3), ("2ms", 2), ("-0.001 s", -1), (2.0, 2), (0, 0)],
)
def test_a_column_moves_to_later_times_by_samples_or_a_time(amount: Any, samples: int) -> None:
    record = read_record(LOG, repairs=Repairs(shift={"control": amount}))
    rows = np.arange(max(samples, 0), N + min(samples, 0))
    assert record.time == pytest.approx(TIME[rows])
    assert np.array_equal(np.asarray(record.control), CONTROL[rows - samples])
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("shift", N - abs(samples) if samples else 0)
    way = "later" if samples > 0 else "earlier"
    if samples:
        assert re.search(rf"\({abs(samples)} ms\) .*{way}.*; {abs(samples)} row", repair.text)


def test_across_a_gap_nothing_is_moved() -> None:
    gapped = {name: np.delete(values, slice(400, 600)) for name, values in LOG.items()}
    record = read_record(gapped, repairs=Repairs(gaps="split", shift={"control": 2}))
    assert record.segments == ((0, 398), (398, 1796))
    assert np.asarray(record.control) == pytest.approx(np.cos(30 * (record.time - 2 * PERIOD)))
    whole = read_record(gapped, repairs=Repairs(gaps="split"))
    assert whole.shifted(control=2).digest == record.digest


def test_a_masked_sample_goes_with_its_column() -> None:
    record = Record(time=TIME, position=np.sin(TIME), control=CONTROL, masked=((500, 501),))
    assert record.shifted(control=2).masked == ((498, 499), (500, 501))


def test_part_of_a_sample_is_moved_where_the_log_is_resampled() -> None:
    record = read_record(LOG, repairs=Repairs(shift={"control": "0.5ms"}, resample=1000.0))
    expected = np.cos(30 * (record.time - 0.5e-3))
    assert np.asarray(record.control) == pytest.approx(expected, abs=(30 * 1e-3) ** 2 / 8)


@pytest.mark.parametrize(
    ("repairs", "code", "said"),
    [
        ({"shift": {"time": 1}}, "shift", "the time cannot"),
        ({"shift": {"torque": 1}}, "shift", "there is no column of the torque"),
        ({"shift": {"control": "2mm"}}, "shift", "samples, such as 1, or a time"),
        ({"shift": {"control": float("nan")}}, "shift", "samples"),
        ({"shift": {"control": "1e-3"}}, "shift", ""),
        ({"shift": {"control": "0.5ms"}}, "shift", r"0\.5"),
        ({"shift": {"control": 2000}}, "shift", "2000 of 2000 samples"),
        ({"shift": 3}, "shift", "samples by role"),
        ({"between": {"control": "linear"}}, "method", ""),
        ({"between": {"velocity": "cubic"}}, "method", ""),
        ({"between": {"velocity": "linear"}}, "shift", "no column of the velocity"),
    ],
)
def test_what_makes_no_sense_is_refused(repairs: Any, code: str, said: str) -> None:
    with refuses(code, said):
        read_record(LOG, repairs=Repairs(**repairs))


def test_too_few_values_are_not_drawn_between() -> None:
    with refuses("too-short"):
        read(np.where(np.arange(N) % 500 == 0, VELOCITY, np.nan), "linear")
