"""Fits of the loop's output: right where the law is, and saying so where it is not."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from axisid import (
    Parameter,
    Record,
    build,
    fit,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.elements import Drive
from axisid.estimation.choices import open_loop_fit
from axisid.estimation.diagnostics.control_law import FoundGainsDiffer, OtherScale
from axisid.estimation.diagnostics.parameter_findings import FewRows
from axisid.estimation.output_error import OutputFit
from axisid.estimation.output_error.fit_findings import (
    FitPrecision,
    MovedByLaw,
    PriorAndRecord,
    ShownParameters,
)
from axisid.estimation.verdict_checks import lines_of
from axisid.modeling.declaration.experiment import back_and_forth
from tests.axes.cascaded import cascaded
from tests.axes.unseen import with_bump, with_bump_somewhere
from tests.estimation.output_error.fits import TRUTH, looped, off
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of


@pytest.fixture(scope="module")
def found(emps2015: GeneratedAxis, twin: Record) -> OutputFit:
    return fit(emps2015, twin)


@pytest.mark.slow
def test_the_public_record_has_the_numbers_of_output_error(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    """Those of output-error.md are of a loop that begins at rest; the record begins in motion.

    Its deviations are without what the autoregressions leave unsure.
    """
    control, position = (fit(emps, emps_record, o, rests="keep") for o in ("control", "position"))
    np.testing.assert_allclose(control.physical, [95.389, 210.178, 19.853, -3.1679], rtol=2e-4)
    np.testing.assert_allclose(position.physical, [95.205, 208.209, 20.038, -3.1677], rtol=1e-4)
    assert control.error_percent == pytest.approx(4.529, abs=1e-3)
    assert position.error == pytest.approx(1.610e-6, rel=1e-3)
    for result in (control, position):
        assert len(result.best.steps) <= 10
        np.testing.assert_allclose(result.deviations, [0.25, 4.2, 0.34, 0.14], rtol=0.8)
    assert np.abs(control.law_moves["kp*kv"] / control.physical).max() < 0.005
    assert np.abs(position.law_moves["kp*kv"] / position.physical).max() > 0.3


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_no_check_of_an_exact_record_fails_from_rest_or_from_a_move(
    emps2015: GeneratedAxis, output: str
) -> None:
    """Its law reads an ideal velocity, which no log has, so that no factor of it is exact."""
    whole = twin_record(emps2015, position_noise=0.0)
    for record, within in ((whole, 1e-9), (whole.windowed((1.85, 7.0)), 1e-4)):
        result = fit(emps2015, record, output)
        np.testing.assert_allclose(result.physical, [*TRUTH.values()], rtol=within)
        assert not [check for check in result.checks if check.status == "fail"]
        # How far its noise moves the parameters is known of the whole record alone.
        assert result.believed == (record is whole)


@pytest.mark.slow
@pytest.mark.parametrize(
    "start",
    ["nominal", "least-squares", "didim", {"M": 20.0}, {"M": 95.0, "Fv": 0.0, "Fc": 0.0}],
    ids=["nominal", "least squares", "an estimate", "far", "on bounds"],
)
def test_the_end_is_the_same_wherever_it_starts(
    emps2015: GeneratedAxis, twin: Record, found: OutputFit, start: Any
) -> None:
    if start == "didim":
        start = identify(emps2015, twin, methods=start)[start]
    result = fit(emps2015, twin, start=start)
    np.testing.assert_allclose(result.physical, found.physical, rtol=1e-5)
    assert result.started == (start if isinstance(start, str) else "given")


def test_vague_parameters_of_a_few_samples_fail_and_the_rows_are_told(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    result = fit(emps2015, twin.windowed((2.99, 3.0)))
    precision, rows = checks_of(result)["precision"], checks_of(result)["rows"]
    assert (precision.status, rows.status) == ("fail", "fail")
    unidentified = finding_of(precision, FitPrecision).unidentified
    assert "Fv" in [each.name for each in unidentified]
    few = finding_of(rows, FewRows)
    assert (few.rows, few.parameters) == (1, 3)


@pytest.mark.slow
def test_what_a_bound_holds_leaves_the_others_as_unsure_as_without_it(
    emps2015: GeneratedAxis, twin: Record, found: OutputFit
) -> None:
    below = found["Fc"].value - 0.2 * found["Fc"].deviation
    result = fit(emps2015, twin, bounds={"Fc": (None, below)})
    assert result.at_bound == {"Fc": "upper"}
    low, high = result["Fc"].interval
    assert low < high == result["Fc"].value == below
    assert result.derive("2*M").deviation == pytest.approx(2 * result["M"].deviation)
    with refuses("bounds", says="Fc is at a bound"):
        result.derive("M/Fc")
    for which, matrix in found.covariances.items():
        variances = np.diag(result.covariances[which])
        np.testing.assert_allclose(variances[:2], np.diag(matrix)[:2], rtol=0.04)
    held = fit(emps2015, twin, fixed={"Fc": below})
    np.testing.assert_allclose(result.physical, held.physical, rtol=1e-5)
    assert held["Fv"].deviation < 0.9 * result["Fv"].deviation


@pytest.mark.slow
def test_intervals_beside_bounds_hold_the_truth_within_a_move(emps2015: GeneratedAxis) -> None:
    """In 50 ms of a move nothing tells the frictions apart, and chance drives them to bounds."""
    records = [twin_record(emps2015, seed=seed).windowed((1.2, 1.25)) for seed in range(100, 108)]
    found = [fit(emps2015, record) for record in records]
    assert sum(bool(each.at_bound) for each in found) >= 4
    ends = np.array([each["M"].interval for each in found])
    assert np.count_nonzero((ends[:, 0] <= TRUTH["M"]) & (TRUTH["M"] <= ends[:, 1])) >= 7


@pytest.mark.slow
@pytest.mark.parametrize("mean", [95.0, 100.2])
def test_what_was_known_counts_beside_what_the_record_leaves_without_it(
    emps2015: GeneratedAxis, twin: Record, found: OutputFit, mean: float
) -> None:
    """One that contradicts the record by 50 deviations has the weight that its own have."""
    alone, sd = found["M"], 0.1
    share = 1 / (1 + (sd / alone.deviations["coloured"]) ** 2)
    result = fit(emps2015, twin, prior={"M": (mean, sd)})
    both = alone.value + share * (mean - alone.value)
    assert result["M"].value == pytest.approx(both, abs=0.3 * alone.deviation)
    assert result.without_prior["M"] == pytest.approx((alone.value, alone.deviation), rel=1e-5)
    both_values = finding_of(checks_of(result)["what was known"], PriorAndRecord)
    assert (both_values.parameter, both_values.prior, both_values.standard_error) == ("M", mean, sd)
    assert both_values.of_record == pytest.approx(alone.value, rel=1e-5)
    assert both_values.agree == (mean != 95.0)
    assert result.belief == ("not believed" if mean == 95.0 else "believed")


@pytest.mark.slow
def test_twins_do_not_make_what_was_known_surer(emps2015: GeneratedAxis, twin: Record) -> None:
    result = fit(emps2015, twin, prior={"M": (100.2, 1e-4)}, bootstrap=8)
    assert result["M"].deviation == pytest.approx(1e-4, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("loss", ["huber", "soft-l1"])
def test_robust_losses_withstand_what_is_no_part_of_the_loop(
    emps2015: GeneratedAxis, twin: Record, loss: str
) -> None:
    spoiled = twin.control.copy()
    spoiled[1000:1040] += 4.0
    spoiled[5000:5040] += 4.0
    record = replace(twin, control=spoiled)
    robust, plain = fit(emps2015, record, loss=loss), fit(emps2015, record)
    truth = np.array([*TRUTH.values()])
    far, plain_far = (np.abs(r.physical / truth - 1).max() for r in (robust, plain))
    assert far < min(0.01, plain_far / 2)
    assert np.abs(off(robust)).max() < 4


@pytest.mark.slow
def test_a_law_one_percent_wrong_is_named_with_what_it_moves(twin: Record) -> None:
    axis = build(load_axis("emps2015")).with_gains({"kp": 1.01 * 160.18})
    position, control = fit(axis, twin, "position"), fit(axis, twin)
    far = position["Fv"].value / TRUTH["Fv"] - 1
    assert far > 0.3
    told = checks_of(position)["law's factors"]
    assert told.status == "fail"
    assert finding_of(told, MovedByLaw).parameter == "Fv"
    # A right prediction of a large error, to the first order.
    corrected = position["Fv"].value + position.law_move[1]
    assert abs(corrected / TRUTH["Fv"] - 1) < 0.1 * far
    assert abs(control["Fv"].value / TRUTH["Fv"] - 1) < 0.01
    # The law's check itself fails for what is moved by much; else that is said once, with care.
    assert checks_of(position)["control law"].status == "fail"
    assert position.belief == "not believed"
    assert control.belief == "with care"
    assert lines_of(c.name for c in control.checks if c.status == "fail") == ("law",)


@pytest.mark.slow
def test_a_fit_whose_law_and_model_could_not_be_checked_is_to_be_used_with_care(
    twin: Record,
) -> None:
    result = fit(load_axis("emps2015"), replace(twin, control=None), "position")
    left_open = {check.name for check in result.checks if check.leaves_open}
    assert {"control law", "missing terms", "noise in the loop"} <= left_open
    assert result.belief == "with care"


@pytest.mark.slow
def test_a_gain_of_a_law_with_an_integral_is_named_with_what_it_moves() -> None:
    right = build(cascaded())
    record = twin_record(right)
    wrong = right.with_gains({"kp": 1.001 * right.axis.control.gains["kp"]})
    expected, found = (fit(axis, record, "position") for axis in (right, wrong))
    said, told = (checks_of(each)["law's factors"] for each in (expected, found))
    assert (said.status, told.status) == ("pass", "fail")
    moved = found.physical - expected.physical
    assert np.abs(moved).max() > 10 * np.abs(moved + found.law_move).max()


@pytest.mark.slow
def test_a_limit_that_is_declared_a_little_wrong_is_named_with_what_it_moves(
    emps: GeneratedAxis,
) -> None:
    experiment, drive = emps.axis.experiment, emps.axis.drive
    moves = back_and_forth(speeds=(0.15,), acceleration=3.0, seconds=0.3, repeat=4)
    quick = replace(emps.axis, experiment=replace(experiment, moves=moves))
    record, wider = twin_record(quick, seed=7), replace(drive, limit=1.007 * drive.limit)
    right, wrong = (fit(replace(quick, drive=each), record) for each in (drive, wider))
    said, told = (checks_of(each)["law's factors"] for each in (right, wrong))
    assert (said.status, told.status) == ("pass", "fail")
    correction = finding_of(told, MovedByLaw).correction
    assert correction is not None
    assert correction.term == "drive's limit"
    assert correction.factor == pytest.approx(0.993, abs=1e-3)
    np.testing.assert_allclose(wrong.law_move, right.physical - wrong.physical, rtol=0.1)


@pytest.mark.slow
def test_a_control_that_is_scaled_by_a_fifth_is_not_believed(twin: Record) -> None:
    """Its factors explain it, and would be those of its scale, which every estimate has."""
    result = fit(load_axis("emps2015"), replace(twin, control=1.2 * twin.control))
    assert result.belief == "not believed"
    assert checks_of(result)["control law"].status == "fail"


@cache
def _pushed() -> tuple[GeneratedAxis, Record]:
    """An axis under a weight, and its twin behind an encoder."""
    base = load_axis("emps2015")
    weight = Parameter("F0", "N", nominal=50.0)
    law = cascade_pd_difference(kp=60.0, kv=150.0, period=1e-3)
    experiment = replace(
        base.experiment, truth={**TRUTH, "F0": 80.0}, position_noise=0.0, resolution=2e-6
    )
    axis = replace(
        base,
        name="pushed",
        parameters=(*base.parameters, weight),
        force=base.force + weight.symbol,
        control=law,
        experiment=experiment,
    )
    built = build(axis)
    return built, twin_record(built)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("output", "times", "constant", "status"),
    [
        ("control", 1.0, 0.0, "pass"),
        ("control", 1.05, 0.0, "fail"),
        ("control", 0.991, 0.0, "fail"),
        ("control", 1.0, 0.03, "fail"),
        ("position", 1.0, 0.0, "pass"),
        ("position", 1.0, 0.03, "note"),
    ],
)
def test_a_law_is_judged_by_what_each_explanation_of_the_control_moves(
    output: str, times: float, constant: float, status: str
) -> None:
    """A scale moves every parameter and a constant the weight, where the control is followed."""
    axis, record = _pushed()
    control = np.asarray(record.control)
    size = float(np.sqrt(np.mean(control**2)))
    changed = replace(record, control=times * control + constant * size)
    assert checks_of(fit(axis, changed, output))["control law"].status == status


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_a_flipped_control_is_named_and_nothing_is_reckoned_from_it(output: str) -> None:
    """Of a cascade, whose loop swings by itself with what the flipped control leads to."""
    axis = build(cascaded())
    record = twin_record(axis)
    told = checks_of(fit(axis, replace(record, control=-record.control), output))
    assert told["control law"].status == "fail"
    assert finding_of(told["control law"], OtherScale).scale.times < 0
    assert "law's factors" not in told
    assert output == "position" or told["simulation"].status == "fail"


@pytest.mark.slow
def test_a_record_twice_is_told_and_is_the_same_fit_with_smaller_deviations(
    emps2015: GeneratedAxis, twin: Record, found: OutputFit
) -> None:
    assert fit(emps2015, twin) == found
    twice = fit(emps2015, [twin, twin])
    assert checks_of(twice)["repeated records"].status == "fail"
    np.testing.assert_allclose(twice.physical, found.physical, rtol=1e-5)
    ratio = twice["M"].deviations["coloured"] / found["M"].deviations["coloured"]
    assert ratio == pytest.approx(np.sqrt(0.5), rel=1e-2)


@pytest.mark.slow
def test_a_known_value_leaves_as_unsure_as_its_deviation_says(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Of one record as what was known before does; of several each weighing counts for its own."""
    known = fit(emps2015, twin, known={"M": [(100.2, 5.0)]}, free="gain")
    before = fit(emps2015, twin, prior={"M": (100.2, 5.0)}, free="gain")
    for name in ("Fv", "Fc", "drive_gain"):
        assert known[name].value == pytest.approx(before[name].value, rel=1e-4)
        # One is a difference over 5 % of the mass, the other a slope.
        assert known[name].deviation == pytest.approx(before[name].deviation, rel=2e-2)
    parts = [twin.windowed((0.0, 1.5)), twin.windowed((1.5, 3.0))]
    same, apart = (
        fit(emps2015, parts, known={"M": told})["drive_gain"]
        for told in ([(100.2, 5.0)] * 2, [(100.2, 5.0), (100.2, 5.0001)])
    )
    assert same.deviation == pytest.approx(known["drive_gain"].deviation, rel=1e-2)
    assert apart.deviation < 0.9 * same.deviation


@pytest.mark.slow
def test_a_search_begins_at_the_start_that_leaves_less(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Instruments of a control that is clipped half of its time are half of the truth."""
    limit = np.median(np.abs(twin.control))
    clipped = replace(twin, control=np.clip(twin.control, -limit, limit))
    model = emps2015.axis
    nominal = tuple(replace(p, nominal=1.01 * TRUTH[p.name]) for p in model.parameters)
    result = fit(build(replace(model, parameters=nominal)), clipped, "position")
    assert result.started == "nominal"
    np.testing.assert_allclose(result.physical, [*TRUTH.values()], rtol=1e-2)
    assert fit(emps2015, clipped, "position").started == "instruments"


@pytest.mark.slow
def test_records_too_short_for_the_filter_of_identify_are_fitted(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    short = [twin.windowed((at, at + 0.1)) for at in (0.2, 3.0, 3.4)]
    with refuses("record"):
        identify(emps2015, short)
    result = fit(emps2015, short, start={**TRUTH})
    assert len(result.records) == len(short)
    assert abs(result["M"].value - TRUTH["M"]) < 4 * result["M"].deviation < 0.1 * TRUTH["M"]


def test_a_move_too_short_for_twins_is_no_surer_than_with_its_start_free(
    emps2015: GeneratedAxis,
) -> None:
    record = twin_record(emps2015, seed=107).windowed((1.2, 1.4))
    result, free = fit(emps2015, record), fit(emps2015, record, free="start")
    assert np.all(result.deviations > free.deviations[:3])
    assert np.all(np.abs(free.physical[:3] - result.physical) < result.deviations)


@pytest.mark.slow
@pytest.mark.parametrize("output", ["control", "position"])
def test_a_record_that_is_cut_from_a_fast_move_is_believed(output: str) -> None:
    """Its law differences positions, of which those before the cut are in no log."""
    declared = load_axis("vertical_screw")
    whole = twin_record(declared, seed=1)
    result = fit(build(declared), whole.windowed((2.58, 6.0)), output)
    assert result.believed
    assert np.abs(off(result, declared.experiment.truth)).max() < 4


@pytest.mark.slow
def test_a_law_may_have_both_a_delay_and_a_memory() -> None:
    """The loop remembers controls that are on their way behind what the law remembers."""
    declared = load_axis("servo_joint")
    late = replace(declared, control=replace(declared.control, delay=1))
    result = fit(build(late), twin_record(late, seed=1).windowed((0.0, 4.0)))
    assert checks_of(result)["law's factors"].status == "pass"


@pytest.mark.slow
def test_what_no_output_shows_is_named(twin: Record, found: OutputFit) -> None:
    """A force at a place where the axis never is; the others are what they are without it."""
    result = fit(with_bump(0.5), twin)
    assert checks_of(result)["parameters shown"].status == "fail"
    assert [each.parameters for each in result.unseen] == [("Fb",)]
    assert result["Fb"].deviation == np.inf
    away = [(result[n].value - found[n].value) / found[n].deviation for n in found.names]
    np.testing.assert_allclose(away, 0.0, atol=0.15)
    assert result["M"].deviation == pytest.approx(found["M"].deviation, rel=0.02)
    assert result.to_dict()["parameters"]["Fb"]["sd"] is None
    assert (
        finding_of(checks_of(result)["parameters shown"], ShownParameters).unseen == result.unseen
    )
    assert result.to_dict()["unseen"] == ["Fb at all"]
    assert result.derive("Fb/M").deviation == np.inf


@pytest.mark.slow
def test_what_the_model_lacks_is_noise_to_twins_and_makes_nothing_surer(
    emps2015: GeneratedAxis,
) -> None:
    """A force of 5 N with a place, undeclared."""
    record = twin_record(emps2015)
    pushed = replace(record, control=record.control + 5.0 / 35.15 * np.sin(60 * record.position))
    quiet, result = (fit(emps2015, each, bootstrap=16) for each in (record, pushed))
    assert np.all(result.deviations > 5 * quiet.deviations)


@pytest.mark.slow
def test_a_measured_force_is_followed(
    emps2015: GeneratedAxis, twin: Record, found: OutputFit
) -> None:
    result = fit(emps2015, replace(twin, force=35.15 * twin.control), "force")
    np.testing.assert_allclose(result.physical, found.physical, rtol=1e-5)
    assert result.unit == "N"


@pytest.mark.slow
def test_several_starts_leave_what_is_0_and_signs_that_are_allowed() -> None:
    """A force of the other sign about another place: about the start nothing leads there."""
    declared = with_bump_somewhere(0.02)
    axis, record = build(declared), twin_record(declared).windowed((0.0, 3.2))
    start = {"Fb": 10.0, "at": 0.0}
    one, several = (fit(axis, record, start=start, starts=count) for count in (1, 8))
    assert not one.believed
    assert several.believed
    assert several["Fb"].value == pytest.approx(-12.0, abs=0.5)
    assert several["at"].value == pytest.approx(0.02, abs=2e-4)
    assert several.searches[0].cost > 1.2 * several.best.cost
    again = fit(axis, record, start=start, starts=8)
    np.testing.assert_array_equal(again.physical, several.physical)


@pytest.mark.slow
def test_a_constant_force_that_the_model_lacks_is_named(
    emps2015: GeneratedAxis, twin: Record, found: OutputFit
) -> None:
    """A residual of a few percent is no noise where it goes with the motion."""
    record, _ = looped(emps2015, [*TRUTH.values()], twin.reference, 1e-6, unseen=0.1)
    result = fit(emps2015, record)
    first = result.lacks[0][0]
    assert first.kind == "constant"
    assert first.values == pytest.approx((-3.515,), rel=0.05)
    told = [checks_of(each)["missing terms"].status for each in (result, found)]
    assert told == ["fail", "pass"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("output", "how", "off"),
    [
        ("control", {"fixed": {"M": 95.0}}, 5.2),
        ("open-loop", {"fixed": {"M": 95.0}, "horizon": 0.25}, 5.2),
        ("control", {"bounds": {"Fv": (None, 200.0)}}, 36.9),
        ("control", {"prior": {"Fv": (200.0, 0.2)}}, 36.9),
    ],
    ids=["held", "held in open loop", "bound", "prior"],
)
def test_what_holds_a_declared_parameter_wrongly_is_told_by_its_name(
    emps2015: GeneratedAxis, twin: Record, output: str, how: dict[str, Any], off: float
) -> None:
    result = fit(emps2015, twin, output, **how)
    first, *others = result.lacks[0]
    assert (first.kind, first.parameter) == ("held", "M" if "fixed" in how else "Fv")
    assert abs(first.values[0] - off) < 5 * first.deviation + 0.05 * off
    assert "viscous" not in [lack.kind for lack in others]
    failed = {check.name for check in result.checks if check.status == "fail"}
    assert failed & {"missing terms", "bounds", "what was known"}


@pytest.mark.slow
@pytest.mark.parametrize(("late", "output"), [("delay", "control"), ("lag", "position")])
def test_a_time_that_is_not_there_is_told_and_no_term_that_is_declared(
    late: str, output: str
) -> None:
    declared = cascaded(delay=2e-3) if late == "delay" else cascaded(lag=5e-3)
    result = fit(build(declared), twin_record(build(cascaded())), output)
    kinds = [lack.kind for lack in result.lacks[0]]
    assert kinds[0] == "delay"
    assert result.lacks[0][0].size < 0
    assert not {"coulomb", "viscous", "constant", "inertia"} & {*kinds}


@pytest.mark.slow
def test_noise_that_is_most_of_an_output_is_no_lack(
    emps2015: GeneratedAxis, twin: Record, found: OutputFit
) -> None:
    """Half of the control is the encoder's noise, a tenth of its steps' size apart."""
    record, _ = looped(emps2015, [*TRUTH.values()], twin.reference, 3e-5)
    result = fit(emps2015, record)
    assert result.error_percent > 40
    assert result.percent_beyond_noise < 15
    assert result.believed
    assert found.of_records[0].noise == pytest.approx(found.error, rel=0.05)


@pytest.mark.slow
def test_a_lag_of_the_drive_is_found_with_the_parameters(emps2015: GeneratedAxis) -> None:
    record = twin_record(replace(emps2015.axis, drive=replace(emps2015.axis.drive, lag=8e-4)))
    result = fit(emps2015, record, free="lag")
    assert np.abs(off(result, {**TRUTH, "lag": 8e-4})).max() < 4
    assert result.axis.axis.drive.lag == pytest.approx(result["lag"].value, abs=1e-5)
    assert result["lag"].deviation < 1e-4
    assert result.started == "instruments"
    assert checks_of(fit(emps2015, record))["missing terms"].status == "fail"


@pytest.mark.parametrize(
    ("code", "given"),
    [
        ("method", {"output": "speed"}),
        ("method", {"loss": "cubes"}),
        ("method", {"rests": "drop"}),
        ("free", {"free": ("lag", "delay")}),
        ("method", {"gain": "free"}),
        ("parameters", {"local": "Fc"}),
        ("fit", {"starts": 0}),
        ("noise", {"bootstrap": 1}),
        ("fit", {"start": "here"}),
        ("fit", {"start": {"M": np.nan}}),
        ("fit", {"start": {"mass": 1.0}}),
        ("fit", {"bounds": {"mass": (0.0, 1.0)}}),
        ("fit", {"bounds": {"M": (5.0, 4.0)}}),
        ("fit", {"bounds": {"M": (None, -1.0)}}),
        ("fit", {"prior": {"M": (5.0, 0.0)}}),
        ("fit", {"prior": {"M": (95.0, 1e-300)}}),
        ("fit", {"prior": {"M": (1e300, 1.0)}}),
        ("fit", {"horizon": 2.0}),
        ("fit", {"horizon": 0.0, "output": "open-loop"}),
        ("fit", {"prior": {"M": (95.0, 2.0)}, "fixed": {"M": 95.0}}),
        ("fit", {"fixed": {"M": "five"}}),
        ("fit", {"fixed": {"M": -5.0}}),
        ("fit", {"fixed": dict(TRUTH)}),
        ("free", {"free": "kp", "output": "open-loop"}),
        ("free", {"free": "start", "output": "open-loop"}),
        ("free", {"free": "ki"}),
        ("free", {"free": "velocity"}),
        ("free", {"free": "kp", "known": {"kp": [160.0]}}),
        ("method", {"output": ("control", "speed")}),
        ("fit", {"output": ()}),
        ("fit", {"output": ("control", "open-loop")}),
        ("fit", {"output": ("control", "position"), "weights": {"force": 1.0}}),
        ("fit", {"output": ("control", "position"), "weights": {"position": 0.0}}),
        ("fit", {"output": ("control", "position"), "weights": {"position": 1e300}}),
    ],
)
def test_what_cannot_be_asked_is_refused(
    emps2015: GeneratedAxis, twin: Record, code: str, given: dict[str, Any]
) -> None:
    with refuses(code):
        fit(emps2015, twin, **given)


@pytest.mark.parametrize(
    ("code", "says", "axis", "record"),
    [
        ("no-control-law", "", {"control": None}, {}),
        ("missing-column", "", {}, {"reference": None}),
        ("fit", "", {}, {"masked": ((0, 7801),)}),
        ("too-short", "", {}, {"masked": ((3, 7801),)}),
        (  # the sign of the gain is flipped, and nothing can start
            "fit",
            "M = -99.7.*signs of the control",
            {"drive": Drive(gain=-35.15, unit="V", limit=10.0)},
            {},
        ),
    ],
)
def test_what_has_no_loop_to_follow_is_refused(
    twin: Record, code: str, says: str, axis: dict[str, Any], record: dict[str, Any]
) -> None:
    with refuses(code, says):
        fit(replace(load_axis("emps2015"), **axis), replace(twin, **record))


@pytest.mark.slow
def test_a_gain_that_a_flat_valley_leads_astray_is_told_by_the_law(emps2015: GeneratedAxis) -> None:
    """Position alone leaves kp and all forces open; noise bends the valley's floor here."""
    record = twin_record(emps2015, seed=5)
    found = fit(emps2015, record, "position", free="kp", rests="keep")
    assert found["kp"].deviation < 1.0 < abs(found["kp"].value - 160.18)
    told = checks_of(found)["control law"]
    assert told.status == "fail"
    # The gain is that of the table.
    assert finding_of(told, FoundGainsDiffer).found == {"kp": found["kp"].value}
    assert checks_of(fit(emps2015, record, "position"))["convergence"].status == "pass"


@pytest.mark.slow
@pytest.mark.parametrize("steps", [{}, {"quantisation": 0.01}])
def test_a_drive_with_a_lag_and_with_steps_is_fitted(steps: dict[str, float]) -> None:
    """Its loop remembers more than the law does, and steps hold no search where it starts."""
    joint = load_axis("servo_joint")
    axis = build(replace(joint, drive=replace(joint.drive, **steps)))
    record = twin_record(axis)
    found = fit(axis, record)
    assert np.abs(off(found, record.provenance.truth)).max() < 4
    assert np.all(found.deviations < 0.005 * found.physical)
    assert found.believed
    assert all(np.all(np.isfinite(moves)) for moves in found.law_moves.values())


@pytest.mark.slow
def test_free_gains_are_found_with_the_parameters(emps2015: GeneratedAxis, twin: Record) -> None:
    law, experiment = emps2015.axis.control, emps2015.axis.experiment
    wrong = emps2015.with_gains({"kp": 1.05 * law.gains["kp"]})
    found = fit(wrong, twin.windowed((None, 1.5)), free="kp", start="nominal")
    assert np.abs(off(found, {**experiment.truth, "kp": law.gains["kp"]})).max() < 4
    assert found["kp"].deviation < 0.015 * law.gains["kp"]
    assert checks_of(found)["control law"].status == "pass"


@pytest.mark.slow
@pytest.mark.parametrize("step", [0, 1])
def test_an_interrupted_fit_is_the_best_so_far_and_says_so(
    emps2015: GeneratedAxis, twin: Record, step: int
) -> None:
    def interrupt(done: int, _: int, __: str) -> None:
        if done == step:
            raise KeyboardInterrupt

    result = fit(emps2015, twin, progress=interrupt)
    (convergence,) = (c for c in result.checks if c.name == "convergence")
    assert result.interrupted
    assert (convergence.status, convergence.figure) == ("fail", step + 1)
    assert np.all(np.abs(result.physical / [*TRUTH.values()] - 1) < 0.2)


@pytest.mark.slow
def test_a_fit_of_a_drives_lag_that_is_interrupted_keeps_its_values(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    def interrupt(done: int, _: int, __: str) -> None:
        if done == 1:
            raise KeyboardInterrupt

    result = fit(emps2015, twin, free="lag", progress=interrupt)
    assert result.interrupted
    assert np.all(np.isfinite(result.physical))


@pytest.mark.slow
def test_a_fit_of_an_open_loop_does_not_advise_itself(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    axis = replace(emps2015.axis, control=None)
    result = fit(axis, twin, "open-loop", bootstrap=0)
    told = [*result.remarks, *(check.meaning for check in result.checks)]
    assert result.started == "least-squares"
    assert not any(open_loop_fit() in each for each in told)
