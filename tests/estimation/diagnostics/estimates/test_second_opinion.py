"""Instruments against DIDIM: when the two are one, and which of them to believe where not."""

import re
from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, Prefilter, Record, build, identify, read_record, simulate
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.control import cascade_pd
from axisid.estimation.checks import Check
from axisid.estimation.diagnostics.estimates import second_opinion_check
from axisid.estimation.noise import NoiseBias
from axisid.support.missing import Missing
from benchmarks.machines import Machine, records, white

BOTH = ("idm-iv", "didim")


@pytest.fixture(scope="module")
def both(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, methods=BOTH)


def found(
    difference: float, *, p: float = 1e-6, joint: float = 1e-6, shift: float = 3.0
) -> dict[str, NoiseBias]:
    quiet = NoiseBias(difference=0.0, deviation=0.1, p_value=0.5, joint_p_value=joint, shift=0.1)
    moved = replace(quiet, difference=difference, p_value=p, shift=shift)
    return {"M": quiet, "Fv": moved, "Fc": quiet}


def judged(both: Identification, biases: dict[str, NoiseBias], *, law: bool | None = True) -> Check:
    check = second_opinion_check(biases, both["idm-iv"], both["didim"], law_passed=law)
    assert isinstance(check, Check)
    return check


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
    assert said in check.meaning
    assert "Fv by +12 N/(m/s) (+5.1 %, 3 deviations)" in check.meaning
    assert "M by" not in check.meaning


def test_it_fails_where_it_is_significant_and_matters(both: Identification) -> None:
    assert judged(both, found(12.0, joint=0.02)).status == "pass"
    assert judged(both, found(12.0, shift=0.4)).status == "pass"
    assert judged(both, found(1.2)).status == "note"
    iv = both["idm-iv"]
    wide = {name: 400 * matrix for name, matrix in iv.covariances.items()}
    allowed = {**both.estimates, "idm-iv": iv.with_inference(covariances=wide)}
    assert judged(replace(both, estimates=allowed), found(12.0)).status == "note"
    assert judged(both, found(12.0)).figure == 3.0


def test_what_the_encoder_makes_vague_is_not_what_to_believe(both: Identification) -> None:
    didim = both["didim"]
    wide = {name: 400 * matrix for name, matrix in didim.covariances.items()}
    vague = {**both.estimates, "didim": didim.with_inference(covariances=wide)}
    check = judged(replace(both, estimates=vague), found(12.0))
    assert check.status == "note"
    assert re.search(
        r"didim is the vaguer in \w+(, \w+)*, so the verdict is of the instruments$", check.meaning
    )


def test_parameters_may_part_together_that_do_not_alone(both: Identification) -> None:
    check = judged(both, found(1.2, p=0.2))
    assert check.status == "note"
    assert check.p_value == 1e-6


def test_it_is_of_both_and_of_strong_instruments(both: Identification) -> None:
    iv, didim = both["idm-iv"], both["didim"]
    assert second_opinion_check(None, iv, didim, law_passed=True) is None
    assert second_opinion_check(found(1.0), iv, None, law_passed=True) is None
    weak = Missing("weak")
    assert second_opinion_check(weak, iv, didim, law_passed=True) is weak


def test_instruments_that_are_much_the_vaguer_are_told(both: Identification) -> None:
    iv, didim = both["idm-iv"], both["didim"]
    wide = {name: 400 * matrix for name, matrix in iv.covariances.items()}
    vague = replace(both, estimates={"idm-iv": iv.with_inference(covariances=wide), "didim": didim})
    alike = found(1.2, joint=0.5)
    check = judged(vague, alike)
    assert check.status == "note"
    assert re.search(r"idm-iv tells \w+ to [\d.]+ %, didim to 0\.\d* %", check.meaning)
    assert check.meaning.endswith("so take didim")
    for law in (False, None):
        assert judged(vague, alike, law=law).status == "pass"
    assert judged(both, alike).status == "pass"


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
    (check,) = (each for each in checks if each.name == "second opinion")
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
    assert twin.reference is not None
    for columns in records(machine, twin.reference, 2, seed=3):
        check = opinion(wrong, read_record(columns, wrong))
        assert check.status in ("note", "fail")
        assert check.meaning.endswith(f"so believe the {believed}")


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


@pytest.mark.slow
def test_a_coarse_encoder_under_a_filter_that_does_not_suit_parts_the_two(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """There DIDIM is right, and the law passes its check."""
    assert twin.reference is not None
    truth = [100.2, 236.9, 24.8]
    loop = simulate(emps2015, truth, twin.reference, 1e-3, resolution=2e-5)
    coarse = replace(twin, position=loop.measured_position, control=loop.control)
    unsuited = Prefilter(cutoff=180.0, decimate=3, drop=(50, 50), hold="raw", reversals="keep")
    result = identify(emps2015, coarse, unsuited, BOTH)
    (check,) = (each for each in result.verdict if each.name == "second opinion")
    assert check.status in ("note", "fail")
    assert check.meaning.endswith(("so take didim", "so believe didim"))
    assert np.abs(result["didim"].corrected / truth - 1).max() < 0.01
