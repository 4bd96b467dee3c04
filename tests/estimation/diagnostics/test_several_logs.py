"""Checks of several logs of a servo joint: none faults, and one that does costs no estimate."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from axisid import Record, build, fit, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.diagnose import DIAGNOSTICS, Diagnostic
from axisid.estimation.diagnostics.diagnosis import Case
from axisid.support.arrays import Array
from axisid.support.errors import Missing
from tests.axes.servo import TRUTH, servo, servo_log, servo_record


def _to_and_fro(time: Array) -> Array:
    return np.sin(time) * np.pi / 2 + 0.8 * np.sin(5 * time) * np.sin(2 * time)


def _faster_and_faster(time: Array) -> Array:
    return np.asarray(np.sin(time**2))


def _one_way(time: Array) -> Array:
    return 0.6 * time


@pytest.fixture(scope="module")
def joint() -> GeneratedAxis:
    return build(servo())


def _broken(_: Case) -> None:
    raise ValueError("matmul")


@pytest.mark.slow
def test_logs_of_other_lengths_whose_control_is_late_are_judged(
    joint: GeneratedAxis, tmp_path: Path
) -> None:
    """The delay of a control is told by the rows of its own record."""
    write = partial(servo_log, joint, late=1)
    files = [
        write(tmp_path / "a.json", _to_and_fro, 5.0),
        write(tmp_path / "b.json", _faster_and_faster, 4.0),
    ]
    records = [servo_record(joint, file) for file in files]
    result = identify(joint, records, methods=["idm-ls", "idm-iv"])
    law = next(check for check in result.verdict if check.name == "control law")
    assert law.status == "fail"
    assert "1 sample later" in law.meaning
    assert not [check for check in result.verdict if "fault" in check.meaning]


@pytest.mark.slow
def test_log_that_moves_one_way_alone_costs_no_estimate(tmp_path: Path) -> None:
    """In it friction is a constant force; the other one tells them apart."""
    joint = build(servo(with_offset=True))
    files = [
        servo_log(joint, tmp_path / "a.json", _to_and_fro, 5.0),
        servo_log(joint, tmp_path / "b.json", _one_way, 1.8),
    ]
    records = [servo_record(joint, file) for file in files]
    result = identify(joint, records, methods=["idm-ls", "idm-iv"])
    assert result.verdict
    assert all(part.verdict for part in result.parts)
    assert result["idm-iv"].parameters["mgl"].value == pytest.approx(TRUTH["mgl"], rel=0.02)
    assert isinstance(result.diagnosis.records[1].alignment, Missing)


@pytest.mark.slow
def test_log_with_fewer_rows_than_parameters_costs_no_estimate(
    joint: GeneratedAxis, tmp_path: Path
) -> None:
    """It rests nearly all along."""
    files = [
        servo_log(joint, tmp_path / "a.json", _to_and_fro, 5.0),
        servo_log(joint, tmp_path / "b.json", lambda t: 0.2 * np.minimum(t, 0.2), 1.0),
    ]
    result = identify(joint, [servo_record(joint, file) for file in files], methods="idm-ls")
    assert len(result.problem.data[1].row_numbers) < 4
    assert result.verdict
    assert "mgl" in result.summary(full=True)


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


def _broken_of_any(*_: object, **__: object) -> None:
    raise ValueError("matmul")


@pytest.mark.slow
def test_fit_keeps_its_estimates_beside_checks_that_fault(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("AXISID_DEBUG", raising=False)
    for place in ("result.find_misspecification", "result.move_by_record"):
        monkeypatch.setattr(f"axisid.estimation.fitting.{place}", _broken_of_any)
    result = fit(emps2015, twin)
    faulty = {check.name for check in result.checks if "by a fault" in check.meaning}
    assert {"missing terms", "law's factors"} <= faulty
    assert result["M"].value == pytest.approx(100.2, rel=1e-3)
    assert "by a fault" in result.summary()
