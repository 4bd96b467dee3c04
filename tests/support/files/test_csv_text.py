"""Texts of tables and of JSON, and folders that are new."""

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

import pytest

from axisid.support.files.csv_text import csv_text
from axisid.support.files.json_text import json_text
from axisid.support.files.regular_file import kept_if_filled
from tests.refusals import refuses


def _read(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text, newline="")))


def test_rows_are_read_back_as_they_were() -> None:
    rows = [["name", "M [kg]"], ['a, "b"\nc', -1.5e-7], ["", None], ["20 °C", 0.1 + 0.2]]
    assert _read(csv_text(rows)) == [
        ["name", "M [kg]"],
        ['a, "b"\nc', "-1.5e-07"],
        ["", ""],
        ["20 °C", "0.30000000000000004"],
    ]


@pytest.mark.parametrize(
    "text", ["=HYPERLINK(A1)", "+1+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1"]
)
def test_a_text_that_begins_as_a_formula_stays_text(text: str) -> None:
    assert _read(csv_text([[text]])) == [[f"'{text}"]]


def test_a_carriage_return_begins_no_row() -> None:
    assert _read(csv_text([["\r=1", "a\r=2"]])) == [["'\n=1", "a\n=2"]]


@pytest.mark.parametrize("text", ["-20", "+1e3", "a=b", "1-2"])
def test_numbers_and_other_texts_stay_as_they_are(text: str) -> None:
    assert _read(csv_text([[text]])) == [[text]]


def test_a_result_is_written_on_several_lines_and_read_back_as_it_was() -> None:
    result = {"axis": "a", "values": [1.0, 0.1, -2e-300, None, True], "record": {"samples": 3}}
    text = json_text(result)
    assert json.loads(text) == result
    assert text.count("\n") > len(result)
    assert text.endswith("}\n")


@pytest.mark.parametrize(
    ("result", "place", "value"),
    [
        ({"condition": math.inf}, "condition", "inf"),
        ({"condition": -math.inf}, "condition", "-inf"),
        ({"condition": math.nan}, "condition", "nan"),
        ({"a": {"b": [1.0, math.nan]}}, r"a\.b\.1", "nan"),
        ({"a": ({"b": 1.0}, {"b": math.inf})}, r"a\.1\.b", "inf"),
        ({"first": 1.0, "second": math.inf, "third": math.nan}, "second", "inf"),
        ({"estimates": [{"parameters": {"M": {"value": math.inf}}}]},
         r"estimates\.0\.parameters\.M\.value", "inf"),
    ],
)  # fmt: skip
def test_a_number_that_json_does_not_know_is_refused_by_its_place(
    result: dict[str, Any], place: str, value: str
) -> None:
    with refuses(
        "result-file", says=rf"^the result cannot be written as JSON, since {place} is {value}\."
    ):
        json_text(result)


def test_the_refusal_says_what_to_check() -> None:
    with refuses("result-file"):
        json_text({"a": math.inf})


@pytest.mark.parametrize(("was_there", "filled"), [(False, False), (False, True), (True, False)])
def test_a_new_folder_goes_again_where_nothing_came_into_it(
    tmp_path: Path, was_there: bool, filled: bool
) -> None:
    place = tmp_path / "out"
    if was_there:
        place.mkdir()
    with pytest.raises(KeyError), kept_if_filled(place):
        if filled:
            (place / "a").touch()
        raise KeyError
    assert place.exists() == (was_there or filled)


def test_a_folder_that_is_done_with_stays(tmp_path: Path) -> None:
    with kept_if_filled(tmp_path / "of" / "results"):
        pass
    assert (tmp_path / "of" / "results").is_dir()
