"""What all checks say together; one check of each record is one of all; one that faults says so."""

from dataclasses import fields, replace
from itertools import permutations

import pytest

from axisid.estimation.findings import Finding, FindingExceptFor, FindingOfRecords, Said
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
from axisid.support.errors import CandidateError, EstimationError
from axisid.support.missing import Missing


def ended(name: str, status: Status) -> Check:
    """A check that ended so."""
    if status == "not evaluated":
        return Check.not_evaluated(name, Missing("it is not in the record"))
    return Check(name=name, status=status, finding=Said(text="so"))


@pytest.mark.parametrize("first", KINDS)
def test_any_serious_failure_decides_whatever_fails_beside_it(first: str) -> None:
    for second in KINDS:
        serious = KINDS[first].grave or KINDS[second].grave
        for names in permutations((first, second)):
            checks = [ended(name, "fail") for name in names]
            assert belief(checks) == ("not believed" if serious else "with care"), names
            assert conclusion(checks).belief == belief(checks)


def test_the_headline_names_the_serious_failure_and_what_comes_before_it() -> None:
    checks = [ended(name, "fail") for name in ("bounds", "outliers", "precision")]
    found = conclusion(checks)
    assert (found.first, found.decisive) == (("outliers", "precision"), None)
    assert found.failed == ("outliers", "precision")
    found = conclusion([checks[0], ended("precision", "fail")])
    assert (found.first, found.decisive) == (("precision",), "bounds")
    found = conclusion([ended("precision", "fail"), ended("rows", "fail")])
    assert (found.first, found.decisive) == (("precision",), "precision")
    found = conclusion([ended("missing terms", "fail"), ended("moved parameters", "fail")])
    assert (found.first, found.decisive) == (("model",), "moved parameters")


def test_a_fault_that_decides_is_no_reason_against_the_numbers() -> None:
    fault = Check.not_evaluated("control law", Fault("by a fault"))
    for check in (fault, joined([fault, ended("control law", "pass")], ("a", "b"))):
        assert check is not None
        found = conclusion([check])
        assert (found.decisive, found.is_faulty) == ("control law", True)
    assert not conclusion([ended("control law", "fail")]).is_faulty


NEEDED = ("control law", "simulation", "missing terms", "noise in the loop")


@pytest.mark.parametrize("name", NEEDED)
def test_what_the_numbers_rely_on_and_was_not_checked_is_named(name: str) -> None:
    checks = [ended(name, "not evaluated"), ended("precision", "pass")]
    assert belief(checks) == "with care"
    found = conclusion(checks)
    assert (found.unchecked, found.left_open) == ((KINDS[name].line,), (name,))


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
    assert (conclusion([unused]).unchecked, conclusion([unused]).left_open) == (("law",), ())


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


ONE, TWO = Said(text="there is one"), Said(text="there are two")
PASSED = Check(
    name="lack of fit", status="pass", finding=Said(text="nothing"), figure=1.0, threshold=2.0
)
FAILED = replace(PASSED, status="fail", finding=ONE, figure=9.0)
MISSING = Check.not_evaluated("lack of fit", Missing("there is none"))


def of_records(records: tuple[str, ...], others: tuple[str, ...]) -> FindingOfRecords:
    return FindingOfRecords(finding=ONE, records=records, others=others, fails=True)


@pytest.mark.parametrize(
    ("found", "joint"),
    [
        (
            [PASSED, FAILED, replace(FAILED, figure=3.0)],
            replace(FAILED, finding=of_records(("b", "c"), ())),
        ),
        (
            [PASSED, FAILED, replace(FAILED, figure=3.0, finding=TWO)],
            replace(FAILED, finding=of_records(("b",), ("c",))),
        ),
        ([PASSED, PASSED], PASSED),
        (
            [PASSED, MISSING],
            replace(PASSED, finding=FindingExceptFor(finding=PASSED.finding, unmade=("b",))),
        ),
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
    assert isinstance(found, Fault)
    assert "ZeroDivisionError: by nothing" in found.reason
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


def test_no_finding_has_a_field_with_the_name_of_its_kind_in_a_file() -> None:
    kinds = [*Finding.__subclasses__()]
    for kind in kinds:
        kinds += kind.__subclasses__()
        assert "kind" not in {field.name for field in fields(kind)}, kind
