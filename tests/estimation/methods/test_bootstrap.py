"""Bias and deviations by twins hold where single loops cannot tell them."""

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from axisid import Record, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.support.errors import UsageError
from benchmarks.machines import Machine, white

field: Any = import_module("field")


def errors(case: Any, count: int, method: str, bootstrap: int) -> np.ndarray[Any, Any]:
    """Of corrected values, in their deviations, (records, parameters)."""
    found = []
    for record in case.records(count, 11):
        values = identify(case.axis, record, methods=method, bootstrap=bootstrap)[method]
        of = [(values[name], truth) for name, truth in case.truth.items()]
        found.append([(v.corrected - truth) / v.deviation for v, truth in of])
    return np.array(found)


@pytest.mark.slow
def test_sampling_that_jitters_is_known_and_taken_off() -> None:
    case = field.FIXED["PD, sampled with jitter of 5 %"]
    assert np.abs(errors(case, 3, "idm-iv", 0)).max() > 8
    assert np.abs(errors(case, 3, "idm-iv", 32)).max() < 4


@pytest.mark.slow
def test_least_squares_of_a_noisy_position_is_corrected() -> None:
    machine = Machine(position_noise=white(5e-6))
    case = field.Case(machine=machine, declared=machine)
    assert np.abs(errors(case, 4, "idm-ls", 0).mean(axis=0)).max() > 3
    assert np.abs(errors(case, 4, "idm-ls", 32).mean(axis=0)).max() < 2


@pytest.mark.slow
def test_a_right_estimate_keeps_its_values_and_nearly_its_deviations(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    plain = identify(emps2015, twin, methods=["idm-iv", "ddm-iv"])
    made = identify(emps2015, twin, methods=["idm-iv", "ddm-iv"], bootstrap=32)
    for method in ("idm-iv", "ddm-iv"):
        for name in emps2015.names:
            one, other = plain[method][name], made[method][name]
            assert other.value == one.value
            assert other.sd == one.sd
            assert other.sd_robust == one.sd_robust
            assert 0.5 < other.deviation / one.deviation < 2
            assert abs(other.corrected - one.corrected) < one.deviation
    (chain,) = made["idm-iv"].inference.chains
    assert chain.position == pytest.approx(3.8e-6, rel=0.05)
    assert plain["idm-iv"].inference.chains == ()


def test_a_record_without_a_loop_has_no_twins_and_says_why(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    record = replace(twin, reference=None)
    result = identify(emps2015, record, methods="idm-ls", bootstrap=8)["idm-ls"]
    assert result.inference.chains == ()
    assert "by no twins" in result.covariance_names["hac"]
    assert "reference" in result.covariance_names["hac"]


def test_a_record_without_noise_has_no_twins_and_says_so(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015, position_noise=0.0)
    result = identify(emps2015, record, methods="idm-iv", bootstrap=8)["idm-iv"]
    assert result.inference.chains == ()
    assert "by no twins" in result.covariance_names["hac"]


def test_known_values_and_lags_stay_as_they_are_given(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    def deviations(**settings: Any) -> np.ndarray[Any, Any]:
        result = identify(emps2015, [twin, twin], methods="idm-iv", **settings)["idm-iv"]
        return np.sqrt(np.diag(result.covariance))

    for settings in ({"known": {"Fc": [(24.8, 0.5)] * 2}}, {"lags": 5}):
        plain, made = deviations(**settings), deviations(**settings, bootstrap=32)
        assert np.all(np.abs(np.log(made / plain)) < np.log(2))


def test_what_is_measured_beside_the_position_has_no_twins(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    record = replace(twin, velocity=np.gradient(twin.position, twin.period))
    result = identify(emps2015, record, methods="idm-iv", bootstrap=8)["idm-iv"]
    assert "by no twins" in result.covariance_names["hac"]


@pytest.mark.parametrize("count", [-1, 3, 1.5, 10**6, "many", None, True])
def test_a_number_of_twins_that_is_none_is_refused(emps2015: GeneratedAxis, count: Any) -> None:
    with pytest.raises(UsageError, match="twins") as refused:
        identify(emps2015, twin_record(emps2015), methods="idm-ls", bootstrap=count)
    assert refused.value.code == "bootstrap-count"
