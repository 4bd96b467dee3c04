"""JSON in the shapes that writers give it is read, or refused."""

import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import DataError, read_record
from tests.estimation.logs.samples import N, Q, T, U
from tests.files import text_file
from tests.refusals import refuses

COLUMNS: dict[str, list[float]] = {
    "time": T.tolist(),
    "position": Q.tolist(),
    "control": U.tolist(),
}
ROWS = [list(row) for row in zip(*COLUMNS.values(), strict=True)]
RECORDS = [dict(zip(COLUMNS, row, strict=True)) for row in ROWS]
NUMBERED = {"time": "#1", "position": "#2", "control": "#3"}


def lines(each: Any) -> str:
    return "\n".join(map(json.dumps, each))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("arrays.json", json.dumps(COLUMNS)),
        ("below.json", json.dumps({"log": {"axis": COLUMNS}, "made by": "a drive"})),
        (
            "unit.json",
            json.dumps(
                {
                    **COLUMNS,
                    "position": {"unit": "m", "values": COLUMNS["position"]},
                    "time [ms]": (1e3 * T).tolist(),
                }
                | {"time": None}
            ),
        ),
        ("records.json", json.dumps(RECORDS)),
        ("nested.json", json.dumps([{"axis": record} for record in RECORDS])),
        (
            "entries.json",
            json.dumps({"mass": 0.7, "entries": RECORDS, "events": [{"at": 0.1, "of": "stop"}]}),
        ),
        ("rows.json", json.dumps([[*COLUMNS], *ROWS])),
        ("split.json", json.dumps({"columns": [*COLUMNS], "data": ROWS})),
        (
            "pandas.json",
            json.dumps({k: {str(i): x for i, x in enumerate(v)} for k, v in COLUMNS.items()}),
        ),
        ("records.jsonl", lines(RECORDS)),
        ("records.ndjson", lines(RECORDS) + "\n\n"),
        ("rows.jsonl", lines([[*COLUMNS], *ROWS])),
    ],
)
def test_every_shape_is_the_same_record(tmp_path: Path, name: str, text: str) -> None:
    file = text_file(tmp_path / name, text)
    record = read_record(file)
    assert record.position == pytest.approx(COLUMNS["position"], abs=1e-15)
    assert record.time == pytest.approx(T, abs=1e-12)
    assert np.asarray(record.control) == pytest.approx(COLUMNS["control"], abs=1e-15)


def test_rows_without_names_are_called_by_number(tmp_path: Path) -> None:
    file = text_file(tmp_path / "rows.jsonl", lines(ROWS))
    assert len(read_record(file, columns=NUMBERED)) == N


def test_time_stamps_and_packed_files_are_read(tmp_path: Path) -> None:
    stamps = [f"2026-02-01T12:00:00.{round(1e3 * t):03d}Z" for t in T]
    file = tmp_path / "log.jsonl.gz"
    records = [{**r, "time": s} for r, s in zip(RECORDS, stamps, strict=True)]
    file.write_bytes(gzip.compress(lines(records).encode()))
    record = read_record(file)
    assert record.time == pytest.approx(T, abs=1e-9)
    assert "time stamps, relative to the first" in " ".join(record.provenance.assumed)


def test_what_is_missing_in_a_record_is_an_empty_cell(tmp_path: Path) -> None:
    lacking = [{**record} for record in RECORDS]
    del lacking[7]["position"]
    text = json.dumps([*lacking[:9], lacking[9] | {"position": None}, *lacking[10:]])
    with refuses("empty-cells", r"data row 8 \(2 of 50"):
        read_record(text_file(tmp_path / "log.json", text))


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("log.json", "{1", "JSON: expecting property name"),
        ("log.jsonl", '{"time": 1}\n{"time":', "line 2"),
        ("log.json", "[" * 100_000, "nested too deep"),
        ("log.json", '{"a": "b"}', "no columns of numbers"),
        ("log.json", "[]", "no columns of numbers"),
        ("log.json", "3", "no columns of numbers"),
        ("log.json", "[[1, 2], [3]]", "no columns of numbers"),
        ("log.jsonl", lines([*RECORDS, [1, 2, 3]]), "no columns of numbers"),
        ("log.json", '{"a": [[1], [2]], "b": ["x", "y"]}', "b: text"),
        ("log.json", '{"schema": "axisid.stream/1"}', "a result of axisid"),
        ("log.csv", json.dumps(RECORDS), "file the ending .json, or .jsonl"),
    ],
)
def test_what_is_no_log_is_told(tmp_path: Path, name: str, text: str, said: str) -> None:
    file = text_file(tmp_path / name, text)
    with pytest.raises(DataError, match=said):
        read_record(file)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("log.json", '{"time": [0, 1, 2], "position": [0, 1, 2], "position": [3, 4, 5]}'),
        ("log.json", '[{"time": 0, "position": 1, "position": 2}, {"time": 1, "position": 1}]'),
        ("log.jsonl", '{"time": 0, "position": 1, "position": 2}\n{"time": 1, "position": 1}'),
        ("log.json", '{"a": {"b": [1, 2, 3]}, "a.b": [1, 2, 4]}'),
        ("log.json", '[{"a": {"b": 1}, "a.b": 2}, {"a": {"b": 1}, "a.b": 2}]'),
        ("log.json", '[["time", "time"], [0, 1], [1, 2]]'),
        ("log.json", '{"position": {"unit": "mm", "unit": "m", "values": [2, 3]}}'),
    ],
)
def test_a_name_that_occurs_twice_in_json_is_refused(tmp_path: Path, name: str, text: str) -> None:
    with refuses("columns", says="occurs twice"):
        read_record(text_file(tmp_path / name, text))
