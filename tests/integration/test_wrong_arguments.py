"""What is of another kind than a function takes: a sentence says what to give."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import axisid
from axisid import Identification, Record, UsageError
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import LogBlocks, identify_stream


@dataclass(frozen=True)
class Given:
    axis: Any
    record: Any
    result: Any


CASES: dict[str, tuple[Callable[[Given], object], str]] = {
    "a result as dictionary": (
        lambda g: axisid.load_result(g.result.to_dict()),
        "the result is a dict; give the file",
    ),
    "a live result as file": (
        lambda g: axisid.load_result(g.result),
        "the result is an Identification; give the file",
    ),
    "nothing to compare": (
        lambda g: axisid.compare_results(g.result, None),  # type: ignore[arg-type]
        "the result is None; give the file",
    ),
    "columns as text": (
        lambda _: axisid.read_record("log.csv", columns="position=q"),  # type: ignore[arg-type]
        "the columns are 'position=q'; give names by role",
    ),
    "columns as list": (
        lambda _: axisid.read_record("log.csv", columns=["q", "u"]),  # type: ignore[arg-type]
        r"the columns are \['q', 'u'\]; give names by role",
    ),
    "repairs as dictionary": (
        lambda _: axisid.read_record("log.csv", repairs={"gaps": "split"}),  # type: ignore[arg-type]
        r"the repairs are \{'gaps': 'split'\}; give axisid.estimation.Repairs",
    ),
    "an axis by name": (
        lambda _: axisid.read_record("log.csv", "emps"),  # type: ignore[arg-type]
        "the axis is 'emps'; give an Axis",
    ),
    "a name to build": (lambda _: axisid.build("emps"), "the axis is 'emps'; give an Axis"),  # type: ignore[arg-type]
    "a name to derive": (lambda _: axisid.derive("emps"), "the axis is 'emps'; give an Axis"),  # type: ignore[arg-type]
    "a built axis to fix": (
        lambda g: axisid.fix(g.axis, M=3.0),
        "the axis is a GeneratedAxis; give an Axis",
    ),
    "an array as record": (
        lambda g: axisid.identify(g.axis, np.ones((9, 3))),  # type: ignore[arg-type]
        "the record is a ndarray; read one",
    ),
    "a file to validate on": (
        lambda g: axisid.validate(g.result, "log.csv"),  # type: ignore[arg-type]
        "the record is 'log.csv'; read one",
    ),
    "nothing to validate": (
        lambda g: axisid.validate(None, g.record),  # type: ignore[arg-type]
        "the result is None; give what identify gave",
    ),
    "a number as method": (lambda g: g.result[3], "the result has no 3; choose from idm-ls"),
    "one axis to compare": (
        lambda g: axisid.compare(g.axis, g.record),
        "1 candidate cannot be compared; give two axes or more",
    ),
    "a name as axis of blocks": (
        lambda _: LogBlocks(file="log.csv", axis="emps"),  # type: ignore[arg-type]
        "the axis is 'emps'; give an Axis",
    ),
    "a file as blocks": (
        lambda g: identify_stream(g.axis, "log.csv"),  # type: ignore[arg-type]
        "the blocks are 'log.csv'; give LogBlocks",
    ),
    "a text as seed": (
        lambda g: axisid.twin_record(g.axis, seed="x"),  # type: ignore[arg-type]
        "the seed is 'x'; give a whole number",
    ),
}


@pytest.fixture(scope="module")
def given(emps2015: GeneratedAxis, twin: Record) -> Given:
    result: Identification = axisid.identify(emps2015, twin, methods="idm-ls")
    return Given(emps2015, twin, result)


@pytest.mark.parametrize("name", CASES)
def test_what_is_of_another_kind_is_told(given: Given, name: str) -> None:
    call, said = CASES[name]
    with pytest.raises(UsageError, match=said) as refused:
        call(given)
    assert len(str(refused.value)) < 200, "a value of many lines is not shown"


def test_a_saved_result_has_the_methods_of_its_file(given: Given, tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    file.write_text(json.dumps(given.result.to_dict()))
    with pytest.raises(UsageError, match="the result has no 3; choose from idm-ls"):
        axisid.load_result(file)[3]  # type: ignore[index]
