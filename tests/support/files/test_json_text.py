"""Results as JSON hold no infinite number, and say where one stood."""

import json
import math
from typing import Any

import pytest

from axisid.support.files.json_text import json_text
from tests.refusals import refuses


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
        "not-json", says=rf"^the result cannot be written as JSON, since {place} is {value}\."
    ):
        json_text(result)


def test_the_refusal_says_what_to_check() -> None:
    with refuses("not-json"):
        json_text({"a": math.inf})
