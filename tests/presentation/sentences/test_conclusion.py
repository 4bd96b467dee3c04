"""Headlines of a verdict: the belief first, then the reason and what was not checked."""

import pytest

from axisid.estimation.diagnostics import MovedParameter
from axisid.estimation.findings import Finding, FindingOfRecords, ReadFinding
from axisid.estimation.verdict_checks import KINDS, Conclusion
from axisid.presentation.sentences import conclusion_text


@pytest.mark.parametrize(
    ("conclusion", "parts"),
    [
        (Conclusion(belief="believed"), ["All checks passed."]),
        (
            Conclusion(belief="believed", unchecked=("method",)),
            ["that were made passed", "Not checked: agreement of the methods."],
        ),
        (
            Conclusion(belief="with care", unchecked=("law",), left_open=("control law",)),
            ["Use with care: the control law was not checked.", "log the reference"],
        ),
        (
            Conclusion(
                belief="with care",
                first=("model",),
                failed=("model",),
                decisive="missing terms",
                unchecked=("loop",),
                left_open=("noise in the loop",),
            ),
            ["Use with care: the model", "Not checked: simulated loop.", "record a longer motion"],
        ),
        (
            Conclusion(belief="with care", first=("timing", "model"), failed=("timing", "model")),
            ["Use with care: ", "timing and model"],
        ),
        (
            Conclusion(
                belief="not believed", first=("law",), failed=("law",), decisive="control law"
            ),
            ["Do not use these numbers: the recorded control does not follow the declared control"],
        ),
        (
            Conclusion(
                belief="not believed", first=("outliers", "precision"), failed=("outliers",)
            ),
            ["Do not use these numbers: ", "outliers and precision"],
        ),
        (
            Conclusion(
                belief="not believed",
                first=("law",),
                failed=("law",),
                decisive="control law",
                is_faulty=True,
            ),
            ["Do not use these numbers: ", "'control law'", "fault"],
        ),
        (
            Conclusion(belief="with care", first=("turns",), failed=("turns",), decisive="turns"),
            ["Use with care: ", "'turns'"],
        ),
    ],
)
def test_a_headline_has_the_belief_then_the_reason(
    conclusion: Conclusion, parts: list[str]
) -> None:
    text = conclusion_text(conclusion)
    assert [part for part in parts if part not in text] == []
    assert text.endswith(".")


MOVED = MovedParameter(parameter="Fv", percent=50.0, most_percent=30.0, is_changing=False)
READ = {"kind": "MovedParameter", "parameter": "Fv", "percent": 50.0, "is_changing": False}


@pytest.mark.parametrize(
    "finding",
    [
        MOVED,
        FindingOfRecords(finding=MOVED, records=("a",), others=(), fails=True),
        ReadFinding(text="", data=READ),
        ReadFinding(text="", data={"kind": "FindingOfRecords", "finding": READ}),
    ],
)
def test_a_parameter_that_changes_too_much_is_named(finding: Finding) -> None:
    line = KINDS["moved parameters"].line
    found = Conclusion(
        belief="not believed",
        first=(line,),
        failed=(line,),
        decisive="moved parameters",
        finding=finding,
    )
    assert "changes Fv by 50 % of its value" in conclusion_text(found)


@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind.grave])
def test_every_grave_check_has_a_plain_reason(name: str) -> None:
    line = KINDS[name].line
    found = Conclusion(belief="not believed", first=(line,), failed=(line,), decisive=name)
    assert repr(name) not in conclusion_text(found)


@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind.needed])
def test_every_needed_check_has_a_remedy(name: str) -> None:
    line = KINDS[name].line
    without = Conclusion(belief="with care", unchecked=(line,))
    found = Conclusion(belief="with care", unchecked=(line,), left_open=(name,))
    assert len(conclusion_text(found)) > len(conclusion_text(without)) + 20
