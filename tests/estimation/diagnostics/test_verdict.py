"""The verdict on right twins, the real record, plausible faults and results that lack something."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    compare,
    friction_ladder,
    identify,
    leave_out,
    load_axis,
    sweep,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.elements import stribeck
from axisid.estimation.studies.sweep import default_cutoffs
from axisid.modeling import LIBRARY
from axisid.paper.study import APPROPRIATE, INAPPROPRIATE
from tests.refusals import refuses


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
    raw = Prefilter(drop=(49, 0), hold="raw", reversals="keep")
    for prefilter in (raw, None):
        four = ["idm-ls", "ddm-ls", "idm-iv", "ddm-iv"]
        found = statuses(identify(emps, emps_record, prefilter, four))
        assert {name for name, status in found.items() if status != "pass"} == {
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
    assert without["control law"] == without["simulation"] == "not evaluated"


@pytest.mark.slow
def test_a_peak_of_friction_that_is_left_out_with_the_reversals_moves_nothing() -> None:
    """No row that counts shows it, so that there is nothing to tell; with the reversals it is."""
    axis, peak = load_axis("emps2015"), Parameter("Fs", "N", nominal=10.0)
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


@pytest.mark.slow
def test_weak_instruments_do_not_judge_least_squares(
    emps2015: GeneratedAxis, twin: Record, rng: np.random.Generator
) -> None:
    """Noise in the position far above what the instruments can explain at this cut-off."""
    noisy = replace(twin, position=twin.position + rng.normal(0.0, 5e-5, len(twin)))
    result = identify(emps2015, noisy, Prefilter(cutoff=400.0, decimate=2), ["idm-ls", "idm-iv"])
    found = statuses(result)
    assert found["instrument strength"] == "fail"
    assert found["method"] == found["alignment"] == "not evaluated"


RIGHT = 0.003  # percent
#: Where the twin has whole counts, and friction that a dead time delays.
RIGHT_OF = {"servo_joint": 0.02, "valve": 0.006}


def off(result: Identification) -> float:
    """Largest error of a parameter by any method, percent."""
    truth = result.record.provenance.truth
    return max(
        100 * abs(value.corrected / truth[name] - 1)
        for estimate in result.estimates.values()
        for name, value in estimate.parameters.items()
        if truth.get(name)
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "methods", "share"),
    [
        *((name, None, 0.01) for name in LIBRARY),
        *((name, None, 0.0) for name in ("emps2015", "crank", "servo_joint")),
        *((name, [only], 0.01) for name in ("emps", "valve") for only in ("idm-ls", "idm-iv")),
    ],
)
def test_nothing_fails_on_a_record_that_is_right(
    name: str, methods: Sequence[str] | None, share: float
) -> None:
    """Without noise, and with a hundredth of the twin's own."""
    axis = build(load_axis(name))
    record = twin_record(axis, position_noise=share * axis.axis.experiment.position_noise)
    result = identify(axis, record, methods=methods)
    assert off(result) < RIGHT_OF.get(name, RIGHT)
    assert not [check.name for check in result.verdict if check.status == "fail"]


def test_negative_mass_is_out_of_bounds(emps2015: GeneratedAxis, twin: Record) -> None:
    flipped = replace(twin, control=-twin.control, reference=None)
    verdict = identify(emps2015, flipped, methods=["idm-ls"]).verdict
    (check,) = (c for c in verdict if c.name == "bounds")
    assert check.status == "fail"
    assert "M = -" in check.meaning


@pytest.mark.slow
def test_comparison_and_sweep_pass_the_law_check_on(emps2015: GeneratedAxis, twin: Record) -> None:
    flipped = replace(twin, control=-twin.control)
    text = " ".join(compare(friction_ladder(load_axis("emps2015")), flipped).summary().split())
    assert "Believe nothing" in text
    assert "is outside its bounds [0, inf]" in text
    swept = sweep(emps2015, flipped, (40.0, 80.0), methods=["idm-ls"]).summary()
    assert "believe nothing before this is mended" in swept
    assert "believe nothing" not in sweep(emps2015, twin, (40.0,), methods=["idm-ls"]).summary()


def test_endless_twins_and_sweeps_and_lags_are_refused(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    law = emps2015.axis.control
    with refuses("twin", says="1e-09"):
        twin_record(replace(emps2015.axis, control=replace(law, period=1e-9)))
    with refuses("sweep", says="500"):
        default_cutoffs(1000.0, points=10**6)
    with refuses("result"):
        identify(emps2015, twin, methods="idm-ls", lags=500)
