"""What is of another kind than a function takes: a sentence says what to give."""

from dataclasses import dataclass
from typing import Any

import pytest

import axisid
from axisid import (
    Identification,
    Record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from tests.refusals import refuses


@dataclass(frozen=True)
class Context:
    axis: Any
    record: Any
    result: Any


@pytest.mark.parametrize("seed", [-1, 1.5], ids=str)
def test_a_seed_is_a_whole_number(given: Context, seed: Any) -> None:
    with refuses("result"):
        given.result["idm-ls"].propagate("M", draws=10, seed=seed)


@pytest.mark.parametrize("name", ["\0", "\ud800"], ids=repr)
def test_what_names_no_file_is_told(given: Context, name: str) -> None:
    for call in (
        lambda: axisid.load_result(name),
        lambda: axisid.export(name),
        lambda: axisid.compare_results(given.result, name),
    ):
        with refuses("result-file"):
            call()


@pytest.fixture(scope="module")
def given(emps2015: GeneratedAxis, twin: Record) -> Context:
    result: Identification = axisid.identify(emps2015, twin, methods="idm-ls")
    return Context(emps2015, twin, result)
