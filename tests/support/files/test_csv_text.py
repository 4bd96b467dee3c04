"""Tables as CSV are read back as they were, and run nothing in a spreadsheet."""

import csv
import io

import pytest

from axisid.support.files.csv_text import csv_text


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
