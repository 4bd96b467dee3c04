"""One sentence over all checks, the gravest first."""

import json
import re

import pytest

from axisid import Prefilter, Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks.check import Check, Status
from axisid.estimation.diagnostics.diagnose import (
    DIAGNOSTICS,
    Diagnostic,
    belief,
    conclusion,
)
from axisid.presentation.report.page import report_html
from tests.recipes import recipe_blocks


def check(name: str, status: Status) -> Check:
    return Check(name=name, status=status, meaning="so")


@pytest.mark.parametrize(
    ("checks", "said"),
    [
        (
            (check("control law", "pass"), check("lack of fit", "note")),
            "Nothing that was checked speaks against these numbers.",
        ),
        (
            (check("control law", "not evaluated"), check("precision", "not evaluated")),
            "Nothing that was checked speaks against these numbers; not checked: law.",
        ),
        (
            (check("control law", "not evaluated"), check("alignment", "fail")),
            "Believe these numbers with care; to look at: timing; not checked: law.",
        ),
        (
            (check("control law", "not evaluated"), check("missing terms", "not evaluated")),
            "Nothing that was checked speaks against these numbers; not checked: model, law.",
        ),
        (
            (check("alignment", "fail"), check("outliers", "fail")),
            "Believe these numbers with care; to look at: outliers, timing.",
        ),
        (
            (check("precision", "fail"), check("bounds", "fail"), check("control law", "fail")),
            "Do not believe these numbers before this is mended: law.",
        ),
    ],
)
def test_the_gravest_failure_decides(checks: tuple[Check, ...], said: str) -> None:
    assert conclusion(checks) == said
    found = belief([each.name for each in checks if each.status == "fail"])
    starts = {"Nothing": "believed", "Believe": "with care", "Do not": "not believed"}
    assert found == next(starts[begin] for begin in starts if said.startswith(begin))


def test_a_right_model_on_a_good_record_is_believed(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, twin, Prefilter(cutoff=40.0, decimate=20))
    assert conclusion(result.verdict).startswith("Nothing")
    assert conclusion(result.verdict) in result.summary()


def test_one_file_and_one_row_add_a_diagnostic(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The recipe's goes through verdict, text, notebook, JSON and page."""
    module, row = recipe_blocks("Add a diagnostic")
    package = "axisid.estimation.diagnostics"
    names = {"__name__": f"{package}.turns", "__package__": package, "Diagnostic": Diagnostic}
    exec(module, names)
    monkeypatch.setitem(DIAGNOSTICS, "turns", eval(row, names))  # noqa: S307
    result = identify(emps2015, twin)
    found = result.verdict[-1]
    assert (found.name, found.status) == ("turns", "pass")
    assert re.search(r"^turns +pass +18 +4 ", result.summary(full=True), re.MULTILINE)
    assert '<th class="text">turns</th>' in report_html(result)
    written = json.loads(json.dumps(result.to_dict()))
    assert [c["meaning"] for c in written["verdict"] if c["name"] == "turns"] == [found.meaning]
