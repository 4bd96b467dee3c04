"""Values as text, tables and JSON, and what is deferred."""

import copy
import csv
import io
import itertools
import json
import math
import pickle

import numpy as np

from axisid.estimation.estimates import Value
from axisid.support.arrays import Deferred
from axisid.support.files import csv_text, json_text
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


FORMULAS = ("=HYPERLINK(A1)", "+1+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1")
OTHERS = ("-20", "+1e3", "a=b", "1-2")


def test_a_text_that_begins_as_a_formula_stays_text_and_no_return_begins_a_row() -> None:
    assert _read(csv_text([FORMULAS, OTHERS])) == [[f"'{text}" for text in FORMULAS], [*OTHERS]]
    assert _read(csv_text([["\r=1", "a\r=2"]])) == [["'\n=1", "a\n=2"]]


def test_a_result_is_written_on_several_lines_and_read_back_as_it_was() -> None:
    result = {"axis": "a", "values": [1.0, 0.1, -2e-300, None, True], "record": {"samples": 3}}
    text = json_text(result)
    assert json.loads(text) == result
    assert text.count("\n") > len(result)
    assert text.endswith("}\n")


def test_a_number_that_json_does_not_know_is_refused_by_its_place() -> None:
    for value in (math.inf, math.nan):
        with refuses("result-file", says=rf"because a\.1\.b is {value}\."):
            json_text({"a": ({"b": 1.0}, {"b": value})})


def test_an_interval_of_a_value_is_never_rounded_to_nothing() -> None:
    value = Value(
        value=183.2272658, unit="kg", deviations={"hac": 6e-5}, interval=(183.22715, 183.22738)
    )
    assert "95 %: 183.22715 to 183.22738 kg" in str(value)


def test_nothing_is_worked_out_before_it_is_asked_for_and_then_once() -> None:
    counted = itertools.count()
    deferred = Deferred(lambda: next(counted))
    assert next(counted) == 0
    assert [deferred.value, deferred.value] == [1, 1]


def test_a_pickle_has_the_value_and_not_the_way_to_it() -> None:
    deferred = Deferred(lambda: np.arange(3.0))  # no function without a name can be pickled
    again = pickle.loads(pickle.dumps(deferred))  # noqa: S301
    assert np.array_equal(again.value, [0.0, 1.0, 2.0])
    assert again == deferred == copy.deepcopy(deferred)
