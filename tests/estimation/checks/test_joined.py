"""One check of each of several records is one of all, which names the record that fails."""

from dataclasses import replace

from axisid.estimation.checks import Check, joined
from axisid.support.errors import Missing

PASSED = Check(name="lack of fit", status="pass", meaning="nothing", figure=1.0, threshold=2.0)
FAILED = replace(PASSED, status="fail", meaning="there is one: go on")


def test_the_worst_of_several_checks_is_told_with_its_record() -> None:
    found = joined([PASSED, replace(FAILED, figure=9.0), replace(FAILED, figure=3.0)], "abc")
    assert (found.status, found.figure) == ("fail", 9.0)
    assert found.meaning == "b and c: there is one: go on"


def test_other_records_that_fail_otherwise_are_named_too() -> None:
    other = replace(FAILED, meaning="there are two")
    found = joined([PASSED, replace(FAILED, figure=9.0), other], "abc")
    assert found.meaning == "b: there is one: go on; it fails of c too"


def test_what_passes_everywhere_passes_and_what_cannot_be_told_says_so() -> None:
    assert joined([PASSED, PASSED], "ab") == PASSED
    missing = Check.not_evaluated("lack of fit", Missing("there is none"))
    half = joined([PASSED, missing], "ab")
    assert half.meaning == "nothing (not evaluated of b)"
    assert joined([missing, None], "ab") == missing
    assert joined([None, None], "ab") is None
