"""Every repair does what it says, counts it, and is made on request only."""

from typing import Any

import numpy as np
import pytest

from axisid import UsageError, read_record
from axisid.estimation import Repairs
from tests.refusals import refuses

N = 400
PERIOD = 1e-3
TIME = PERIOD * np.arange(N)
POSITION = np.sin(30 * TIME)
CONTROL = np.cos(30 * TIME)


def log(**changes: Any) -> dict[str, Any]:
    return {"time": TIME, "position": POSITION, "control": CONTROL} | changes


def test_uneven_time_is_resampled_to_the_motion_that_was_sampled(
    rng: np.random.Generator,
) -> None:
    uneven = TIME + PERIOD * rng.uniform(-0.4, 0.4, N)
    wavy = log(time=uneven, position=np.sin(30 * uneven), control=np.cos(30 * uneven))
    with refuses("uneven-time", says="jitter"):
        read_record(wavy)
    record = read_record(wavy, repairs=Repairs(resample=1000.0))
    assert record.period == 1e-3
    # A cubic spline's error is about h^4/384 times the fourth derivative, a line's h^2/8.
    assert record.position == pytest.approx(np.sin(30 * record.time), abs=1e-6)
    assert record.control == pytest.approx(np.cos(30 * record.time), abs=(30 * 2e-3) ** 2 / 8)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("resample", len(record))
    assert "position by cubic splines, control by straight lines" in repair.text


def test_column_of_a_lower_rate_has_empty_cells() -> None:
    sparse = CONTROL.copy()
    sparse[np.arange(N) % 4 != 0] = np.nan
    with refuses("empty-cells", says=r"control is nan in data row 2 \(300 of 400 cells"):
        read_record(log(control=sparse))
    record = read_record(log(control=sparse), repairs=Repairs(resample="auto"))
    assert record.period == pytest.approx(PERIOD)
    assert record.control == pytest.approx(np.cos(30 * record.time), abs=(30 * 4e-3) ** 2 / 8)
    assert "control 300" in record.provenance.repairs[0].text
    assert "control 100 rows at 250 Hz" in record.provenance.repairs[1].text


def gapped() -> dict[str, Any]:
    kept = np.ones(N, dtype=bool)
    kept[100:130] = kept[250:252] = False
    kept[254:260] = False  # leaves a piece of two rows
    return {name: values[kept] for name, values in log().items()}


def test_gaps_split_a_log_into_segments() -> None:
    with refuses("uneven-time", says='gaps="split"'):
        read_record(gapped())
    record = read_record(gapped(), repairs=Repairs(gaps="split"))
    assert record.segments == ((0, 100), (100, 220), (220, 360))
    assert record.period == pytest.approx(PERIOD, rel=1e-12)
    assert np.array_equal(record.position, np.sin(30 * record.time))
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("gaps", 3)
    assert "0.038 s are missing" in repair.text
    assert "2 rows in pieces of fewer than 3 left out" in repair.text
    assert record.longest().segments == ()
    assert np.array_equal(record.longest().time, record.time[220:])


def test_resampling_invents_no_motion_in_a_gap() -> None:
    with refuses("uneven-time", says=r"time has 2 gaps"):
        read_record(gapped(), repairs=Repairs(resample="auto"))
    record = read_record(gapped(), repairs=Repairs(resample="auto", gaps="split"))
    assert [stop - start for start, stop in record.segments] == [100, 124, 140]
    assert record.position == pytest.approx(np.sin(30 * record.time), abs=1e-6)
    kinds = [(repair.kind, repair.count) for repair in record.provenance.repairs]
    assert kinds == [("resample", 364), ("gaps", 2)]
    assert "0.036 s are missing" in record.provenance.repairs[1].text


@pytest.mark.parametrize(
    "settings",
    [{"resample": -1.0}, {"resample": "fast"}, {"gaps": "fill"}, {"mask": "all"}],
)
def test_settings_that_make_no_sense_are_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(UsageError):
        Repairs(**settings)


def test_rate_that_would_fill_the_memory_is_refused() -> None:
    with refuses("resampling"):
        read_record(log(), repairs=Repairs(resample=1e12))
