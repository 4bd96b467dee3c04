"""What all checks say together; one check of each record is one of all; one that faults says so."""

from dataclasses import replace
from itertools import permutations

import pytest

from axisid.estimation.verdict_checks import (
    KINDS,
    Belief,
    Check,
    Fault,
    NotUsed,
    Status,
    belief,
    conclusion,
    joined,
    unless_faulty,
)
from axisid.support.errors import CandidateError, EstimationError, Missing


def ended(name: str, status: Status) -> Check:
    """A check that ended so."""
    if status == "not evaluated":
        return Check.not_evaluated(name, Missing("it is not in the record"))
    return Check(name=name, status=status, meaning="so")


@pytest.mark.parametrize("first", KINDS)
def test_any_serious_failure_decides_whatever_fails_beside_it(first: str) -> None:
    for second in KINDS:
        serious = KINDS[first].grave or KINDS[second].grave
        for names in permutations((first, second)):
            checks = [ended(name, "fail") for name in names]
            assert belief(checks) == ("not believed" if serious else "with care"), names
            assert conclusion(checks).startswith("Do not use" if serious else "Use with care")


def test_the_headline_names_the_serious_failure_and_what_comes_before_it() -> None:
    checks = [ended(name, "fail") for name in ("bounds", "outliers", "precision")]
    assert conclusion(checks).endswith("Correct this first: outliers, precision.")
    assert conclusion(checks[:1]).endswith("Correct this first: precision.")


NEEDED = ("control law", "simulation", "missing terms", "noise in the loop")


@pytest.mark.parametrize("name", NEEDED)
def test_what_the_numbers_rest_on_and_was_not_checked_is_named_with_its_remedy(name: str) -> None:
    checks = [ended(name, "not evaluated"), ended("precision", "pass")]
    assert belief(checks) == "with care"
    said, kind = conclusion(checks), KINDS[name]
    assert f"Not checked: {kind.line}." in said
    assert f"To check the {kind.line}, {kind.remedy}." in said


@pytest.mark.parametrize("name", sorted(KINDS.keys() - set(NEEDED)))
def test_other_checks_that_could_not_be_made_leave_a_result_believed(name: str) -> None:
    assert belief([ended(name, "not evaluated")]) == "believed"


def test_a_law_that_the_result_does_not_use_need_not_be_checked() -> None:
    unused = Check.not_evaluated("control law", NotUsed("there is none"))
    assert (unused.status, unused.leaves_open, belief([unused])) == (
        "not evaluated",
        False,
        "believed",
    )
    assert "Not checked: law." in conclusion([unused])


def test_a_check_that_was_made_of_some_records_alone_leaves_the_others_open() -> None:
    made, unmade = ended("control law", "pass"), ended("control law", "not evaluated")
    for found, expected in (
        ([made, unmade], "with care"),
        ([unmade, made], "with care"),
        ([made, None], "believed"),
        ([made, Check.not_evaluated("control law", NotUsed("there is none"))], "believed"),
    ):
        both = joined(found, ("a", "b"))
        assert both is not None
        assert belief([both]) == expected


@pytest.mark.parametrize(
    ("checks", "found"),
    [
        ((ended("control law", "pass"), ended("lack of fit", "note")), "believed"),
        ((ended("alignment", "fail"), ended("outliers", "fail")), "with care"),
        ((ended("method", "not evaluated"), ended("alignment", "fail")), "with care"),
        ((), "believed"),
    ],
)
def test_belief(checks: tuple[Check, ...], found: Belief) -> None:
    assert belief(checks) == found


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
