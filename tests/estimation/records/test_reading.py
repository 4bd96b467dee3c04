"""Files in, records out; what cannot be read is explained by file, line and column."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import axisid
from axisid import DataError, load_axis, read_record
from tests.refusals import refuses

ROWS = [(0.001 * k, np.sin(k / 9), np.cos(k / 9), 0.1 * k % 0.7) for k in range(40)]


def text(delimiter: str = ",", header: str = "time,position,reference,control") -> str:
    lines = [header.replace(",", delimiter)]
    return "\n".join(lines + [delimiter.join(f"{x:.17g}" for x in row) for row in ROWS]) + "\n"


def write(tmp_path: Path, content: str, name: str = "log.csv") -> Path:
    file = tmp_path / name
    file.write_text(content, encoding="utf-8")
    return file


def test_columns_are_found_by_the_users_names_then_the_axis_then_the_role(tmp_path: Path) -> None:
    file = write(tmp_path, text(header="t,qm,qg,volts"))
    record = read_record(file, load_axis("emps"), columns={"control": "volts"})
    assert record.provenance.columns == {
        "time": "t",
        "position": "qm",
        "reference": "qg",
        "control": "volts",
    }


def test_quoted_cells_blank_lines_and_byte_order_marks_are_read(tmp_path: Path) -> None:
    quoted = "\ufeff" + text().replace("\n", "\n\n").replace("0.001,", '"0.001",')
    assert len(read_record(write(tmp_path, quoted))) == 40


@pytest.mark.parametrize(
    ("content", "code", "says"),
    [
        ("", "log-text", "has 0 filled lines"),
        ("time,position\n", "log-text", "has 1 filled lines"),
        ("0.0,1.0\n0.1,2.0\n", "columns", "found #1, #2"),
        ("time,position,position\n0,1,2\n", "columns", "several columns: position.1, position.2"),
        ("time,position\n0,1\n1,x\n", "log-text", "line 3: 'x' in column 'position'"),
        ("time,position\n0,1\n1\n", "log-text", "3: 1 cells where the header names 2"),
        ("time,position\n0,1\n1,\n", "empty-cells", "position is nan in data row 2"),
        (
            "time;position\n0;1.5\n1;2,5\n",
            "log-text",
            "line 3: '2,5' in column 'position'.*decimal point",
        ),
        (
            "time;position\n0;1,5\n1;2.5\n",
            "log-text",
            "line 2: '1,5' in column 'position'.*decimal point",
        ),
        ("time;position\n0;1,234\n1;2,345\n", "log-text", "'1,234'"),
        ("time,position\n0,1,2\n1,2,3\n", "log-text", "names 2 columns"),
        ("time,position\n0,1_000\n1,2\n", "log-text", "line 2: '1_000' in column 'position'"),
        (
            "time,position\n0,001,1,5\n0,002,1,6\n",
            "log-text",
            "2 columns.*, the rows have 4.*semicolon",
        ),
        (
            "time,angle,control\n0,1,1\n1,2,2\n",
            "columns",
            "'position'.*found time, angle, control",
        ),
    ],
)
def test_bad_text_is_explained(tmp_path: Path, content: str, code: str, says: str) -> None:
    with refuses(code, says):
        read_record(write(tmp_path, content))


def test_all_missing_columns_are_told_at_once(tmp_path: Path) -> None:
    file = write(tmp_path, text(header="t,pos,ref,volts"))
    declared = (
        "no column 'qm' for the position, 'qg' for the reference, 'vir' for the control; found"
    )
    advice = "columns position=NAME,reference=NAME,control=NAME"
    with refuses("columns", says=f"{declared} t, pos, ref, volts. .*{advice}"):
        read_record(file, load_axis("emps"))
    with refuses("columns", says="position=NAME,time=NAME,reference=NAME,control=NAME"):
        read_record(file)


@pytest.mark.parametrize("wanted", ["ISTPOSITION", "Istpositon", "istposition"])
def test_column_of_nearly_the_name_is_proposed(tmp_path: Path, wanted: str) -> None:
    file = write(tmp_path, text(header="time,Istposition,reference,control"))
    with refuses("columns", says="Did you mean 'Istposition'"):
        read_record(file, columns={"position": wanted})


def test_names_that_occur_twice_matter_only_where_they_are_asked_for(tmp_path: Path) -> None:
    file = write(tmp_path, text(header="time,position,x,x"))
    assert len(read_record(file)) == len(ROWS)
    with refuses("columns", says=r"'x' for the control.*several columns: x\.1, x\.2"):
        read_record(file, columns={"control": "x"})
    record = read_record(file, columns={"reference": "x.1", "control": "x.2"})
    assert np.array_equal(record.control, np.array(ROWS)[:, 3])


def test_period_that_is_given_stands_for_a_time_column_that_the_axis_declares() -> None:
    axis = replace(load_axis("emps2015"), columns={"time": "t", "position": "q", "control": "u"})
    log = {"q": np.sin(np.arange(50)), "u": np.cos(np.arange(50))}
    assert read_record(log, axis, sample_period=1e-3).period == 1e-3
    for more in ({}, {"columns": {"time": "t"}, "sample_period": 1e-3}):
        with refuses("columns", says="'t' for the time"):
            read_record(log, axis, **more)  # type: ignore[arg-type]


def test_log_without_the_reference_that_the_axis_names_serves_least_squares() -> None:
    axis = load_axis("emps2015")
    twin = axisid.twin_record(axis)
    axis = replace(axis, columns={"position": "q", "reference": "set", "control": "u"})
    log = {"time": twin.time, "q": twin.position, "u": twin.control}
    record = read_record(log, axis)
    told = "no column 'set' for the reference, so least squares only, no instruments"
    assert told in record.provenance.assumed
    assert "has no reference column" in axisid.identify(axis, record).skipped["idm-iv"]
    with refuses("columns", says="'set' for the reference"):
        read_record(log, axis, columns={"reference": "set"})


@pytest.mark.parametrize("repairs", [{}, {"wrap": 1.0}, {"resample": 100.0}])
def test_log_without_a_number_is_refused_whatever_is_asked_for(repairs: dict[str, Any]) -> None:
    said = r"position (has no row with a number|is inf in data row 1)"
    for rows in (0, 9):
        log = {"time": 0.01 * np.arange(rows), "position": np.full(rows, np.inf)}
        with pytest.raises(DataError, match=said):
            read_record(log, repairs=axisid.estimation.Repairs(**repairs))
