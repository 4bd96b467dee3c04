"""What filter, noise and the drive gain do to an estimate; gaps; what a record does not show."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kurtosis

from axisid import (
    Axis,
    EstimationError,
    Identification,
    ModelError,
    Prefilter,
    Record,
    build,
    leave_out,
    load_axis,
    read_record,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.elements import Drive
from axisid.estimation.diagnostics import Precision
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.estimation_problem.detectability import SignalRanges, check_visible
from axisid.estimation.methods import METHODS, estimate_by
from axisid.estimation.regression.inverse_and_direct import InverseForm
from axisid.estimation.signals import FilteredRecord
from axisid.modeling import LIBRARY
from axisid.modeling.declaration import Move
from axisid.modeling.library.valve import STROKES
from benchmarks.machines import Machine, records, white
from tests.axes.drives import BRAKE, braked
from tests.axes.unseen import with_bump, with_stribeck
from tests.estimation.methods.test_partially_linear import TRUTH, stribeck_axis
from tests.estimation.signals.test_filtered_record import cut
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of, statuses


def valve() -> Identification:
    """A twin that reverses so often that no reversal can be left out; nothing of it sticks."""
    axis = load_axis("valve")
    moves = tuple(Move(d, v, 60.0) for v in (0.1, 0.25, 0.5) * 4 for d in STROKES)
    declared = axis.experiment
    truth = {**declared.truth, "Fs": 0.0}
    quick = replace(
        axis,
        drive=Drive(gain=22.0, unit="A", limit=12.0),
        experiment=replace(declared, moves=moves, truth=truth),
    )
    made = build(leave_out(quick, "Fs"))
    return identify(made, twin_record(made), methods=["idm-ls", "idm-iv"])


KEPT = Prefilter(reversals="keep")  # where the filter moves estimates most


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("hold", ["zoh", "raw"])
def test_on_a_noise_free_twin_it_is_the_whole_error(
    emps2015: GeneratedAxis, method: str, hold: str
) -> None:
    prefilter = Prefilter(hold=hold)  # type: ignore[arg-type]
    record = twin_record(emps2015, position_noise=0.0)
    estimate = identify(emps2015, record, prefilter, [method])[method]
    error = estimate.physical - np.array([100.2, 236.9, 24.8])
    assert estimate.filter_bias == pytest.approx(error, rel=0.2, abs=0.02)


@pytest.mark.slow
def test_intervals_hold_the_truth_since_they_are_less_it(emps2015: GeneratedAxis) -> None:
    """By instruments, under the default filter, where those about the value miss the mass."""
    held = {"about the value": 0, "given": 0}
    for seed in range(20):
        record = twin_record(emps2015, seed=seed)
        mass = identify(emps2015, record, KEPT, "idm-iv")["idm-iv"].parameters["M"]
        low, high = mass.interval
        assert (low + high) / 2 == pytest.approx(mass.corrected, rel=1e-12)
        held["about the value"] += low < 100.2 - mass.filter_bias < high
        held["given"] += low < 100.2 < high
    assert held["about the value"] < 5
    assert held["given"] > 17


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("emps", "control"),
        ("emps", "force"),
        ("vertical_screw", "control"),
        ("rotary_table", "force"),
    ],
)
def test_without_a_reference_it_is_found_by_a_loop_that_follows(name: str, source: str) -> None:
    """Where least squares are several deviations off, for the filter or for noise."""
    axis = build(load_axis(name))
    twin = twin_record(axis, seed=1)
    truth = np.array(list(twin.provenance.truth.values()))
    record = replace(twin, reference=None)
    if source == "force":
        held = axis.axis.drive.gain * np.asarray(twin.control)
        force = (held + np.concatenate([held[:1], held[:-1]])) / 2
        record = replace(record, control=None, force=force)
    estimate = identify(axis, record, methods="idm-ls")["idm-ls"]
    deviations = np.array([v.deviation for v in estimate.parameters.values()])
    assert np.max(np.abs(estimate.physical - truth) / deviations) > 2.5
    assert np.max(np.abs(estimate.corrected - truth) / deviations) < 3.5
    assert np.max(np.abs(estimate.filter_bias) / deviations) > 2
    assert estimate.inference.chains


def test_noise_that_the_law_did_not_measure_is_none_to_follow_by() -> None:
    """A log that is coarser than the law's position: its control does not answer to that."""
    axis = build(load_axis("emps"))
    twin = twin_record(axis, seed=1)
    step = np.ptp(twin.position) / 2**12
    coarse = np.round(twin.position / step) * step
    result = identify(axis, replace(twin, reference=None, position=coarse), methods="idm-ls")
    assert result["idm-ls"].filter_bias is None


@pytest.mark.slow
def test_residuals_are_free_of_the_filter_where_it_moves_the_estimate_too() -> None:
    """Loops of an estimate that is 2 % off leave something else behind the filter."""
    found = valve()
    estimate = found.preferred
    assert estimate.net_residuals.std() < 0.03 * estimate.residuals.std()
    assert (
        kurtosis(estimate.net_residuals) > 6
    )  # of what noise there is at reversals, a fortieth of all
    assert statuses(found)["outliers"] == "pass"


def _slow_sines(axis: GeneratedAxis, friction: float, noise: float, seed: int = 1) -> Record:
    """Two slow sines that turn often, with white noise of the measured position, m."""
    time = 1e-3 * np.arange(18000)
    waves = 0.02 * np.sin(2 * np.pi * 0.3 * time) + 0.004 * np.sin(2 * np.pi * 1.1 * time)
    reference = np.minimum(1.0, time / 0.5) * waves
    machine = Machine(mass=100.2, viscous=236.9, coulomb=friction, position_noise=white(noise))
    (columns,) = records(machine, reference, 1, seed)
    return read_record(columns, axis)


@pytest.mark.slow
def test_bias_is_found_again_where_it_leads(emps2015: GeneratedAxis) -> None:
    """With too little friction the loop turns otherwise; one correction would go beyond."""
    record = _slow_sines(emps2015, friction=90.0, noise=0.0)
    estimate = identify(emps2015, record, KEPT, "idm-iv")["idm-iv"]
    truth = np.array([100.2, 236.9, 90.0])
    assert np.abs(estimate.physical - truth)[1] > 50
    assert np.abs(estimate.corrected - truth)[1] < 5


CUT = 4000


def problem(axis: GeneratedAxis, *records: Record, **settings: object) -> Problem:
    filter_ = Prefilter(**settings)  # type: ignore[arg-type]
    data = tuple(FilteredRecord.bind(axis, record, filter_) for record in records)
    return Problem(axis=axis, data=data)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("reversals", ["keep", "leave-out"])
def test_a_record_with_a_gap_and_its_two_parts_are_the_same_thing(
    emps2015: GeneratedAxis, twin: Record, method: str, reversals: str
) -> None:
    halves = cut(twin, 0, CUT), cut(twin, CUT, len(twin))
    gapped = replace(twin, segments=((0, CUT), (CUT, len(twin))))
    one, two = (
        estimate_by(problem(emps2015, *records, reversals=reversals), METHODS[method])
        for records in ((gapped,), halves)
    )
    assert two.physical == pytest.approx(one.physical, rel=1e-12)
    for name, covariance in one.covariances.items():
        assert two.covariances[name] == pytest.approx(covariance, rel=1e-9)
    ours, theirs = two.residual_tests, one.residual_tests
    assert ours.durbin_watson == pytest.approx(theirs.durbin_watson, rel=1e-9)
    values = theirs.autocorrelation.values
    assert ours.autocorrelation.values == pytest.approx(values, rel=1e-6, abs=1e-12)
    assert two.simulation_error_percent == pytest.approx(one.simulation_error_percent, rel=1e-9)
    assert two.inference.noise_free == pytest.approx(one.inference.noise_free, rel=1e-6, abs=1e-9)


SD = 0.005


def scaled(axis: Axis, scale: float = 1.0, relative_sd: float = SD) -> Axis:
    gain = scale * axis.drive.gain
    return replace(axis, drive=replace(axis.drive, gain=gain, relative_sd=relative_sd))


@pytest.mark.slow
@pytest.mark.parametrize(("made", "kept"), [(scaled, 0.0), (braked, BRAKE)])
@pytest.mark.parametrize("method", ["idm-ls", "ddm-ls", "idm-iv", "ddm-iv"])
def test_it_is_what_another_gain_does_to_the_estimate(
    emps2015: GeneratedAxis, method: str, made: Callable[..., Axis], kept: float
) -> None:
    """Where a motor brakes, that keeps its size: friction takes what the gain leaves."""
    step = 1e-3
    record = twin_record(build(made(emps2015.declared)), seed=3)
    axes = [made(emps2015.declared, scale=s, relative_sd=SD) for s in (1 - step, 1.0, 1 + step)]
    low, mid, high = (identify(a, record, methods=[method], bootstrap=0)[method] for a in axes)

    def slope(of: str) -> float:
        return abs(high.derive(of).value - low.derive(of).value) / (2 * step)

    for name, value in mid.parameters.items():
        assert value.sd_gain == pytest.approx(SD * slope(name), rel=2e-3, abs=1e-3)
        also = value.value + (kept if name == "Fv" else 0.0)
        assert value.sd_gain == pytest.approx(SD * also, rel=2e-3)
    for i, value in enumerate(mid.ddm_parameters.values()):
        moved = (high.theta_ddm[i] - low.theta_ddm[i]) / (2 * step)
        assert value.sd_gain == pytest.approx(SD * abs(moved), rel=1e-2, abs=1e-5 * value.value)


@pytest.mark.parametrize("sd", [-0.1, 1.0, np.nan, np.inf])
def test_impossible_deviations_are_refused(sd: float) -> None:
    with pytest.raises(ModelError, match="drive gain"):
        Drive(gain=1.0, relative_sd=sd)


def leaves_out(error: EstimationError) -> list[str]:
    """The parameters that an error advises to leave out."""
    assert ("reversals=" in str(error)) == ("without the samples near" in str(error))
    return re.findall(r"leave_out\(axis, \"(\w+)\"\)", str(error))


@pytest.mark.slow
@pytest.mark.parametrize("speed", [1e-3, 3e-3, 5e-3])
@pytest.mark.parametrize("method", ["idm-ls", "ddm-ls", "idm-iv", "ddm-iv"])
def test_friction_at_speeds_that_no_row_has_is_named(speed: float, method: str) -> None:
    axis = build(with_stribeck(speed))
    with refuses(
        "not-shown",
        says=r"Fs would have to be .* N where it acts most, .* force of the record is 15\d N\.",
    ) as refused:
        identify(axis, twin_record(axis), methods=method)
    assert (refused.value.code, leaves_out(refused.value)) == ("not-shown", ["Fs"])


@pytest.mark.slow
@pytest.mark.parametrize(("nominal", "place"), [(10.0, 0.15), (10.0, 0.09), (0.0, 0.15)])
def test_a_place_that_the_axis_never_reaches_is_named(nominal: float, place: float) -> None:
    axis = build(with_bump(place, nominal))
    with refuses("not-shown", says=r"Fb would have to be .* typical parameter in N is about"):
        identify(axis, twin_record(axis))


@pytest.mark.slow
@pytest.mark.parametrize(("place", "seed"), [(0.07, 0), (0.075, 1), (0.075, 2)])
def test_a_place_that_is_hardly_reached_is_never_believed(place: float, seed: int) -> None:
    """Its part of the force is below 1 %, and yet nothing is known of it."""
    axis = build(with_bump(place))
    result = identify(axis, twin_record(axis, seed=seed), methods=["idm-ls", "idm-iv"])
    precision = checks_of(result)["precision"]
    assert precision.status == "fail"
    (unidentified,) = finding_of(precision, Precision).unidentified
    assert [each.name for each in unidentified.parameters] == ["Fb"]


@pytest.mark.slow
def test_a_search_keeps_to_speeds_that_the_record_shows() -> None:
    """At a hundredth of the true speed every level of the friction would fit."""
    declared = stribeck_axis()
    small = tuple(replace(p, nominal=1e-3) if p.name == "v" else p for p in declared.parameters)
    axis = build(replace(declared, parameters=small))
    record = twin_record(axis)
    with refuses(
        "no-convergence", says=r"no start value of v .* at the first start value: .*not show s"
    ):
        identify(axis, record, methods="idm-ls")
    found = identify(stribeck_axis(), record, methods="idm-ls")["idm-ls"].parameters
    assert found["s"].value == pytest.approx(TRUTH["s"], rel=0.2)


@pytest.mark.parametrize("name", LIBRARY)
def test_right_models_are_a_hundred_times_from_being_refused(name: str) -> None:
    """Even if each term acted 100 times as strongly somewhere else along the record."""
    axis = build(load_axis(name))
    record = twin_record(axis, seed=1)
    data = FilteredRecord.bind(axis, record, Prefilter.suited(record.period))
    equations = InverseForm(axis).equations(data.signals)
    reach = SignalRanges.of([(data.signals, equations, data.sampling.kept)])
    rows = equations.reduced(data)
    check_visible(
        axis,
        replace(reach, columns=100 * reach.columns),
        rows.regressor,
        rows.left - rows.intercept,
        source="the record",
        without_turns=True,
    )
