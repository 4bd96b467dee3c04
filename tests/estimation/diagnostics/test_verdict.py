"""The verdict on the paper's twin, the real record and on results that lack something."""

import re
from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Parameter,
    Prefilter,
    Record,
    identify,
    leave_out,
    load_axis,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.elements import stribeck
from axisid.paper.study import APPROPRIATE, INAPPROPRIATE


def statuses(result: Identification) -> dict[str, str]:
    return {check.name: check.status for check in result.verdict}


@pytest.mark.slow
def test_bias_of_least_squares_is_found_under_the_inappropriate_filter_only(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    fine, coarse = (identify(emps2015, twin, f, bootstrap=0) for f in (APPROPRIATE, INAPPROPRIATE))
    assert statuses(coarse)["method"] != "pass"
    moved = [r.diagnosis.differences["idm-ls less idm-iv"]["M"] for r in (fine, coarse)]
    assert abs(moved[0].difference) < 0.5
    assert moved[1].difference == pytest.approx(-46, abs=1)
    assert moved[1].shift > 20
    for result in (fine, coarse):
        for name in ("control law", "instrument strength", "simulation"):
            assert statuses(result)[name] == "pass", name


@pytest.mark.slow
def test_real_record_passes_but_for_its_residuals_and_what_raw_pairing_does(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    four = ["idm-ls", "ddm-ls", "idm-iv", "ddm-iv"]
    raw = statuses(
        identify(emps, emps_record, Prefilter(drop=(49, 0), hold="raw", reversals="keep"), four)
    )
    assert {name for name, status in raw.items() if status != "pass"} == {
        "missing terms",
        "lack of fit",
    }
    held = statuses(identify(emps, emps_record, methods=four))
    assert {name for name, status in held.items() if status != "pass"} == {
        "missing terms",
        "lack of fit",
    }


@pytest.mark.slow
def test_real_record_has_another_viscous_friction_in_each_direction(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    """Published: 166.7 forward and 240.4 backward [Janot2019]_."""
    verdict = identify(emps, emps_record).verdict
    (check,) = (c for c in verdict if c.name == "missing terms")
    assert check.status == "fail"
    assert check.meaning.startswith("viscous friction that differs with the direction, ")
    assert re.search(r"-7[1-9]\.\d \+- ", check.meaning)
    assert "declare asymmetric_viscous(" in check.meaning


@pytest.mark.slow
def test_what_was_not_run_is_not_evaluated(emps2015: GeneratedAxis, twin: Record) -> None:
    only = statuses(identify(emps2015, twin, methods="idm-ls"))
    assert "instrument strength" not in only
    assert only["method"] == "note", "noise moves it, which its twins take off"
    without = statuses(identify(emps2015, replace(twin, reference=None)))
    assert without["control law"] == "not evaluated"
    assert without["simulation"] == "not evaluated"


@pytest.mark.slow
def test_a_peak_of_friction_that_is_left_out_with_the_reversals_moves_nothing() -> None:
    """No row that counts shows it, so that there is nothing to tell; with the reversals it is."""
    axis = load_axis("emps2015")
    peak = Parameter("Fs", "N", nominal=10.0)
    truth = {**axis.experiment.truth, "Fs": 10.0}
    real = replace(
        axis,
        parameters=(*axis.parameters, peak),
        force=axis.force + stribeck(peak, axis.coordinate, velocity=0.01),
        experiment=replace(axis.experiment, truth=truth),
    )
    left_out, kept = (
        identify(leave_out(real, "Fs"), twin_record(real), Prefilter(reversals=each), ["idm-iv"])
        for each in ("leave-out", "keep")
    )
    for name, value in left_out.preferred.parameters.items():
        assert value.interval[0] < truth[name] < value.interval[1]
    assert "fail" not in statuses(left_out).values()
    (named,) = (c for c in kept.verdict if c.name == "missing terms")
    assert "stribeck(" in named.meaning


@pytest.mark.parametrize("name", ["emps", "emps2015"])
def test_lags_stay_a_small_part_of_the_rows(name: str) -> None:
    """Where neighbours cancel, the plug-in rule alone would take half of them."""
    axis = load_axis(name)
    for estimate in identify(axis, twin_record(axis)).estimates.values():
        lags = int(estimate.covariance_names["hac"].split(" lags")[0].split()[-1])
        assert lags <= len(estimate.y) ** 0.5


@pytest.mark.slow
def test_weak_instruments_do_not_judge_least_squares(
    emps2015: GeneratedAxis, twin: Record, rng: np.random.Generator
) -> None:
    """Noise in the position far above what the instruments can explain at this cut-off."""
    noisy = replace(twin, position=twin.position + rng.normal(0.0, 5e-5, len(twin)))
    result = identify(emps2015, noisy, Prefilter(cutoff=400.0, decimate=2), ["idm-ls", "idm-iv"])
    found = statuses(result)
    assert found["instrument strength"] == "fail"
    assert found["method"] == "not evaluated"
    assert found["alignment"] == "not evaluated"
