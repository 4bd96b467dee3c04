"""Twins of a drive with a lag and a delay: identified within their own intervals where declared."""

from typing import Any

import pytest

from axisid import Axis, Identification, build, identify, twin_record
from axisid.estimation.records import Record
from tests.axes.lagging import TRUTH, lagging, noisy

CASES = [
    {"lag": 1e-3},
    {"delay": 3.5e-4},
    {"lag": 8e-4, "delay": 1.35e-3, "logged": "applied"},
    {"lag": 8e-4, "delay": 3.5e-4, "logged": "current"},
]
PATH = {"rate_limit": 300.0, "quantisation": 0.05, "deadband": 0.3}
MOST_ERROR = 1e-5  # of the corrected values
MOST_BIAS = 9e-4  # of a filter beside reversals


def _identified(axis: Axis, record: Record | None = None) -> Identification:
    made = build(axis)
    record = twin_record(made) if record is None else record
    return identify(made, record, methods=["idm-ls", "idm-iv", "didim"])


@pytest.mark.slow
@pytest.mark.parametrize("timing", CASES)
def test_declared_lag_and_delay_leave_no_error(timing: dict[str, float]) -> None:
    result = _identified(lagging(**timing))
    for estimate in result.estimates.values():
        for name, true in TRUTH.items():
            value = estimate.parameters[name]
            assert abs(value.corrected / true - 1) < MOST_ERROR
            assert abs(value.value / true - 1) < MOST_BIAS
    checks = {check.name: check for check in result.verdict}
    for name in ("control law", "alignment", "simulation", "method"):
        assert checks[name].status in ("pass", "note"), checks[name]
    assert checks["control law"].figure < 1e-6
    assert result.preferred.simulation_error_percent < 0.1


@pytest.mark.slow
def test_undeclared_lag_moves_friction_and_is_seen_in_the_alignment() -> None:
    record = twin_record(build(lagging(lag=1e-3)))
    result = _identified(lagging(), record)
    assert abs(result.estimates["idm-iv"].parameters["Fc"].corrected / TRUTH["Fc"] - 1) > 5e-3
    (alignment,) = (check for check in result.verdict if check.name == "alignment")
    assert alignment.status == "fail"
    assert 0.8 < alignment.figure < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("timing", CASES)
def test_with_noise_instruments_are_within_their_deviations(timing: dict[str, float]) -> None:
    result = _identified(noisy(lagging(**timing), 1e-6, seed=7))
    for name, true in TRUTH.items():
        value = result.estimates["idm-iv"].parameters[name]
        assert abs(value.corrected - true) < 2.5 * value.deviation


@pytest.mark.slow
@pytest.mark.parametrize("timing", [{}, {"lag": 8e-4, "delay": 3.5e-4, "logged": "current"}])
def test_a_declared_path_leaves_parameters_within_their_deviations(timing: dict[str, Any]) -> None:
    axis = build(noisy(lagging(**PATH, **timing), 1e-6, seed=7))
    result = identify(axis, twin_record(axis), methods=["idm-iv"])
    for name, true in TRUTH.items():
        value = result.preferred.parameters[name]
        assert abs(value.corrected - true) < 2.5 * value.deviation
    checks = {check.name: check for check in result.verdict}
    assert all(check.status != "fail" for check in checks.values())
    assert checks["control law"].figure < 1e-6


@pytest.mark.slow
def test_an_undeclared_dead_band_is_taken_for_friction_and_named_with_its_width() -> None:
    record = twin_record(build(noisy(lagging(deadband=0.05), 1e-6)))
    result = _identified(lagging(), record)
    assert result.estimates["idm-iv"].parameters["Fc"].corrected > 1.05 * TRUTH["Fc"]
    (failing,) = (check for check in result.verdict if check.status == "fail")
    assert failing.name == "missing terms"
    assert "Drive(deadband=0.05" in failing.meaning
