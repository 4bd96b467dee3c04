"""What is of another kind than a function takes: a sentence says what to give."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import axisid
from axisid import (
    Identification,
    Record,
    UsageError,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from tests.refusals import refuses

_HUGE: Any = 10**400  # beyond floating point


@dataclass(frozen=True)
class Context:
    axis: Any
    record: Any
    result: Any


CASES: dict[str, tuple[Callable[[Context], object], str]] = {
    "a result as dictionary": (
        lambda g: axisid.load_result(g.result.to_dict()),
        "the result is a dict; give the file",
    ),
    "a live result as file": (
        lambda g: axisid.load_result(g.result),
        "the result is an Identification; give the file",
    ),
    "a built axis to fix": (
        lambda g: axisid.fix(g.axis, M=3.0),
        "the axis is a GeneratedAxis; give an Axis",
    ),
    "a number as method": (lambda g: g.result[3], "the result has no 3; choose from idm-ls"),
    "one axis to compare": (
        lambda g: axisid.compare(g.axis, g.record),
        "1 candidate cannot be compared; give two axes or more",
    ),
    "a list as figure": (lambda g: g.result.plot([]), r"has no figure \[\]; choose from record"),
    "a list as parameter": (
        lambda g: g.result["idm-ls"].parameters[[]],
        r"there is no \[\]; choose from M",
    ),
    "an array as draws": (
        lambda g: g.result.summary(draws=np.ones(3)),
        r"the draws are array\(\[1., 1., 1.\]\); give a whole number",
    ),
    "a period that is no number": (
        lambda _: axisid.Prefilter.suited(math.nan),
        "the sampling period is nan; give a positive number",
    ),
    "a cut-off beyond floating point": (
        lambda _: axisid.Prefilter(cutoff=_HUGE),
        "the cutoff is a whole number of 400 digits; give a number",
    ),
    "a sampling period beyond floating point": (
        lambda g: replace(g.record, sample_period=_HUGE),
        "the sampling period is a whole number of 400 digits; give a positive",
    ),
    "a period beyond floating point": (
        lambda g: axisid.simulate(g.axis, g.axis.nominal, g.record.reference, _HUGE),
        "the sampling period is a whole number of 400 digits; give a positive",
    ),
    "a start beyond floating point": (
        lambda g: axisid.simulate(
            g.axis, g.axis.nominal, g.record.reference, g.record.period, start=_HUGE
        ),
        "the start is a whole number of 400 digits; give a position",
    ),
    "a resolution beyond floating point": (
        lambda g: axisid.simulate(
            g.axis, g.axis.nominal, g.record.reference, g.record.period, resolution=_HUGE
        ),
        "the resolution is a whole number of 400 digits; give 0 or more",
    ),
}


@pytest.mark.parametrize("seed", [-1, 1.5], ids=str)
def test_a_seed_is_a_whole_number(given: Context, seed: Any) -> None:
    with refuses("draws-seed"):
        given.result["idm-ls"].propagate("M", draws=10, seed=seed)


@pytest.mark.parametrize("name", ["\0", "\ud800"], ids=repr)
def test_what_names_no_file_is_told(given: Context, name: str) -> None:
    for call in (
        lambda: axisid.load_result(name),
        lambda: axisid.export(name),
        lambda: axisid.compare_results(given.result, name),
    ):
        with refuses("bad-file-name"):
            call()


@pytest.fixture(scope="module")
def given(emps2015: GeneratedAxis, twin: Record) -> Context:
    result: Identification = axisid.identify(emps2015, twin, methods="idm-ls")
    return Context(emps2015, twin, result)


@pytest.mark.parametrize("name", CASES)
def test_what_is_of_another_kind_is_told(given: Context, name: str) -> None:
    call, said = CASES[name]
    with pytest.raises(UsageError, match=said) as refused:
        call(given)
    assert len(str(refused.value)) < 200, "a value of many lines is not shown"


def test_a_saved_result_has_the_methods_of_its_file(given: Context, tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    file.write_text(json.dumps(given.result.to_dict()))
    with refuses("no-such-estimate", "3; choose from idm-ls"):
        axisid.load_result(file)[3]  # type: ignore[index]
    with refuses("no-saved-draws"):
        axisid.load_result(file)["idm-ls"].propagate([])  # type: ignore[arg-type]
