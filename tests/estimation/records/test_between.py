"""Columns that are written more seldom than the log's samples: found, told, drawn between."""

from typing import Any

import numpy as np
import pytest

from axisid import read_record
from axisid.estimation import Repairs
from axisid.estimation.records import samples_apart
from tests.refusals import refuses

N, PERIOD = 2000, 1e-3
TIME = PERIOD * np.arange(N)
VELOCITY = 30 * np.cos(30 * TIME)
HELD = np.repeat(VELOCITY[::4], 4)
EMPTY = np.where(np.arange(N) % 4 == 0, VELOCITY, np.nan)


def log(velocity: np.ndarray) -> dict[str, Any]:
    return {"time": TIME, "position": np.sin(30 * TIME), "v": velocity, "control": np.cos(7 * TIME)}


def read(velocity: np.ndarray, how: str | None = None) -> Any:
    between = {} if how is None else {"velocity": how}
    return read_record(log(velocity), columns={"velocity": "v"}, repairs=Repairs(between=between))


@pytest.mark.parametrize(("values", "apart"), [(VELOCITY, 1), (HELD, 4), (EMPTY, 4)])
def test_how_often_a_column_is_written_is_found(values: np.ndarray, apart: int) -> None:
    assert samples_apart(values) == apart


@pytest.mark.parametrize("seed", range(10))
def test_a_rounded_column_is_written_in_every_sample(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert samples_apart(np.round(VELOCITY + rng.normal(0, 0.3, N))) == 1
    assert samples_apart(np.round(VELOCITY / 4)) == 1


def test_a_column_that_holds_its_values_is_told() -> None:
    (doubt,) = read(HELD).provenance.doubts
    assert "in every 4th sample" in doubt
    assert not read(VELOCITY).provenance.doubts


@pytest.mark.parametrize("values", [HELD, EMPTY])
@pytest.mark.parametrize(("how", "off"), [("spline", 1e-4), ("linear", 0.06), ("held", 3.0)])
def test_it_is_drawn_between_its_values(values: np.ndarray, how: str, off: float) -> None:
    record = read(values, how)
    inside = slice(8, -8)
    apart = np.abs(np.asarray(record.velocity) - VELOCITY)[inside].max()
    assert apart < off
    assert apart > off / 10
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("between", N - N // 4)
    assert not record.provenance.doubts


def test_resampled_it_is_drawn_likewise() -> None:
    for how in ("spline", "linear"):
        repairs = Repairs(between={"velocity": how}, resample=1000.0)
        record = read_record(log(HELD), columns={"velocity": "v"}, repairs=repairs)
        even = np.asarray(read(HELD, how).velocity)[: len(record)]
        assert np.asarray(record.velocity)[8:-8] == pytest.approx(even[8:-8], abs=1e-6)


def test_what_makes_no_sense_is_refused() -> None:
    with refuses("method"):
        Repairs(between={"control": "linear"})
    with refuses("method"):
        Repairs(between={"velocity": "cubic"})  # type: ignore[dict-item]
    with refuses("shift"):
        read_record(
            {"time": TIME, "position": np.sin(TIME), "control": TIME},
            repairs=Repairs(between={"velocity": "linear"}),
        )
    with refuses("too-short"):
        read(np.where(np.arange(N) % 500 == 0, VELOCITY, np.nan), "linear")
