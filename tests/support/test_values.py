"""Values as text and numbers in it, tables and JSON, folders that are new, and what is deferred."""

import copy
import csv
import io
import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid.estimation.estimates import Value
from axisid.support.arrays import Deferred
from axisid.support.errors import plain_numbers, range_text
from axisid.support.files import csv_text, json_text, kept_if_filled
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


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (10.98, 11.04, "10.98 .. 11.04"),
        (10.99998, 11.00003, "10.99998 .. 11.00003"),
        (-2.0, 31.0, "-2 .. 31"),
        (1.20001e-7, 1.20004e-7, "1.20001e-07 .. 1.20004e-07"),
        (5.0, 5.0, "5 .. 5"),
    ],
)
def test_bounds_have_the_digits_that_tell_them_apart(low: float, high: float, text: str) -> None:
    assert range_text(low, high) == text


def test_an_interval_of_a_value_is_never_rounded_to_nothing() -> None:
    value = Value(
        value=183.2272658, unit="kg", deviations={"hac": 6e-5}, interval=(183.22715, 183.22738)
    )
    assert "95 %: 183.22715 to 183.22738 kg" in str(value)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("a force of 1e+02 N", "a force of 100 N"),
        ("by +3.1e+03 deviations.", "by +3100 deviations."),
        ("M by -1.234e+04 kg (2e+01 %), 9e+04", "M by -12340 kg (20 %), 90000"),
        ("Fc = 1e+05 N", "Fc = 100000 N"),
        ("1.2345e+02 m", "123.45 m"),
        ("Fc = 1.1e+05 N, 3e+06 N, 2e-06 m, 0.001 s", None),
        ("'1e+02.csv' and a/1e+02.csv, x1e+02, 1e+02**2, 1e+02.5", None),
    ],
)
def test_numbers_of_sentences_up_to_a_hundred_thousand_are_written_out(
    text: str, plain: str | None
) -> None:
    assert plain_numbers(text) == (text if plain is None else plain)


def test_nothing_is_worked_out_before_it_is_asked_for_and_then_once() -> None:
    made: list[int] = []
    deferred = Deferred(lambda: made.append(1) or len(made))
    assert not made
    assert [deferred.value, deferred.value] == [1, 1]


def test_a_pickle_has_the_value_and_not_the_way_to_it() -> None:
    deferred = Deferred(lambda: np.arange(3.0))  # no function without a name can be pickled
    again = pickle.loads(pickle.dumps(deferred))  # noqa: S301
    assert np.array_equal(again.value, [0.0, 1.0, 2.0])
    assert again == deferred == copy.deepcopy(deferred)
