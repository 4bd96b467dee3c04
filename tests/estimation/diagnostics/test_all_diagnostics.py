"""One sentence over all checks, and verdicts on right twins, real records and plausible faults."""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import (
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    compare,
    fit,
    friction_ladder,
    leave_out,
    load_axis,
    sweep,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.elements import stribeck
from axisid.estimation.diagnostics.all_diagnostics import DIAGNOSTICS, Diagnostic
from axisid.estimation.diagnostics.control_law import LateControl
from axisid.estimation.diagnostics.model_error_checks import MissingTerms
from axisid.estimation.diagnostics.parameter_findings import BeyondBounds
from axisid.estimation.findings import FaultOfCheck, Said
from axisid.estimation.misspecification import MissingTerm
from axisid.estimation.verdict_checks import Check, conclusion
from axisid.modeling import LIBRARY
from axisid.paper import APPROPRIATE, INAPPROPRIATE
from axisid.presentation.page import report_html
from axisid.presentation.sentences import conclusion_text
from axisid.presentation.text.identification import verdict_block
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from tests.axes.servo import TRUTH, servo, servo_log, servo_record
from tests.recipes import recipe_blocks
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of, statuses


@pytest.mark.slow
def test_one_file_and_one_row_add_a_diagnostic(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The recipe's goes through verdict, text, notebook, JSON and page."""
    module, row = recipe_blocks("Add a diagnostic")
    package = "axisid.estimation.diagnostics"
    names = {"__name__": f"{package}.turns", "__package__": package, "Diagnostic": Diagnostic}
    exec(module, names)
    monkeypatch.setitem(DIAGNOSTICS, "turns", eval(row, names))  # noqa: S307
    result = identify(emps2015, twin)
    concluded = conclusion(result.verdict)
    assert (concluded.belief, concluded.failed) == ("believed", ())
    assert conclusion_text(concluded) in result.summary()
    found = result.verdict[-1]
    assert (found.name, found.status) == ("turns", "pass")
    assert re.search(r"^turns +pass +18 +4 ", result.summary(full=True), re.MULTILINE)
    assert '<th class="text">turns</th>' in report_html(result)
    written = json.loads(json.dumps(result.to_dict()))
    assert [c["meaning"] for c in written["verdict"] if c["name"] == "turns"] == [found.meaning]


def _to_and_fro(time: Array) -> Array:
    return np.sin(time) * np.pi / 2 + 0.8 * np.sin(5 * time) * np.sin(2 * time)


@pytest.fixture(scope="module")
def joint() -> GeneratedAxis:
    return build(servo())


def _broken(*_: object, **__: object) -> None:
    raise ValueError("matmul")


@pytest.mark.slow
def test_logs_of_other_lengths_whose_control_is_late_are_judged(
    joint: GeneratedAxis, tmp_path: Path
) -> None:
    """The delay of a control is told by the rows of its own record."""
    records = [
        servo_record(joint, servo_log(joint, tmp_path / name, motion, seconds, late=1))
        for name, motion, seconds in (
            ("a.json", _to_and_fro, 5.0),
            ("b.json", lambda t: np.sin(t**2), 4.0),
        )
    ]
    result = identify(joint, records, methods=["idm-ls", "idm-iv"])
    late = finding_of(checks_of(result)["control law"], LateControl)
    assert late.samples == 1
    assert not [check for check in result.verdict if check.is_faulty]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "seconds"),
    [(lambda t: 0.6 * t, 1.8), (lambda t: 0.2 * np.minimum(t, 0.2), 1.0)],
    ids=["one way", "fewer rows than parameters"],
)
def test_log_that_does_not_tell_all_costs_no_estimate(
    tmp_path: Path, motion: Callable[[Array], Array], seconds: float
) -> None:
    """In it friction is a constant force, or it rests; the other one tells them apart."""
    joint = build(servo(with_offset=True))
    files = [
        servo_log(joint, tmp_path / "a.json", _to_and_fro, 5.0),
        servo_log(joint, tmp_path / "b.json", motion, seconds),
    ]
    records = [servo_record(joint, file) for file in files]
    result = identify(joint, records, methods=["idm-ls", "idm-iv"])
    assert all(part.verdict for part in (result, *result.parts))
    assert result["idm-iv"].parameters["mgl"].value == pytest.approx(TRUTH["mgl"], rel=0.02)
    assert isinstance(result.diagnosis.records[1].alignment, Missing)


@pytest.mark.slow
@pytest.mark.parametrize("by_record", [False, True])
def test_check_that_faults_is_told_and_the_estimates_stand(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch, by_record: bool
) -> None:
    monkeypatch.delenv("AXISID_DEBUG", raising=False)
    broken = Diagnostic(name="precision", check=_broken, by_record=by_record)
    monkeypatch.setitem(DIAGNOSTICS, "precision", broken)
    result = identify(emps2015, twin, methods="idm-ls")
    assert "ValueError: matmul" in finding_of(checks_of(result)["precision"], FaultOfCheck).reason
    assert "M" in result["idm-ls"].parameters


@pytest.mark.slow
def test_fit_keeps_its_estimates_beside_checks_that_fault(
    emps2015: GeneratedAxis, twin: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("AXISID_DEBUG", raising=False)
    for place in ("result.find_misspecification", "result.moves_by_explanation"):
        monkeypatch.setattr(f"axisid.estimation.output_error.{place}", _broken)
    result = fit(emps2015, twin)
    faulty = {check.name for check in result.checks if check.is_faulty}
    assert {"missing terms", "law's factors"} <= faulty
    assert result["M"].value == pytest.approx(100.2, rel=1e-3)
    assert "ValueError: matmul" in result.summary()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("prefilter", "moved", "within"), [(APPROPRIATE, 0, 0.5), (INAPPROPRIATE, -46, 1)]
)
def test_bias_of_least_squares_is_found_under_the_inappropriate_filter_only(
    emps2015: GeneratedAxis, twin: Record, prefilter: Prefilter, moved: float, within: float
) -> None:
    result = identify(emps2015, twin, prefilter, bootstrap=0)
    test, found = result.diagnosis.differences["idm-ls less idm-iv"]["M"], statuses(result)
    assert test.difference == pytest.approx(moved, abs=within)
    assert moved == 0 or (test.shift > 20 and found["method"] != "pass")
    for name in ("control law", "instrument strength", "simulation"):
        assert found[name] == "pass", name


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
    check = checks_of(identify(emps, emps_record))["missing terms"]
    assert check.status == "fail"
    first = finding_of(check, MissingTerms).found[0]
    assert isinstance(first, MissingTerm)
    assert (first.term.kind, first.unit) == ("direction", "N/(m/s)")
    assert first.size == pytest.approx(-75.5, abs=4.5)


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
    missing = finding_of(checks_of(kept)["missing terms"], MissingTerms).found
    assert "stribeck" in [each.term.kind for each in missing if isinstance(each, MissingTerm)]


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
    result = identify(emps2015, flipped, methods=["idm-ls"])
    found = finding_of(checks_of(result)["bounds"], BeyondBounds).parameters
    assert any(each.name == "M" and each.value < 0.0 for each in found)


@pytest.mark.slow
def test_comparison_and_sweep_pass_the_law_check_on(emps2015: GeneratedAxis, twin: Record) -> None:
    flipped = replace(twin, control=-twin.control)
    text = " ".join(compare(friction_ladder(load_axis("emps2015")), flipped).summary().split())
    assert "Do not use these results" in text
    assert "is outside its bounds [0, inf]" in text
    for record, cutoffs in ((flipped, (40.0, 80.0)), (twin, (40.0,))):
        swept = sweep(emps2015, record, cutoffs, methods=["idm-ls"]).summary()
        assert ("control does not follow the declared control law" in " ".join(swept.split())) is (
            record is flipped
        )


def test_endless_twins_and_lags_are_refused(emps2015: GeneratedAxis, twin: Record) -> None:
    law = emps2015.axis.control
    with refuses("twin", says="1e-09"):
        twin_record(replace(emps2015.axis, control=replace(law, period=1e-9)))
    with refuses("result"):
        identify(emps2015, twin, methods="idm-ls", lags=500)


def test_a_line_of_the_verdict_has_one_status() -> None:
    checks = [
        Check.unless("inverse against direct", "they differ"),
        Check(name="method", status="not evaluated", finding=Said(text="there is one method")),
        Check(name="control law", status="not evaluated", finding=Said(text="there is no law")),
    ]
    judged = verdict_block(checks).judged
    lines = [line for group in judged for line in group.names]
    assert sorted(lines) == ["law", "method"]
    assert "method" not in conclusion(checks).unchecked
