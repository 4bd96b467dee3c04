"""One check of each record is one of all; one that faults says so in its place."""

from dataclasses import replace

import pytest

from axisid.estimation.verdict_checks import Check, Fault, joined, unless_faulty
from axisid.support.errors import CandidateError, EstimationError, Missing

PASSED = Check(name="lack of fit", status="pass", meaning="nothing", figure=1.0, threshold=2.0)
FAILED = replace(PASSED, status="fail", meaning="there is one: go on")


MISSING = Check.not_evaluated("lack of fit", Missing("there is none"))


@pytest.mark.parametrize(
    ("found", "joint"),
    [
        (
            [PASSED, replace(FAILED, figure=9.0), replace(FAILED, figure=3.0)],
            replace(FAILED, figure=9.0, meaning="b and c: there is one: go on"),
        ),
        (
            [PASSED, replace(FAILED, figure=9.0), replace(FAILED, meaning="there are two")],
            replace(FAILED, figure=9.0, meaning="b: there is one: go on; it fails of c too"),
        ),
        ([PASSED, PASSED], PASSED),
        ([PASSED, MISSING], replace(PASSED, meaning="nothing (not evaluated of b)")),
        ([MISSING, None], MISSING),
        ([None, None], None),
    ],
)
def test_the_worst_of_several_checks_is_told_with_its_records(
    found: list[Check | None], joint: Check | None
) -> None:
    assert joined(found, "abc"[: len(found)]) == joint


def _raising(error: Exception) -> float:
    raise error


def test_fault_is_said_with_what_it_was_and_a_refusal_keeps_its_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("AXISID_DEBUG", raising=False)
    found = unless_faulty(lambda: _raising(ZeroDivisionError("by nothing")))
    assert isinstance(found, Missing)
    for said in ("could not be made, by a fault", "ZeroDivisionError: by nothing", "please report"):
        assert said in found.reason
    found = unless_faulty(lambda: _raising(EstimationError("too few rows are left.")))
    assert found == Missing("too few rows are left.")
    assert isinstance(unless_faulty(lambda: _raising(CandidateError("mend it."))), Fault)


@pytest.mark.parametrize(("debug", "error"), [("1", KeyError), ("", MemoryError)])
def test_fault_is_raised_where_tracebacks_are_asked_for_and_want_of_memory_always(
    monkeypatch: pytest.MonkeyPatch, debug: str, error: type[Exception]
) -> None:
    monkeypatch.setenv("AXISID_DEBUG", debug)
    with pytest.raises(error):
        unless_faulty(lambda: _raising(error("x")))
