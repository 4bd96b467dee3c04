"""Frozen estimates, and frozen fits, on another record."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from axisid import (
    Prefilter,
    Record,
    build,
    fit,
    load_axis,
    load_result,
    simulate,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.commands.main import cli
from axisid.control import cascade_pd
from axisid.estimation import OutputFit, validate_fit
from axisid.estimation.diagnostics.control_law.law_findings import LawOfSecondRecord, OtherGains
from axisid.estimation.model_validation.validate import least_mean_square
from axisid.estimation.model_validation.validation_findings import (
    KnownSamples,
    ReestimatedParameters,
    SamplePeriods,
)
from axisid.estimation.model_validation.validation_result import Validation
from axisid.estimation.signals import RowTimes, SampledFilter
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of


@pytest.mark.slow
@pytest.mark.parametrize("hold", ["raw", "zoh"])
def test_on_its_own_record_an_estimate_has_its_own_errors(
    emps2015: GeneratedAxis, hold: str
) -> None:
    record = twin_record(emps2015)
    result = identify(emps2015, record, Prefilter(hold=hold))  # type: ignore[arg-type]
    for validation in validate(result, record):
        estimate = result[validation.method]
        names = ["simulation_error_percent"]
        if not estimate.by_output_error:  # whose rows are the loop's
            names.append("equation_error_percent")
        for name in names:
            assert getattr(validation, name) == pytest.approx(getattr(estimate, name), rel=1e-9)


def failing(validation: Validation) -> list[str]:
    """Names of the checks that fail."""
    return [check.name for check in validation.checks if check.status == "fail"]


@pytest.mark.slow
def test_position_figures_are_those_of_the_simulated_loop(emps2015: GeneratedAxis) -> None:
    result = identify(emps2015, twin_record(emps2015), methods=["idm-iv"])
    other = twin_record(emps2015, seed=7)
    found, own = (validate(result, record) for record in (other, result.record))
    (validation,) = found
    assert ({check.status for check in found.checks}, found.belief) == ({"pass"}, "believed")
    assert (failing(own), own.belief) == (["repeated records"], "with care")
    physical, first = result["idm-iv"].physical, float(other.position[0])
    loop = simulate(emps2015, physical, other.reference, other.period, start=first)
    start, end = SampledFilter(result.prefilter, other.period).dropped
    off = (other.position - loop.position)[start : len(other) - end]
    left = (other.reference - other.position)[start : len(other) - end]
    wanted = (np.sqrt(np.mean(off**2)), 100 * np.linalg.norm(off) / np.linalg.norm(left))
    errors = (validation.position_error_rms, validation.tracking_error_percent)
    assert errors == pytest.approx(wanted, rel=1e-9)


@pytest.mark.slow
def test_record_without_reference_has_an_equation_error_only(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015)
    result = identify(emps2015, record, methods=["idm-ls"])
    (validation,) = validate(result, replace(record, reference=None))
    assert validation.equation_error_percent > 0
    assert "no reference column" in str(validation.reason)


@pytest.mark.slow
def test_samples_that_the_estimates_were_made_from_are_told(emps2015: GeneratedAxis) -> None:
    whole = twin_record(emps2015)
    first, second = whole.windowed((None, 5)), whole.windowed((3, None))
    result = identify(emps2015, first, methods=["idm-ls"])
    held = validate(result, second)
    assert (held.known_share, held.same_record) == (pytest.approx(2.001 / 4.801), False)
    known = finding_of(checks_of(held)["repeated records"], KnownSamples)
    assert (known.percent, known.is_same_record) == (pytest.approx(200.1 / 4.801), False)
    assert known in held.notes
    assert validate(result, whole.windowed((1, 4))).same_record
    assert "repeated records" not in checks_of(validate(result, whole.windowed((5, None))))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mass", "kp", "fails"),
    [(1.1, 1.0, ["records alike"]), (1.0, 1.1, ["control law"])],
)
def test_what_is_a_tenth_off_does_not_hold_and_is_named(
    emps2015: GeneratedAxis, mass: float, kp: float, fails: list[str]
) -> None:
    result = identify(emps2015, twin_record(emps2015, position_noise=1e-7))
    own = load_axis("emps2015")
    truth = {**own.experiment.truth, "M": mass * own.experiment.truth["M"]}
    gains = {**own.control.gains, "kp": kp * own.control.gains["kp"]}
    changed = replace(
        own,
        experiment=replace(own.experiment, truth=truth),
        control=replace(own.control, gains=gains),
    )
    other = validate(result, twin_record(changed, position_noise=1e-7, seed=5))
    assert failing(other)[:1] == fails
    check = checks_of(other)[fails[0]]
    if mass != 1.0:
        changed_mass = finding_of(check, ReestimatedParameters).changed[0]
        assert (changed_mass.name, changed_mass.unit) == ("M", "kg")
        assert changed_mass.own == pytest.approx(110.2, abs=0.5)
    else:
        law = finding_of(check, LawOfSecondRecord).finding
        assert isinstance(law, OtherGains)
        times = {gain.name: gain.times for gain in law.alternatives[0]}
        assert times["kp"] == pytest.approx(1.1, abs=0.01)
    assert (other.holds, other.to_dict()["holds"]) == (False, False)
    assert (other.has_declared_law, other.belief) == (kp == 1.0, "not believed")


def test_short_records_are_not_blamed_for_slow_noise() -> None:
    """What a few slow waves leave may be less by chance than it is."""
    slow = np.sin(np.linspace(0.0, 7.0, 700))
    fast = np.random.default_rng(1).normal(size=700)
    assert least_mean_square(slow, RowTimes.consecutive(700)) < 0.6 * np.mean(slow**2)
    assert least_mean_square(fast, RowTimes.consecutive(700)) > 0.7 * np.mean(fast**2)


@pytest.mark.slow
def test_what_the_filter_leaves_open_suits_the_second_record(emps2015: GeneratedAxis) -> None:
    """A measured force is taken as it is, though the estimates' own force was held by the drive."""
    first, second = twin_record(emps2015), twin_record(emps2015, seed=3)
    measured = replace(second, force=35.15 * second.control, control=None)
    estimates = identify(emps2015, first, methods=["idm-ls"])
    assert estimates.prefilter.hold == "zoh"
    raw = identify(emps2015, first, Prefilter(hold="zoh"), ["idm-ls"])
    found, as_raw = (
        validate(each, measured)["idm-ls"].equation_error_percent
        for each in (estimates, replace(raw, requested=Prefilter(hold="raw")))
    )
    assert found == pytest.approx(as_raw, rel=1e-12)


@pytest.mark.slow
def test_a_failed_validation_is_a_line_of_the_verdict_and_of_the_file(
    emps2015: GeneratedAxis, twin: Record, tmp_path: Path
) -> None:
    file, out = tmp_path / "second.csv", tmp_path / "result.json"
    replace(twin, control=1.3 * twin.control).write(file, emps2015)
    arguments = ["identify", "emps2015", "--method", "idm-iv"]
    done = CliRunner().invoke(cli, [*arguments, "--validate", str(file), "--json", str(out)])
    assert re.search(r"^verdict +Use with care: ", done.output, re.MULTILINE)
    written, read = json.loads(out.read_text()), load_result(out)
    assert (written["belief"], written["validation"]["belief"]) == ("with care", "not believed")
    assert read.belief == "with care"
    assert [check.name for check in read.checks if check.status == "fail"] == ["validation"]


TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}


@pytest.fixture(scope="module")
def other(emps2015: GeneratedAxis) -> Record:
    return twin_record(emps2015, seed=7)


@pytest.fixture(scope="module")
def opened(emps2015: GeneratedAxis, twin: Record) -> OutputFit:
    return fit(emps2015, twin, "open-loop", start=TRUTH, horizon=1.0)


@pytest.mark.slow
def test_its_own_record_is_left_what_the_fit_left(opened: OutputFit, twin: Record) -> None:
    found = validate_fit(opened, twin)
    own = (opened.error, opened.error_percent)
    assert (found.error, found.percent) == pytest.approx(own, rel=1e-6)
    # What noise moved the parameters by is taken off them, and makes hardly any of the errors.
    np.testing.assert_allclose(found.errors, opened.errors[0], atol=2e-3 * opened.error)
    np.testing.assert_array_equal(found.samples, opened.predictions.samples[0])
    assert found.horizon == opened.horizon == 1.0
    assert found.windows[-1].stop == len(found.errors)


@pytest.mark.slow
def test_the_noise_is_all_that_right_parameters_leave_of_a_twin(
    emps2015: GeneratedAxis, twin: Record, opened: OutputFit, other: Record
) -> None:
    for horizon in (0.5, 3.0):
        held = validate_fit(opened, other, horizon=horizon)
        assert (held.horizon, held.error) == (horizon, pytest.approx(3.8e-6, rel=0.05))
    assert held.believed
    wrong = fit(emps2015, twin, "open-loop", start=TRUTH, horizon=1.0, fixed={"Fc": 25.8})
    assert validate_fit(wrong, other).error > 5 * held.error


@pytest.mark.slow
def test_a_loop_is_simulated_along_the_whole_record(
    emps2015: GeneratedAxis, twin: Record, other: Record
) -> None:
    followed = fit(emps2015, twin, "control", start=TRUTH, rests="keep")
    assert validate_fit(followed, twin).error == pytest.approx(followed.error, rel=1e-6)
    found = validate_fit(followed, other)
    assert found.horizon is None
    assert found.error == pytest.approx(followed.error, rel=0.05)
    with refuses("fit"):
        validate_fit(followed, other, horizon=1.0)


@pytest.mark.slow
def test_a_record_of_another_axis_is_told_by_what_it_shows(
    emps2015: GeneratedAxis, twin: Record, other: Record
) -> None:
    """By its law, its sample period and its signals; a record of the axis tells nothing of it."""
    followed = fit(emps2015, twin, "control", start=TRUTH)
    assert validate_fit(followed, other).notes == ()
    stiffer = twin_record(
        build(replace(emps2015.axis, control=cascade_pd(kp=200.0, kv=243.45, period=1e-3)))
    )
    assert validate_fit(followed, other).belief == "believed"
    found = validate_fit(followed, stiffer)
    assert found.belief == "not believed"
    law = finding_of(checks_of(found)["control law"], LawOfSecondRecord)
    assert law in found.notes
    assert isinstance(law.finding, OtherGains)
    assert "kp" in [gain.name for gain in law.finding.alternatives[0]]
    slower = validate_fit(followed, twin_record(emps2015, sample_period=2e-3)).notes
    assert slower[0] == SamplePeriods(of_record=0.002, of_fit=0.001, are_equal=False)
    pressed = replace(other, signals={"pressure": np.ones(len(other.time))})
    with refuses("validation", "pressure"):
        validate_fit(followed, pressed)


@pytest.mark.slow
def test_parameters_of_each_record_are_no_others(
    emps2015: GeneratedAxis, twin: Record, other: Record, opened: OutputFit
) -> None:
    local = fit(emps2015, [twin, other], "open-loop", start="nominal", local="Fc")
    with refuses("validation"):
        validate_fit(local, other)
    with refuses("fit"):
        validate_fit(opened, twin, horizon=0.0)
