"""One sentence over all checks, the gravest first; one that faults costs no estimate."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from axisid import Prefilter, Record, build, fit, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import Check, Status
from axisid.estimation.diagnostics.diagnose import (
    DIAGNOSTICS,
    Diagnostic,
    belief,
    conclusion,
)
from axisid.presentation.report.page import report_html
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from tests.axes.servo import TRUTH, servo, servo_log, servo_record
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


def _to_and_fro(time: Array) -> Array:
    return np.sin(time) * np.pi / 2 + 0.8 * np.sin(5 * time) * np.sin(2 * time)


@pytest.fixture(scope="module")
def joint() -> GeneratedAxis:
    return build(servo())


def _broken(*_: object, **__: object) -> None:
    raise ValueError("matmul")


@pytest.mark.slow
def test_logs_of_other_lengths_whose_control_is_late_are_judged(
    joint: GeneratedAxis, tmp_path: Path
) -> None:
    """The delay of a control is told by the rows of its own record."""
    records = [
        servo_record(joint, servo_log(joint, tmp_path / name, motion, seconds, late=1))
        for name, motion, seconds in (
            ("a.json", _to_and_fro, 5.0),
            ("b.json", lambda t: np.sin(t**2), 4.0),
        )
    ]
    result = identify(joint, records, methods=["idm-ls", "idm-iv"])
    law = next(check for check in result.verdict if check.name == "control law")
    assert law.status == "fail"
    assert "1 sample later" in law.meaning
    assert not [check for check in result.verdict if "fault" in check.meaning]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "seconds"),
    [(lambda t: 0.6 * t, 1.8), (lambda t: 0.2 * np.minimum(t, 0.2), 1.0)],
    ids=["one way", "fewer rows than parameters"],
)
def test_log_that_does_not_tell_all_costs_no_estimate(
    tmp_path: Path, motion: Callable[[Array], Array], seconds: float
) -> None:
    """In it friction is a constant force, or it rests; the other one tells them apart."""
    joint = build(servo(with_offset=True))
    files = [
        servo_log(joint, tmp_path / "a.json", _to_and_fro, 5.0),
        servo_log(joint, tmp_path / "b.json", motion, seconds),
    ]
    records = [servo_record(joint, file) for file in files]
    result = identify(joint, records, methods=["idm-ls", "idm-iv"])
    assert all(part.verdict for part in (result, *result.parts))
    assert result["idm-iv"].parameters["mgl"].value == pytest.approx(TRUTH["mgl"], rel=0.02)
    assert isinstance(result.diagnosis.records[1].alignment, Missing)


@pytest.mark.parametrize("by_record", [False, True])
def test_check_that_faults_is_told_and_the_estimates_stand(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch, by_record: bool
) -> None:
    monkeypatch.delenv("AXISID_DEBUG", raising=False)
    broken = Diagnostic(name="precision", check=_broken, by_record=by_record)
    monkeypatch.setitem(DIAGNOSTICS, "precision", broken)
    result = identify(emps2015, twin, methods="idm-ls")
    found = next(check for check in result.verdict if check.name == "precision")
    assert found.status == "fail"
    assert "by a fault (ValueError: matmul): please report" in found.meaning
    assert "M" in result["idm-ls"].parameters


@pytest.mark.slow
def test_fit_keeps_its_estimates_beside_checks_that_fault(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("AXISID_DEBUG", raising=False)
    for place in ("result.find_misspecification", "result.move_by_record"):
        monkeypatch.setattr(f"axisid.estimation.fitting.{place}", _broken)
    result = fit(emps2015, twin)
    faulty = {check.name for check in result.checks if "by a fault" in check.meaning}
    assert {"missing terms", "law's factors"} <= faulty
    assert result["M"].value == pytest.approx(100.2, rel=1e-3)
    assert "by a fault" in result.summary()
