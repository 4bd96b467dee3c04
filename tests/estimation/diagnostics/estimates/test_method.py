"""What another estimate, noise and steps say of the judged one, as one check."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, Prefilter, Record, build, identify, read_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.control import cascade_pd, cascade_pd_difference
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import belief
from axisid.estimation.diagnostics.estimates import (
    FORMS,
    SECOND_OPINION,
    forms_check,
    method_check,
)
from axisid.estimation.estimates import Estimate, HausmanTest
from axisid.support.errors import Missing
from benchmarks.machines import Machine, records, white

BOTH = ("idm-iv", "didim")
NO_STEPS = Missing("no steps")
STAGE = Machine(mass=100.2, viscous=236.9, coulomb=24.8, control_noise=white(2e-3))


@pytest.fixture(scope="module")
def every(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin)


@pytest.fixture(scope="module")
def both(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, methods=BOTH)


def found(
    difference: float, *, p: float = 1e-6, joint: float = 1e-6, shift: float = 3.0
) -> dict[str, HausmanTest]:
    quiet = HausmanTest(difference=0.0, deviation=0.1, p_value=0.5, joint_p_value=joint, shift=0.1)
    moved = replace(quiet, difference=difference, p_value=p, shift=shift)
    return {"M": quiet, "Fv": moved, "Fc": quiet}


def judged(
    result: Identification,
    differences: dict[str, HausmanTest],
    *,
    pair: str = SECOND_OPINION,
    method: str = "didim",
    law: bool | None = True,
) -> Check:
    return method_check(
        result[method], result.estimates, {pair: differences}, NO_STEPS, law_passed=law
    )


def widened(result: Identification, *methods: str) -> Identification:
    """With deviations of some estimates that are twenty times as large."""
    wide = {
        m: result[m].with_inference(
            covariances={name: 400 * matrix for name, matrix in result[m].covariances.items()}
        )
        for m in methods
    }
    return replace(result, estimates={**result.estimates, **wide})


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (True, "the control is the declared law's, so believe didim"),
        (False, "is not the declared one, on which didim rests, so believe the instruments"),
        (None, "could not be checked, on which didim rests, so believe the instruments"),
    ],
)
def test_it_says_which_of_the_two_to_believe(
    both: Identification, law: bool | None, said: str
) -> None:
    check = judged(both, found(12.0), law=law)
    assert check.status == "fail"
    assert check.figure == 3.0
    assert said in check.meaning
    assert "Fv by +12 N/(m/s) (+5.1 %, 3 deviations)" in check.meaning
    assert "M by" not in check.meaning


def test_it_fails_where_it_is_significant_and_matters(both: Identification) -> None:
    assert judged(both, found(12.0, joint=0.02)).status == "pass"
    assert judged(both, found(12.0, shift=0.4)).status == "pass"
    assert judged(both, found(1.2)).status == "note"
    assert judged(widened(both, "idm-iv"), found(12.0)).status == "note"
    assert judged(both, found(1.2, p=0.2)).p_value == 1e-6, "together, if not alone"


def test_forms_far_apart_fail_where_no_instruments_tell(every: Identification) -> None:
    far, near, same = (
        forms_check({FORMS: each}, every.estimates)
        for each in (found(12.0), found(1.2), found(12.0, shift=0.4))
    )
    assert (far.status, near.status, same.status) == ("fail", "note", "pass")
    assert "nothing tells which" in far.meaning
    assert "axisid fit with output=" in far.meaning
    assert belief([far.name]) == "not believed"


def biased(ls: Estimate, deviations: float) -> Mapping[str, Estimate]:
    bias = deviations * np.sqrt(np.diag(ls.covariance))
    return {"idm-ls": ls.with_inference(bias=bias)}


@pytest.mark.parametrize(("deviations", "status"), [(0.2, "pass"), (-3.0, "note")])
def test_least_squares_alone_is_held_against_its_twins(
    every: Identification, deviations: float, status: str
) -> None:
    estimates = biased(every["idm-ls"], deviations)
    check = method_check(estimates["idm-ls"], estimates, {}, NO_STEPS, law_passed=True)
    assert check.status == status
    assert ("(idm-iv)" in check.meaning) is (status == "note")


@pytest.mark.slow
def test_least_squares_alone_has_the_noise_of_its_twins(emps2015: GeneratedAxis) -> None:
    noisy = replace(STAGE, has_tachometer=True, position_noise=white(5e-6))
    (columns,) = records(noisy, _reference(), 1, 5)
    result = identify(emps2015, read_record(columns, emps2015), methods="idm-ls")
    mass = result["idm-ls"].parameters["M"]
    assert mass.value < 99.5
    assert mass.interval[0] < 100.2 < mass.interval[1]
    check = _checks(result)["method"]
    assert check.status == "note"
    assert "M by about -" in check.meaning


@pytest.fixture(scope="module")
def machine() -> Machine:
    return Machine(
        mass=100.2,
        viscous=236.9,
        coulomb=24.8,
        has_tachometer=True,
        position_noise=white(3.8e-6),
    )


def opinion(axis: GeneratedAxis, record: Record, prefilter: Prefilter | None = None) -> Check:
    checks = identify(axis, record, prefilter, BOTH).verdict
    (check,) = (each for each in checks if each.name == "method")
    return check


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "believed"),
    [
        ({"control": cascade_pd(kp=1.05 * 160.18, kv=243.45, period=1e-3)}, "instruments"),
        ({"delay": 1}, "instruments"),
    ],
)
def test_a_wrong_law_parts_the_two(
    emps2015: GeneratedAxis, twin: Record, machine: Machine, changed: dict, believed: str
) -> None:
    law = changed.get("control") or replace(emps2015.axis.control, **changed)  # type: ignore[type-var]
    wrong = build(replace(emps2015.axis, control=law))
    for columns in records(machine, twin.reference, 2, seed=3):
        check = opinion(wrong, read_record(columns, wrong))
        assert check.status in ("note", "fail")
        assert f"so believe the {believed}" in check.meaning


@pytest.mark.slow
def test_the_verdict_is_of_didim_where_the_law_passes_and_of_instruments_elsewhere(
    emps2015: GeneratedAxis, both: Identification
) -> None:
    assert both.preferred.method == both.diagnosis.preferred == "didim"
    assert [part.preferred.method for part in both.parts] == ["didim"]
    law = cascade_pd(kp=1.05 * 160.18, kv=243.45, period=1e-3)
    wrong = build(replace(emps2015.axis, control=law))
    other = identify(wrong, both.record, methods=BOTH)
    assert other.preferred.method == other.diagnosis.preferred == "idm-iv"
    together = identify(wrong, [both.record, both.record], methods=BOTH)
    assert together.diagnosis.preferred == "idm-iv"
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
    position, control = columns["position"], np.roll(columns["control"], late)
    if step:
        position = step * np.round(position / step)
    return identify(
        axis,
        read_record({"time": columns["time"], "position": position, "control": control}, axis),
    )


def _checks(result: Identification) -> dict[str, Check]:
    return {check.name: check for check in result.verdict}


def _failed(result: Identification) -> list[str]:
    return [check.name for check in result.verdict if check.status == "fail"]


@pytest.mark.slow
def test_steps_that_the_log_alone_has_are_named_with_what_they_move(
    stage: GeneratedAxis,
) -> None:
    result = _without_reference(stage, STAGE, step=0.045 / 2**10)
    mass = result["idm-ls"].parameters["M"]
    assert mass.value < 0.99 * 100.2
    assert {*_failed(result)} == {"method", "inverse against direct"}  # which the steps part
    check = _checks(result)["method"]
    told = float(check.meaning.split("M by about ")[1].split()[0])
    assert told == pytest.approx(mass.value - 100.2, rel=0.35)


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.0, 1e-8])
def test_fine_positions_are_no_fault(stage: GeneratedAxis, step: float) -> None:
    result = _without_reference(stage, STAGE, step=step)
    assert "method" not in _failed(result)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1e-6, 5e-6])
def test_noise_that_is_reckoned_with_is_no_fault_of_timing_or_model(
    stage: GeneratedAxis, noise: float
) -> None:
    result = _without_reference(stage, replace(STAGE, position_noise=white(noise)))
    assert _failed(result) == []
    mass = result["idm-ls"].parameters["M"]
    assert abs(mass.corrected - 100.2) < 0.006 * 100.2
    assert not _checks(result)["alignment"].meaning.endswith("which noise may bias)")


@pytest.mark.slow
def test_a_control_that_is_logged_late_is_told_all_the_same(stage: GeneratedAxis) -> None:
    late = _without_reference(stage, replace(STAGE, position_noise=white(5e-6)), late=2)
    assert {"alignment", "missing terms"} & {*_failed(late)}
