"""Text of any dialect is read to the last bit, or refused with a sentence; nothing is guessed."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from axisid import DataError, read_record
from axisid.estimation import Repairs
from axisid.estimation.logs.text.reader import read_text
from tests.refusals import refuses

N = 12
TIME = np.arange(N) * 0.25
POSITION = np.sin(TIME)


def written(separator: str, mark: str, above: list[str], header: list[str], end: str = "\n") -> str:
    """A log in a dialect, every number with a fraction."""
    rows = [[f"{t:.2f}", f"{q:.17e}"] for t, q in zip(TIME, POSITION, strict=True)]
    cells = [[c.replace(".", mark) for c in row] for row in rows]
    return end.join([*above, separator.join(header), *(separator.join(r) for r in cells)]) + end


def logged(folder: Path, *lines: str) -> Path:
    file = folder / "log.csv"
    file.write_text("\n".join(lines))
    return file


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"])
@pytest.mark.parametrize(
    ("separator", "mark"),
    [(";", ","), (";", "."), ("\t", ","), ("\t", "."), ("|", ","), (",", "."), ("  ", ",")],
)
@pytest.mark.parametrize("above", [[], ["Drive; model 7", "Date: 1.2.2026", "Rate 4 Hz"]])
def test_dialects_are_recognised(
    tmp_path: Path, separator: str, mark: str, above: list[str], encoding: str
) -> None:
    file = tmp_path / "log.csv"
    header = ["time", "position"] if separator.isspace() else ["time", "Lage_\u00e4"]
    file.write_bytes(written(separator, mark, above, header, "\r\n").encode(encoding))
    record = read_record(file, columns={"position": header[1]})
    assert np.array_equal(record.time, TIME)
    assert np.array_equal(record.position, POSITION)
    assert f"decimal {'comma' if mark == ',' else 'point'}" in record.provenance.assumed[0]
    told = " ".join(record.provenance.assumed)
    assert ("ignored" in told) == bool(above)
    plain = encoding.startswith("utf-8") or (encoding == "cp1252" and header[1].isascii())
    assert ("encoding" in told) == (not plain)


@pytest.mark.parametrize("units", [["[ms]", "[mm]"], ["(ms)", "(mm)"], ["ms", "mm"]])
def test_row_of_units_is_no_data(tmp_path: Path, units: list[str]) -> None:
    lines = written("\t", ".", ["made by a drive"], ["time", "position"]).splitlines()
    record = read_record(logged(tmp_path, *lines[:2], "\t".join(units), *lines[2:]))
    assert record.time == pytest.approx(1e-3 * TIME)
    assert record.position == pytest.approx(1e-3 * POSITION)


def test_header_in_a_comment_is_found(tmp_path: Path) -> None:
    file = tmp_path / "log.txt"
    np.savetxt(file, np.column_stack([TIME, POSITION]), header="scope 5\ntime position")
    assert np.array_equal(read_record(file).position, POSITION)


def test_row_of_units_in_a_comment_is_no_header(tmp_path: Path) -> None:
    file = tmp_path / "log.txt"
    np.savetxt(file, np.column_stack([TIME, POSITION]), header="time position\nms mm")
    record = read_record(file)
    assert record.time == pytest.approx(1e-3 * TIME)
    assert record.position == pytest.approx(1e-3 * POSITION)


def test_last_separator_comments_and_columns_of_text_do_not_matter(tmp_path: Path) -> None:
    rows = [f"{t},{float(q)!r},run," for t, q in zip(TIME, POSITION, strict=True)]
    rows[3:3] = ["# trigger", "# marker,0.9995,77,"]  # the second has as many cells as a row
    file = logged(tmp_path, "time,position,state,", *rows)
    assert np.array_equal(read_record(file).position, POSITION)
    with refuses("log-text", says="line 2: 'run' in column 'state'"):
        read_record(file, columns={"control": "state"})


@pytest.mark.parametrize("cell", ["#N/A", "#DIV/0!", "#WERT!", "#NV"])
@pytest.mark.parametrize("row", [0, 1, 2])
def test_what_a_spreadsheet_could_not_work_out_is_no_comment(cell: str, row: int) -> None:
    cells = ["1.5", "2.5", "3.5"]
    cells[row] = cell
    rows = "".join(f"{first};{k}\n" for k, first in enumerate(cells))
    table = read_text("log.csv", f"a;b\n{rows}".encode())
    assert table.columns["b"].read().values.tolist() == [0, 1, 2]
    with refuses("log-text", says=f"line {row + 2}: '{cell}' in column 'a' is not a number"):
        table.columns["a"].read()


def test_decimal_mark_may_come_after_a_long_rest(tmp_path: Path) -> None:
    rows = [f"{k};0;0" for k in range(600)]
    rows += [f"{600 + k};0,5;{'0,25' if k % 2 else '1'}" for k in range(100)]
    record = read_record(logged(tmp_path, "time;position;control", *rows))
    assert record.position[-1] == 0.5
    assert "separator semicolon, decimal comma" in record.provenance.assumed


def test_time_stamps_count_seconds_from_the_first(tmp_path: Path) -> None:
    start = np.datetime64("2026-03-28T23:59:59.250")
    stamps = [str(start + np.timedelta64(round(1e3 * t), "ms")).replace("T", " ") for t in TIME]
    rows = [f"{stamp};{k % 5}" for k, stamp in enumerate(stamps)]
    record = read_record(logged(tmp_path, "time;position", *rows))
    assert record.time == pytest.approx(TIME, abs=1e-12)
    assert "time: time stamps, relative to the first" in record.provenance.assumed


CELLS = st.sampled_from(["1", "0,5", "1.5", "2,345", "x", "", " ", '"', "[mm]", "-", "nan", "#"])


@pytest.mark.slow
@example(rows=[["1"] * 4, ["1"], ["1"] * 4, ["1"] * 4], separator=",")
@given(rows=st.lists(st.lists(CELLS, max_size=4), max_size=8), separator=st.sampled_from(",;\t| "))
def test_anything_like_a_table_is_read_or_refused(rows: list[list[str]], separator: str) -> None:
    content = "\n".join(separator.join(row) for row in rows).encode()
    try:
        table = read_text("log.csv", content)
        lengths = {len(c.read().values) for c in table.columns.values()}
    except DataError as error:
        assert "log.csv" in str(error)
    else:
        assert len(lengths) <= 1


@pytest.mark.parametrize(
    ("content", "code", "says"),
    [
        ("\x89PNG\0\0\1\2\0abc", "no-text", ""),
        ("a;b\n1,234;2\n5,678;3\n", "log-text", "'1,234'"),
        ("a;b\n" + 600 * "0;0\n" + "1,234;0\n2,345;1\n", "log-text", "'1,234'"),
        ("a;b\n1.234,5;2\n5.678,5;3\n", "log-text", ""),
        ("name\nof\nnothing\n", "log-text", ""),
        ("\n".join(4 * [";".join(map(str, range(20_000)))]), "log-text", "20000 cells.*Transpose"),
        ("a;b\n12:00:00;1\n12:00:01;2\nnoon;0", "log-text", "line 4: 'noon' in column 'a'"),
        (
            "a;b\n2026-02-30 12:00:00;1\n2026-02-30 12:00:01;2",
            "log-text",
            "line 2: '2026-02-30 .* in column 'a'.*day",
        ),
        # A cell too many, beside text and last separators.
        *(
            (
                "\n".join([f"a,b{end}", *700 * [f"1,2{end}"], f"1,2,3{end}"]),
                "log-text",
                "702: ",
            )
            for end in (",run", ",", ',"run"')
        ),
    ],
)
def test_what_is_no_table_or_ambiguous_is_explained(content: str, code: str, says: str) -> None:
    with refuses(code, says):
        read_text("log.csv", content.encode("latin-1")).columns["a"].read()


ROWS = [f"{k};{k % 7},5;run" for k in range(100)]


@pytest.mark.parametrize(
    "end",
    [
        ["100;0,"],
        ["ENDE;;"],
        ["", "Rows;100", "x;y;z"],
        *(["100;"], ["100;;"], ["100;0,5;"], ["100;;run"], [";0,5;run"]),
    ],
)
def test_end_that_is_no_row_is_left_out_on_request(tmp_path: Path, end: list[str]) -> None:
    file = logged(tmp_path, "time;position;state", *ROWS, *end)
    record = read_record(file, repairs=Repairs(tail="drop"))
    assert len(record) == 100
    (repair,) = record.provenance.repairs
    lines = [line for line in end if line]
    assert (repair.kind, repair.count) == ("tail", len(lines))
    assert repair.text.endswith(repr(lines[0]))


def test_end_that_is_no_row_is_refused_unasked_and_so_is_what_is_longer(tmp_path: Path) -> None:
    heads = "time;position;state"
    with refuses("log-text", says=r'line 102.*tail = "drop"'):
        read_record(logged(tmp_path, heads, *ROWS, "ENDE"))
    for spoilt in (["7;8", *ROWS], ["7;8"] * 60):
        with refuses("log-text", says=r"line 102: .* 2 cells, .* Remove or correct the line"):
            read_record(logged(tmp_path, heads, *ROWS, *spoilt), repairs=Repairs(tail="drop"))


def test_last_row_of_a_column_written_less_often_is_kept(tmp_path: Path) -> None:
    rows = [f"{k};{k % 7},5;{'' if k % 5 else k}" for k in range(100)]
    file = logged(tmp_path, "time;position;slow", *rows)
    record = read_record(file, repairs=Repairs(tail="drop"))
    assert len(record) == 100
    assert record.provenance.repairs[0].count == 0


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize(
    ("separator", "mark", "end"),
    [(",", ".", ""), (";", ",", ""), ("  ", ".", ""), (",", ".", ","), ("\t", ".", "")],
)
def test_cut_row_is_left_out_and_counted(
    tmp_path: Path, separator: str, mark: str, end: str, encoding: str
) -> None:
    file = tmp_path / "log.csv"
    time = 1e-3 * np.arange(3000)
    rows = zip(time, np.sin(9 * time), np.cos(9 * time), strict=True)
    lines = [separator.join(f"{v:.6f}".replace(".", mark) for v in row) + end for row in rows]
    text = "\n".join([separator.join(("time", "position", "control")), *lines])
    file.write_bytes(f"{text}\n".encode(encoding))
    assert not read_record(file).provenance.repairs
    file.write_bytes(text[:-4].encode(encoding))
    for repairs in (Repairs(), Repairs(tail="drop")):
        (told,) = read_record(file, repairs=repairs).provenance.repairs
        assert (told.kind, told.count) == ("tail", 1)
        assert "from line 3001" in told.text
