"""The study of verdicts in small: right machines hold, wrong ones are named, all is counted."""

from importlib import import_module
from typing import Any

import pytest

study: Any = import_module("verdicts")


@pytest.mark.slow
@pytest.mark.parametrize("by", ["identify", "control"])
@pytest.mark.parametrize("name", ["PD, 2 s", "P-PI, 5 ms, 1 um, dwells"])
def test_a_right_machine_passes_and_holds(name: str, by: str) -> None:
    found = study.right_figures(study.runs_of(name, runs=3, seed=1, by=(by,))[by])
    assert (found["fail"], found["not"]) == (0, 0)
    assert found["hold"] > 75


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "by"),
    [
        ("quadratic", "identify"),
        ("offset", "identify"),
        ("offset", "control"),
        ("cogging", "identify"),
    ],
)
def test_what_is_wrong_is_named(fault: str, by: str) -> None:
    named = study.cases(1)[f"{fault}; stage"].named
    found = study.wrong_figures(
        study.runs_of(f"{fault}; stage", runs=3, seed=1, by=(by,))[by], named
    )
    assert (found["runs"], found["noticed"], found["named"]) == (1, 1, 1)
