"""Values as text and numbers in it, tables and JSON, folders that are new, and what is deferred.

Errors have a code, and a sentence that says what to do.
"""

import copy
import csv
import io
import itertools
import json
import math
import pickle
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import axisid
from axisid import AxisidError, Record, read_record
from axisid.codegen.generated_axes import write_files
from axisid.estimation import Repairs
from axisid.estimation.estimates import Value
from axisid.estimation.regression.simulated_instruments import loop_reference
from axisid.estimation.signals import FilteredRecord
from axisid.modeling.parsing.grammar import TextError
from axisid.support.arrays import Deferred
from axisid.support.errors import DeclarationError, plain_numbers, range_text
from axisid.support.files import csv_text, json_text
from docs.extensions.error_tables import coded_errors, page
from tests.files import text_file
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
    counted = itertools.count()
    deferred = Deferred(lambda: next(counted))
    assert next(counted) == 0
    assert [deferred.value, deferred.value] == [1, 1]


def test_a_pickle_has_the_value_and_not_the_way_to_it() -> None:
    deferred = Deferred(lambda: np.arange(3.0))  # no function without a name can be pickled
    again = pickle.loads(pickle.dumps(deferred))  # noqa: S301
    assert np.array_equal(again.value, [0.0, 1.0, 2.0])
    assert again == deferred == copy.deepcopy(deferred)


N = 400
TIME = 1e-3 * np.arange(N)
FILTER = axisid.Prefilter(cutoff=20.0)
POSITION = 3 * np.sin(30 * TIME)
GAP = np.where(np.arange(N) < 200, TIME, TIME + 0.5)
TEXT = "\n".join(
    ["time,position", *(f"{t:.3f},{float(q)!r}" for t, q in zip(TIME, POSITION, strict=True))]
)


BARE = Record(time=TIME, position=POSITION)
SLOW = Record(time=1e3 * TIME, position=POSITION)


def log(**columns: object) -> dict[str, object]:
    return {"time": TIME, "position": POSITION} | columns


def emps() -> axisid.codegen.GeneratedAxis:
    return axisid.build(axisid.load_axis("emps2015"), native=False)


def streamed(folder: Path) -> Path:
    """What a file of a result begins with that is no longer read."""
    return text_file(folder / "stream.json", json.dumps({"schema": "axisid.stream/1"}))


Case = Callable[[Path], object]
#: Codes, and what leads to an error of each.
CASES: list[tuple[str, Case]] = [
    ("uneven-time", lambda _: read_record(log(time=GAP))),
    ("time", lambda _: read_record(log(time=np.where(TIME < 0.2, TIME, TIME - 0.1)))),
    ("resampling", lambda _: read_record(log(), repairs=Repairs(resample=10.0))),
    ("uneven-time", lambda _: read_record(log(time=GAP), repairs=Repairs(resample="auto"))),
    ("time", lambda _: read_record({"position": POSITION})),
    ("empty-cells", lambda _: read_record(log(position=np.where(TIME == 0.1, np.nan, POSITION)))),
    ("wrap", lambda _: read_record(log(position=np.mod(40 * TIME, 2 * np.pi)))),
    ("wrap", lambda _: read_record(log(), repairs=Repairs(wrap=1.0))),
    ("log-text", lambda folder: read_record(text_file(folder / "log.csv", f"{TEXT}\n0.4"))),
    ("log-text", lambda folder: read_record(text_file(folder / "log.csv", f"{TEXT}\n0.400,a\n"))),
    ("memory", lambda folder: read_record(text_file(folder / "log.csv", TEXT), max_memory=1.0)),
    ("units", lambda _: read_record(log(), columns={"position": "position:furlong"})),
    ("units", lambda _: read_record(log(), columns={"position": "position:ms"})),
    ("columns", lambda _: read_record({"time": TIME, "q": POSITION})),
    ("columns", lambda _: read_record(log(), columns={"reference": "position"})),
    ("filter", lambda _: FilteredRecord.bind(emps(), SLOW, FILTER)),
    ("test-signal", lambda _: read_record(log(), injected_at="control")),
    ("test-signal", lambda _: read_record(log(e=POSITION), columns={"injected": "e"})),
    ("missing-column", lambda _: FilteredRecord.bind(emps(), BARE, FILTER).force),
    ("missing-column", lambda _: loop_reference(emps(), BARE)),
    ("comparison", lambda _: axisid.compare([emps()], BARE)),
    ("file", lambda folder: write_files(text_file(folder / "log.csv", ""), {Path("a"): "text"})),
    ("result-file", lambda folder: axisid.load_result(streamed(folder))),
]


@pytest.mark.parametrize(("code", "case"), CASES)
def test_error_says_what_to_do_and_not_by_options_alone(
    code: str, case: Case, tmp_path: Path
) -> None:
    with pytest.raises(AxisidError) as refused:
        case(tmp_path)
    error = refused.value
    assert error.code == code
    assert " --" not in str(error).replace("with --json", "")
    assert str(error).endswith((".", ")"))
    kept = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert (kept.code, str(kept)) == (code, str(error))


@pytest.mark.parametrize(
    "error",
    [DeclarationError("two mistakes:", ["a", "b\nc"]), TextError("why.", "a + ", 4, code="b")],
)
def test_errors_of_several_parts_survive_a_pickle(error: AxisidError) -> None:
    kept = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert str(kept) == str(error)
    assert vars(kept) == vars(error)


@pytest.mark.slow
def test_codes_are_few_words() -> None:
    """One for each kind of error and stage, such as ``log-text``."""
    codes = {error.code for error in coded_errors()}
    assert all(re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", code) for code in codes)
    assert len(codes) < 100


@pytest.mark.slow
def test_page_of_errors_lists_every_code(root: Path) -> None:
    assert "error_tables import page" in (root / "docs" / "errors.py").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `([a-z0-9-]+)`", page(), re.MULTILINE)
    assert listed == sorted({error.code for error in coded_errors()})
    assert {*(code for code, _ in CASES), "usage", "data"} <= {*listed}
