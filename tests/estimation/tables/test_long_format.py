"""Long tables, in which each row is one value of one signal, are made wide; no others."""

import json
from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from axisid.estimation import Repairs
from axisid.estimation.logs import read_table
from tests.refusals import refuses

TIME = 1e-3 * np.arange(300)
POSITION, CONTROL = np.sin(20 * TIME), np.cos(20 * TIME)


def written(file: Path, header: str, rows: list[str]) -> Path:
    file.write_text("\n".join([header, *rows]))
    return file


def test_rows_of_one_time_become_columns(tmp_path: Path) -> None:
    rows = [
        row
        for t, x, u in zip(TIME, POSITION, CONTROL, strict=True)
        for row in (f"{t},{x:.17g},position", f"{t},{u:.17g},control")
    ]
    for header in ("time,value,name", "t,measured,what"):
        record = read_record(written(tmp_path / "long.csv", header, rows))
        assert record.time == pytest.approx(TIME)
        assert np.array_equal(record.position, POSITION)
        assert np.array_equal(np.asarray(record.control), CONTROL)
        assert "made 2 columns by their names" in " ".join(record.provenance.assumed)


@pytest.mark.parametrize("ending", ["csv", "jsonl"])
def test_times_may_be_stamps(tmp_path: Path, ending: str) -> None:
    file = tmp_path / f"long.{ending}"
    rows = [
        (f"2026-02-01T12:00:00.{round(1e3 * t):03d}Z", name, value)
        for t, x, u in zip(TIME, POSITION, CONTROL, strict=True)
        for name, value in (("position", x), ("control", u))
    ]
    if ending == "csv":
        written(file, "timestamp,signal,value", [f"{t},{n},{v:.17g}" for t, n, v in rows])
    else:
        keys = ("timestamp", "signal", "value")
        file.write_text("\n".join(json.dumps(dict(zip(keys, row, strict=True))) for row in rows))
    record = read_record(file)
    assert record.time == pytest.approx(TIME, abs=1e-9)
    assert record.position == pytest.approx(POSITION, abs=1e-15)
    assert np.asarray(record.control) == pytest.approx(CONTROL, abs=1e-15)


def test_lines_of_a_preamble_with_stamps_are_no_rows(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    above = "started;2026-02-01 12:00:00\nended;2026-02-01 12:00:01\ntime;position\n"
    rows = [f"{t:.3f};{x:.9f}" for t, x in zip(TIME, POSITION, strict=True)]
    file.write_text(above + "\n".join(rows))
    assert list(read_table(file).columns) == ["time", "position"]


def test_signals_keep_their_units_and_clocks(tmp_path: Path) -> None:
    rows = [f"{1e3 * t};position;mm;{1e3 * x:.17g}" for t, x in zip(TIME, POSITION, strict=True)]
    rows += [f"{1e3 * t + 0.3};control;V;{u:.17g}" for t, u in zip(TIME, CONTROL, strict=True)]
    file = written(tmp_path / "long.csv", "t [ms];signal;unit;value", rows)
    with refuses("time"):
        read_record(file)
    record = read_record(file, repairs=Repairs(resample="auto"))
    assert record.position == pytest.approx(np.sin(20 * record.time), abs=1e-6)
    assert record.period == pytest.approx(1e-3)


def test_a_log_with_a_state_in_words_is_no_long_one(tmp_path: Path) -> None:
    for header in ("time,state,position", "time,name,position"):
        rows = [
            f"{t},{'on' if t > 0.1 else 'off'},{x}" for t, x in zip(TIME, POSITION, strict=True)
        ]
        record = read_record(written(tmp_path / "state.csv", header, rows))
        assert len(record) == len(TIME)


def test_a_column_of_numbers_with_a_damaged_one_has_no_names(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    rows = ["1.15;0.1;e5", *(f"{-0.3 - k // 3};{0.1 * k};{1.46 + k // 3}" for k in range(6))]
    file.write_text("u;ref;n\n" + "\n".join(rows) + "\n", encoding="utf-8")
    assert list(read_table(file).columns) == ["u", "ref", "n"]


def test_a_frame_may_be_long_too() -> None:
    long = {
        "t": np.repeat(TIME, 2),
        "signal": np.tile(["position", "control"], len(TIME)),
        "value": np.column_stack([POSITION, CONTROL]).ravel(),
    }
    assert np.array_equal(read_record(long).position, POSITION)
