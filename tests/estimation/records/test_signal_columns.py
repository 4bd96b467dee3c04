"""Columns of recorded signals: by name, number and unit; with gaps, windows, shifts and clocks."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import Record, build, read_record
from axisid.estimation import Repairs
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.arrays import Array
from tests.axes.recorded import recorded_axis
from tests.refusals import refuses

AXIS = recorded_axis("pressure")
T = 1e-3
TIME = T * np.arange(2000)
PRESSURE = 6e5 + 1e5 * np.sin(7 * TIME)


def columns(**changed: Any) -> dict[str, Array]:
    given = {
        "time": TIME,
        "position": 0.1 * np.sin(3 * TIME),
        "reference": 0.1 * np.sin(3 * TIME + 0.01),
        "control": np.cos(5 * TIME),
        "pressure": PRESSURE,
    }
    return {name: v for name, v in {**given, **changed}.items() if v is not None}


def written(folder: Path, log: Mapping[str, Array]) -> Path:
    file = folder / "log.csv"
    rows = np.column_stack(list(log.values()))
    lines = [",".join(log), *(",".join(map(repr, row)) for row in rows.tolist())]
    file.write_text("\n".join(lines))
    return file


@pytest.mark.parametrize("named", ["p:bar", "#5:bar", "p:mbar*1000"])
def test_a_signal_is_found_by_name_number_and_unit(named: str, tmp_path: Path) -> None:
    log = columns(pressure=None, p=PRESSURE / 1e5)
    record = read_record(written(tmp_path, log), AXIS, columns={"pressure": named})
    assert record.signals["pressure"] == pytest.approx(PRESSURE, rel=1e-12)
    assert record.provenance.columns["pressure"] == "p"


def test_a_signal_that_is_missing_is_refused_with_its_name() -> None:
    with refuses("columns", "no column 'pressure' for the pressure; found time, position"):
        read_record(columns(pressure=None), AXIS)
    with refuses("units", "measured in Pa"):
        read_record(columns(), AXIS, columns={"pressure": "pressure:mm"})
    with refuses("columns", "injected, pressure"):
        read_record(columns(), AXIS, columns={"flow": "pressure"})
    with refuses("columns"):
        read_record(columns(), AXIS, columns={"pressure": "control"})


def test_a_record_without_the_signal_is_refused_where_it_is_needed() -> None:
    record = Record(**columns(pressure=None))
    with refuses("missing-column", "pressure"):
        FilteredRecord.bind(build(AXIS), record, Prefilter())


def test_a_signal_may_be_constant_and_is_finite() -> None:
    still = columns(pressure=np.full(2000, 6e5))
    assert np.ptp(read_record(still, AXIS).signals["pressure"]) == 0
    with refuses("not-finite", "the pressure is nan in data row 8"):
        Record(
            **columns(pressure=None),
            signals={"pressure": np.where(np.arange(2000) == 7, np.nan, 1.0)},
        )
    with refuses("record"):
        Record(**columns(pressure=None), signals={"force": TIME})
    with refuses("record"):
        Record(**columns(pressure=None), signals=TIME)
    with refuses("record"):
        Record(**columns(pressure=None), signals={"pressure": TIME[1:]})


@pytest.mark.parametrize(
    "settings",
    [{"windows": [(0.2, 0.7), (1.0, 1.5)]}, {"repairs": Repairs(gaps="split")}],
)
def test_windows_and_gaps_take_the_signal_along(settings: Any) -> None:
    kept = np.r_[0:800, 900:2000]
    log = {name: values[kept] for name, values in columns().items()}
    record = read_record(columns() if "windows" in settings else log, AXIS, **settings)
    for piece in (record, record.longest(), record.windowed((1.1, 1.4))):
        assert piece.signals["pressure"] == pytest.approx(6e5 + 1e5 * np.sin(7 * piece.time))


def test_a_signal_is_shifted_by_its_name() -> None:
    early = columns(pressure=np.append(PRESSURE[2:], [6e5, 6e5]))
    record = read_record(early, AXIS, repairs=Repairs(shift={"pressure": 2}))
    assert record.signals["pressure"] == pytest.approx(6e5 + 1e5 * np.sin(7 * record.time))
    moved = read_record(early, AXIS).shifted(pressure="2ms")
    assert np.array_equal(moved.signals["pressure"], record.signals["pressure"])
    with refuses("shift", "flow"):
        read_record(early, AXIS, repairs=Repairs(shift={"flow": 2}))


@pytest.mark.parametrize("between", ["linear", "held"])
def test_a_signal_of_its_own_clock_is_resampled_as_it_runs(between: str) -> None:
    """Every tenth sample alone is logged; between them it is straight, or held."""
    log = {
        "t": TIME,
        "position": columns()["position"],
        "control": columns()["control"],
        "pressure": np.where(np.arange(2000) % 10 == 0, PRESSURE, np.nan),
    }
    axis = recorded_axis("pressure", between)
    record = read_record(log, axis, columns={"time": "t"}, repairs=Repairs(resample="auto"))
    seldom, rows = PRESSURE[::10], np.arange(len(record)) / 10
    expected = np.interp(rows, np.arange(200), seldom)
    if between == "held":
        expected = seldom[rows.astype(int)]
    assert record.signals["pressure"] == pytest.approx(expected, rel=1e-12)
    assert f"pressure {'held' if between == 'held' else 'by straight lines'}" in "".join(
        repair.text for repair in record.provenance.repairs
    )
