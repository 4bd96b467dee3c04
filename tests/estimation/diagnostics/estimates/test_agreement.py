"""Estimates that agree and that do not: shifted by known parts of their deviations."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, Record, fix, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks.check import Check
from axisid.estimation.diagnostics.estimates.agreement import (
    fixed_check,
    ls_against_iv,
)
from axisid.estimation.diagnostics.estimates.instruments import NO_ENDOGENEITY, Endogeneity
from axisid.estimation.estimates import Estimate
from axisid.estimation.noise import NoiseBias
from axisid.support.missing import Missing

SURE = Endogeneity(statistic=9.0, p_value=1e-9, by_parameter=())
UNSURE = replace(SURE, p_value=0.5)


@pytest.fixture(scope="module")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin)


@pytest.fixture(scope="module")
def iv(result: Identification) -> Estimate:
    return result["idm-iv"]


def shifted(estimate: Estimate, deviations: float, parameter: int = 0) -> Estimate:
    """An estimate with one parameter moved by so many i.i.d. deviations."""
    physical = estimate.physical.copy()
    physical[parameter] += deviations * np.sqrt(estimate.covariances["iid"][parameter, parameter])
    return replace(estimate, physical=physical)


def widened(estimate: Estimate, relative: float) -> Estimate:
    """An estimate whose deviations are this part of its values."""
    covariance = np.diag((relative * estimate.physical) ** 2)
    return estimate.with_inference(covariances=dict.fromkeys(estimate.covariances, covariance))


@pytest.mark.parametrize("parameter", [0, 1, 2])
@pytest.mark.parametrize(("deviations", "status"), [(2.9, "pass"), (-2.9, "pass"), (3.1, "fail")])
def test_least_squares_may_differ_by_three_deviations_of_the_instruments(
    iv: Estimate, deviations: float, status: str, parameter: int
) -> None:
    wide = widened(iv, 0.01)
    check = ls_against_iv(
        shifted(wide, deviations, parameter), wide, UNSURE, weak=False, alone=True
    )
    assert check.status == status
    assert check.figure == pytest.approx(abs(deviations))
    assert check.threshold == 3.0
    name = list(iv.parameters)[parameter]
    assert (f"instruments, {name} by " in check.meaning) is (status == "fail")


def test_what_nobody_would_notice_is_no_failure_however_significant(iv: Estimate) -> None:
    close = widened(iv, 1e-4)
    check = ls_against_iv(shifted(close, 50.0), close, SURE, weak=False)
    assert check.status == "pass"
    bias = NoiseBias(difference=0.5, deviation=0.01, p_value=0.0, joint_p_value=0.0, shift=50.0)
    noted = ls_against_iv(shifted(close, 50.0), close, SURE, {"M": bias}, weak=False)
    assert noted.status == "note"
    assert (noted.figure, noted.threshold) == (50.0, 1.96)


def test_what_noise_does_to_least_squares_fails_where_that_is_judged_alone(iv: Estimate) -> None:
    off = shifted(widened(iv, 0.01), 20.0)
    bias = NoiseBias(difference=20.0, deviation=1.0, p_value=0.0, joint_p_value=0.0, shift=20.0)
    for alone, status in ((False, "note"), (True, "fail")):
        check = ls_against_iv(off, widened(iv, 0.01), SURE, {"M": bias}, weak=False, alone=alone)
        assert check.status == status
        assert "M by +20" in check.meaning


@pytest.mark.parametrize(
    ("percent", "tested", "status"),
    [
        (9.0, SURE, "pass"),
        (11.0, SURE, "fail"),
        (11.0, UNSURE, "pass"),
        (11.0, NO_ENDOGENEITY, "pass"),
    ],
)
def test_a_bias_of_a_tenth_counts_within_three_deviations_if_the_test_rejects(
    iv: Estimate, percent: float, tested: Endogeneity | Missing, status: str
) -> None:
    wide = widened(iv, 0.1)
    check = ls_against_iv(shifted(wide, percent / 10), wide, tested, weak=False, alone=True)
    assert check.status == status
    if status == "fail":
        assert check.figure == pytest.approx(percent, rel=1e-3)  # of the corrected value
        assert check.threshold == pytest.approx(10.0)


def test_nothing_is_compared_without_both_estimates_or_with_weak_instruments(iv: Estimate) -> None:
    for ls, other, weak in ((None, iv, False), (iv, None, False), (iv, iv, True)):
        assert isinstance(ls_against_iv(ls, other, SURE, weak=weak), Missing)


@pytest.mark.parametrize(("deviations", "status"), [(1.0, "pass"), (4.0, "fail")])
def test_a_value_that_is_fixed_may_be_off_by_what_the_record_leaves_open(
    emps2015: GeneratedAxis, twin: Record, iv: Estimate, deviations: float, status: str
) -> None:
    """At 1 %, one degree of freedom allows 2.6 deviations."""
    mass = iv.parameters["M"]
    value = mass.corrected + deviations * mass.sd_hac
    result = identify(fix(emps2015.axis, M=value), twin, methods="idm-iv")
    check = fixed_check(result["idm-iv"])
    assert isinstance(check, Check)
    assert check.status == status
    assert check.p_value is not None
    assert (check.p_value < 0.01) is (status == "fail")
    assert (f"M is fixed at {value:.4g}"[:16] in check.meaning) is (status == "fail")


def test_nothing_is_asked_where_nothing_was_fixed(iv: Estimate) -> None:
    assert fixed_check(iv) is None
