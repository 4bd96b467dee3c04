"""The two forms of least squares, whose quotient is a correlation."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, identify, load_axis
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import conclusion
from axisid.estimation.diagnostics.estimates import forms_check
from axisid.estimation.noise import Attenuation
from axisid.support.missing import Missing
from axisid.support.remedy import as_options


def test_quotient_of_the_inertias_is_r_squared_of_a_regression_by_others(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """The partial correlation from residuals of NumPy's own least squares."""
    result = identify(emps2015, twin)
    found = result.diagnosis.attenuation
    assert isinstance(found, Attenuation)
    ls = result["idm-ls"]
    others = ls.X[:, 1:]
    left = [c - others @ np.linalg.lstsq(others, c, rcond=None)[0] for c in (ls.y, ls.X[:, 0])]
    assert found.r_squared == pytest.approx(np.corrcoef(*left)[0, 1] ** 2, rel=1e-3)
    assert found.r_squared < 1
    assert found.identity_error < 1e-9
    assert found.inverse == pytest.approx(ls.parameters["M"].value, rel=1e-12)
    assert found.direct == pytest.approx(result["ddm-ls"].parameters["M"].value, rel=1e-9)
    assert found.inverse / found.direct == pytest.approx(found.r_squared, rel=1e-9)


def test_it_is_not_told_without_both(emps2015: GeneratedAxis, twin: Record) -> None:
    alone = identify(emps2015, twin, methods=["idm-ls", "idm-iv"])
    assert isinstance(alone.diagnosis.attenuation, Missing)
    assert "inverse against direct" not in {check.name for check in alone.verdict}


def test_other_units_of_the_force_change_nothing(twin: Record) -> None:
    axis = load_axis("emps2015")
    assert twin.control is not None
    measured = replace(twin, force=35.15 * twin.control)
    by_force = identify(axis, measured, methods=["idm-ls", "ddm-ls"]).diagnosis.attenuation
    assert isinstance(by_force, Attenuation)
    assert by_force.identity_error < 1e-9


def _judged(*, by_instruments: bool, **changes: float) -> Check:
    found = Attenuation(
        parameter="M", inverse=99.9, direct=100.0, r_squared=0.999, identity_error=0.0, shift=0.1
    )
    check = forms_check(replace(found, **changes), by_instruments=by_instruments)  # type: ignore[arg-type]
    assert isinstance(check, Check)
    return check


def test_what_contradicts_its_own_rows_is_an_internal_fault() -> None:
    check = _judged(identity_error=1e-3, by_instruments=True)
    assert check.status == "fail"
    assert "internal fault" in check.meaning


def test_forms_far_apart_are_not_believed_and_lead_to_a_fit_of_the_open_loop() -> None:
    apart = {"inverse": 6.0, "direct": 100.0, "r_squared": 0.06, "shift": 50.0}
    assert _judged(by_instruments=False, **apart).status == "fail"
    assert (
        "without instruments nothing tells which" in _judged(by_instruments=False, **apart).meaning
    )
    failing = _judged(by_instruments=False, **apart)
    assert conclusion([failing]).startswith("Do not believe")
    assert "axisid fit --output open-loop" in failing.note.worded(as_options)
    assert _judged(by_instruments=True, **apart).status == "note"
    assert "fit(" not in str(_judged(by_instruments=True, **apart).note)
    assert _judged(by_instruments=False, shift=2.0).status == "note"
    assert _judged(by_instruments=False, **{**apart, "shift": 2.0}).status == "note"
    assert _judged(by_instruments=False).status == "pass"
