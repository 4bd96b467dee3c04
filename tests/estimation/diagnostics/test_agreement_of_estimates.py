"""Comparison of the reported estimate with other estimates, noise and encoder steps."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Record,
    build,
    read_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.estimation.diagnostics import (
    DDM_LESS_IDM,
    SECOND_OPINION,
    HausmanTest,
    forms_check,
    method_check,
)
from axisid.estimation.diagnostics.agreement_findings import (
    AgreementOfEstimates,
    DirectAgainstInverse,
    InstrumentsAgainstOutputError,
    NoiseBias,
    QuantisationBias,
)
from axisid.estimation.diagnostics.alignment_findings import ForceDelay
from axisid.estimation.estimates import Estimate
from axisid.estimation.verdict_checks import Check
from benchmarks.machines import Machine, records, white
from tests.unjudged import identify
from tests.verdicts import Kind, checks_of, finding_of

BOTH = ("idm-iv", "didim")
NO_STEPS: dict[str, float] = {}
STAGE = Machine(mass=100.2, viscous=236.9, coulomb=24.8, control_noise=white(2e-3))


@pytest.fixture(scope="module")
def both(result: Identification) -> Identification:
    return replace(result, estimates={name: result[name] for name in BOTH})


def found(
    difference: float, *, p: float = 1e-6, joint: float = 1e-6, shift: float = 3.0
) -> dict[str, HausmanTest]:
    quiet = HausmanTest(difference=0.0, deviation=0.1, p_value=0.5, joint_p_value=joint, shift=0.1)
    moved = replace(quiet, difference=difference, p_value=p, shift=shift)
    return {"M": quiet, "Fv": moved, "Fc": quiet}


def judged(
    estimates: Mapping[str, Estimate],
    differences: dict[str, HausmanTest],
    law: bool | None = True,
) -> Check:
    compared = {SECOND_OPINION: differences}
    return method_check(estimates["didim"], estimates, compared, NO_STEPS, law_passed=law)


def first_finding(check: Check | None, kind: type[Kind]) -> Kind:
    """The first of the findings on the method, which is of a kind."""
    first = finding_of(check, AgreementOfEstimates).findings[0]
    assert isinstance(first, kind), first
    return first


@pytest.mark.parametrize(
    ("law", "reported"), [(True, "didim"), (False, "idm-iv"), (None, "idm-iv")]
)
def test_the_law_decides_which_of_the_two_is_reported(
    both: Identification, law: bool | None, reported: str
) -> None:
    check = judged(both.estimates, found(12.0), law)
    assert check.status == "fail"
    assert check.figure == 3.0
    finding = first_finding(check, InstrumentsAgainstOutputError)
    assert (finding.reported, finding.law_passed, finding.less_precise) == (reported, law, ())
    (difference,) = finding.comparison.differences
    assert (difference.name, difference.difference, difference.unit) == ("Fv", 12.0, "N/(m/s)")
    assert difference.percent == pytest.approx(5.1, abs=0.1)
    assert difference.standard_errors == 3.0


def test_instruments_are_reported_where_didim_is_less_precise(both: Identification) -> None:
    didim = both["didim"]
    wide = {name: 400 * matrix for name, matrix in didim.covariances.items()}
    vague = {**both.estimates, "didim": didim.with_inference(covariances=wide)}
    finding = first_finding(judged(vague, found(12.0)), InstrumentsAgainstOutputError)
    assert (finding.reported, finding.less_precise) == ("idm-iv", ("Fv",))


def test_of_estimates_that_agree_the_largest_difference_is_kept(both: Identification) -> None:
    check = judged(both.estimates, found(12.0, shift=0.4))
    comparison = first_finding(check, InstrumentsAgainstOutputError).comparison
    assert comparison.differences == ()
    assert (comparison.largest.name, comparison.largest.standard_errors) == ("Fv", check.figure)
    assert finding_of(check, AgreementOfEstimates).all_pass


def test_it_fails_where_it_is_significant_and_matters(both: Identification) -> None:
    iv = both["idm-iv"]
    wide = {name: 400 * matrix for name, matrix in iv.covariances.items()}
    vague = {**both.estimates, "idm-iv": iv.with_inference(covariances=wide)}
    for estimates, differences, status in (
        (both.estimates, found(12.0, joint=0.02), "pass"),
        (both.estimates, found(12.0, shift=0.4), "pass"),
        (both.estimates, found(1.2), "note"),
        (vague, found(12.0), "note"),
    ):
        assert judged(estimates, differences).status == status
    assert judged(both.estimates, found(1.2, p=0.2)).p_value == 1e-6, "together, if not alone"


def test_forms_far_apart_fail_where_no_instruments_tell(result: Identification) -> None:
    far, near, same = (
        forms_check({DDM_LESS_IDM: each}, result.estimates)
        for each in (found(12.0), found(1.2), found(12.0, shift=0.4))
    )
    assert (far.status, near.status, same.status) == ("fail", "note", "pass")
    large = [
        finding_of(each, DirectAgainstInverse).comparison.is_large for each in (far, near, same)
    ]
    assert large == [True, False, False]


@pytest.mark.parametrize(("deviations", "status"), [(0.2, "pass"), (-3.0, "note")])
def test_least_squares_alone_is_held_against_its_twins(
    result: Identification, deviations: float, status: str
) -> None:
    ls = result["idm-ls"]
    ls = ls.with_inference(bias=deviations * np.sqrt(np.diag(ls.covariance)))
    check = method_check(ls, {"idm-ls": ls}, {}, NO_STEPS, law_passed=True)
    assert check.status == status
    finding = first_finding(check, NoiseBias)
    assert finding.instruments == "idm-iv"
    assert finding.largest == check.figure == pytest.approx(abs(deviations))
    assert {each.name for each in finding.biases} == (
        {*ls.parameters} if abs(deviations) > 1 else set()
    )


@pytest.mark.slow
def test_least_squares_alone_has_the_noise_of_its_twins(emps2015: GeneratedAxis) -> None:
    noisy = replace(STAGE, has_tachometer=True, position_noise=white(5e-6))
    (columns,) = records(noisy, _reference(), 1, 5)
    result = identify(emps2015, read_record(columns, emps2015), methods="idm-ls")
    mass, check = result["idm-ls"].parameters["M"], checks_of(result)["method"]
    assert mass.value < 99.5
    assert mass.interval[0] < 100.2 < mass.interval[1]
    assert check.status == "note"
    biases = {each.name: each.bias for each in first_finding(check, NoiseBias).biases}
    assert biases["M"] < 0


@pytest.mark.slow
@pytest.mark.parametrize("changed", [{"gains": {"kp": 1.05 * 160.18, "kv": 243.45}}, {"delay": 1}])
def test_a_wrong_law_parts_the_two(emps2015: GeneratedAxis, twin: Record, changed: dict) -> None:
    machine = replace(
        STAGE, has_tachometer=True, position_noise=white(3.8e-6), control_noise=white(0.0)
    )
    wrong = build(replace(emps2015.axis, control=replace(emps2015.axis.control, **changed)))
    for columns in records(machine, twin.reference, 2, seed=3):
        check = checks_of(identify(wrong, read_record(columns, wrong), methods=BOTH))["method"]
        assert check.status in ("note", "fail")
        finding = first_finding(check, InstrumentsAgainstOutputError)
        assert (finding.reported, finding.law_passed) == ("idm-iv", False)


@pytest.mark.slow
def test_the_verdict_is_of_didim_where_the_law_passes_and_of_instruments_elsewhere(
    emps2015: GeneratedAxis, both: Identification
) -> None:
    assert both.preferred.method == both.diagnosis.preferred == "didim"
    assert [part.preferred.method for part in both.parts] == ["didim"]
    wrong = emps2015.with_gains({"kp": 1.05 * 160.18})
    other = identify(wrong, both.record, methods=BOTH)
    assert other.preferred.method == other.diagnosis.preferred == "idm-iv"
    assert identify(wrong, both.record, methods="didim").preferred.method == "didim"


@pytest.fixture(scope="module")
def stage(emps2015: GeneratedAxis) -> GeneratedAxis:
    law = cascade_pd_difference(kp=STAGE.kp, kv=STAGE.kv, period=STAGE.period)
    return build(replace(emps2015.axis, control=law))


def _reference() -> np.ndarray:
    time = 1e-3 * np.arange(8000)
    waves = 0.02 * np.sin(2 * np.pi * 0.5 * time) + 0.004 * np.sin(2 * np.pi * 1.9 * time)
    return np.minimum(1.0, time / 0.5) * waves


def _without_reference(
    axis: GeneratedAxis, machine: Machine, step: float = 0.0, late: int = 0, seed: int = 5
) -> Identification:
    (columns,) = records(machine, _reference(), 1, seed)
    position = step * np.round(columns["position"] / step) if step else columns["position"]
    control = np.roll(columns["control"], late)
    given = {"time": columns["time"], "position": position, "control": control}
    return identify(axis, read_record(given, axis))


@pytest.mark.slow
def test_steps_that_the_log_alone_has_are_named_with_what_they_move(
    stage: GeneratedAxis,
) -> None:
    result = _without_reference(stage, STAGE, step=0.045 / 2**10)
    mass, checks = result["idm-ls"].parameters["M"], checks_of(result)
    assert mass.value < 0.99 * 100.2
    failed = {name for name, check in checks.items() if check.status == "fail"}
    assert failed == {"method", "inverse against direct"}  # which the steps part
    found = first_finding(checks["method"], QuantisationBias)
    biases = {each.name: each.bias for each in found.biases}
    assert biases["M"] == pytest.approx(mass.value - 100.2, rel=0.35)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("noise", "step", "late"),
    [(0.0, 0.0, 0), (0.0, 1e-8, 0), (1e-6, 0.0, 0), (5e-6, 0.0, 0), (5e-6, 0.0, 2)],
)
def test_fine_positions_and_noise_that_is_reckoned_with_are_no_fault_and_a_late_control_is(
    stage: GeneratedAxis, noise: float, step: float, late: int
) -> None:
    noisy = replace(STAGE, position_noise=white(noise))
    result = _without_reference(stage, noisy, step=step, late=late)
    failed = {name for name, check in checks_of(result).items() if check.status == "fail"}
    assert bool({"alignment", "missing terms"} & failed) is bool(late)
    mass = result["idm-ls"].parameters["M"]
    assert late or (not failed and abs(mass.corrected - 100.2) < 0.006 * 100.2)
    delay = checks_of(result)["alignment"].finding
    if noise and isinstance(delay, ForceDelay):
        assert delay.by_instruments or not delay.is_aligned
