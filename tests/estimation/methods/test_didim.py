"""DIDIM and instruments: where they start and end, on records and twins with known truth."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Coordinate,
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    load_axis,
    newton,
    read_record,
    simulate,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import cascade_pd_difference, pid
from axisid.elements import Drive, coulomb, viscous
from axisid.estimation.diagnostics.model_error_checks import (
    LoopNotSimulated,
    SimulatedLoop,
    simulation_error_check,
)
from axisid.estimation.estimates import NotSimulated
from axisid.estimation.methods.instrumental import NEARLY_CONVERGED
from axisid.estimation.thresholds import CONVERGED
from axisid.modeling import Experiment, back_and_forth
from benchmarks.machines import Machine, records, white
from tests.axes.stage import generated, stage_record
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of, statuses

#: The paper's, of the published record.
PUBLISHED = Prefilter(cutoff=100.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")


@pytest.fixture(scope="module")
def alone(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, methods="didim")


@pytest.mark.parametrize("mass", [5.0, 100.0, 400.0, 1000.0])
def test_emps_ends_at_the_same_from_any_mass(
    emps: GeneratedAxis, emps_record: Record, mass: float
) -> None:
    first = [replace(p, nominal=mass) if p.name == "M" else p for p in emps.axis.parameters]
    started = build(replace(emps.axis, parameters=tuple(first)))
    methods = ["idm-iv", "didim"] if mass == 100 else ["didim"]
    result = identify(started, emps_record, PUBLISHED, methods, start="nominal")
    found = result["didim"]
    assert found.started == "nominal"
    assert found.iterates[0].physical[0] == mass
    assert found.physical == pytest.approx([94.8896, 208.2889, 20.03959, -3.169823], rel=2e-5)
    assert found.simulation_error_percent == pytest.approx(4.514, abs=0.005)
    if mass == 100:  # on the instruments without the filter's bias
        deviations = np.array([value.deviation for value in found.parameters.values()])
        assert np.all(np.abs(found.corrected - result["idm-iv"].corrected) < 0.3 * deviations)


_X = Coordinate("x", unit="m")
_M, _B, _C = Parameter("M", "kg", nominal=4.0), Parameter("b", "N/(m/s)"), Parameter("c", "N")
#: A PI on the position, which only friction keeps stable.
_BY_FRICTION = newton(
    "by_friction",
    coordinate=_X,
    parameters=(_M, _B, _C),
    inertia=_M,
    resistance=(viscous(_B, _X), coulomb(_C, _X)),
    drive=Drive(gain=10.0, unit="A", limit=100.0),
    control=pid(kp=200.0, ki=3000.0, kd=0.0, period=1e-3),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.05, 0.1, 0.2), acceleration=2.0, seconds=0.5, repeat=2),
        truth={"M": 2.0, "b": 50.0, "c": 2.0},
    ),
)


@pytest.mark.slow
@pytest.mark.parametrize("start", ["nominal", "least-squares"])
def test_a_loop_that_friction_keeps_stable_is_identified_from_any_start(start: str) -> None:
    """Without friction it diverges, and the rows of the simulated loop are far from its slopes."""
    axis = build(_BY_FRICTION)
    result = identify(axis, twin_record(axis), methods=["idm-iv", "didim"], start=start)
    assert not result.failed
    assert result["didim"].physical == pytest.approx([2.0, 50.0, 2.0], rel=1e-8)
    assert result["idm-iv"].physical == pytest.approx([2.0, 50.0, 2.0], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps2015", "pendulum", "valve"])
def test_a_twin_without_noise_gives_the_truth(name: str) -> None:
    axis = build(load_axis(name))
    record = twin_record(axis, position_noise=0.0)
    found = identify(axis, record, methods="didim")["didim"]
    truth = [record.provenance.truth[n] for n in axis.names]
    assert found.physical == pytest.approx(truth, rel=1e-9)
    assert np.abs(found.corrected - found.physical).max() < 1e-8 * np.abs(truth).max()


def test_the_estimate_is_least_squares_of_the_loops_rows(alone: Identification) -> None:
    """Its published deviations are of those alone."""
    didim = alone["didim"]
    found, *_ = np.linalg.lstsq(didim.Z, didim.y, rcond=None)
    assert found == pytest.approx(didim.theta, rel=1e-9)
    variance = float(didim.residuals @ didim.residuals) / (len(didim.y) - 1)
    plain = variance * np.linalg.inv(didim.Z.T @ didim.Z)
    assert didim.covariances["iid"] == pytest.approx(plain, rel=1e-6)


def test_noise_of_the_force_moves_it_as_slopes_of_the_loop_say(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """A whole refit of a control with more noise, against one step by (Z'X)^-1 Z'."""
    more = 1e-3 * np.random.default_rng(2).standard_normal(len(twin))
    refits = [
        identify(emps2015, replace(twin, control=twin.control + each), PUBLISHED, "didim")["didim"]
        for each in (-more, more)
    ]
    moved, added = (getattr(refits[1], n) - getattr(refits[0], n) for n in ("physical", "y"))
    didim = identify(emps2015, twin, PUBLISHED, "didim")["didim"]
    by_slopes, by_rows = (
        np.linalg.solve(didim.Z.T @ each, didim.Z.T @ added) for each in (didim.X, didim.Z)
    )
    assert by_slopes == pytest.approx(moved, rel=0.02)
    assert np.abs(by_rows / moved - 1).max() > 0.05


@pytest.mark.slow
def test_noise_that_shakes_friction_is_taken_off(emps2015: GeneratedAxis) -> None:
    """A loop of encoder differences makes more force of the noise than friction holds."""
    law = cascade_pd_difference(kp=160.18, kv=243.45, period=1e-3)
    axis = build(replace(emps2015.axis, control=law))
    machine = Machine(mass=100.2, viscous=236.9, coulomb=24.8, position_noise=white(3e-6))
    time = 1e-3 * np.arange(8000)
    waves = 0.02 * np.sin(2 * np.pi * 0.3 * time) + 0.004 * np.sin(2 * np.pi * 1.1 * time)
    reference = np.minimum(1.0, time / 0.5) * waves
    kept = Prefilter(cutoff=60.0, decimate=10, reversals="keep")
    missed = 0
    for columns in records(machine, reference, 4, seed=5):
        result = identify(axis, read_record(columns, axis), kept, "didim")
        value = result["didim"].parameters["Fv"]
        assert value.shift > 1.0
        missed += abs(value.value - 236.9) > 2 * value.deviation
        assert abs(value.corrected - 236.9) < 3 * value.deviation
        assert statuses(result)["missing terms"] == "pass"
    assert missed >= 3


@pytest.mark.slow
def test_alone_every_check_is_of_the_loops_rows(
    emps2015: GeneratedAxis, alone: Identification
) -> None:
    assert "fail" not in statuses(alone).values()
    assert "method" not in statuses(alone)
    diagnosis = alone.diagnosis
    assert diagnosis.instruments is None
    assert diagnosis.alignment.by_instruments  # type: ignore[union-attr]
    shaky = twin_record(emps2015, position_noise=2e-5)
    shares = {
        e.name: e.share for e in identify(emps2015, shaky, methods="didim").diagnosis.excitation
    }
    clean = {e.name: e.share for e in diagnosis.excitation}
    assert shares == pytest.approx(clean, rel=0.02), "no noise of the motion is in the regressor"


@pytest.mark.slow
def test_several_records_are_one_regression() -> None:
    """Permuting changes nothing; an offset of its own is each record's; weights are told."""
    records = [stage_record(1, tau0=3.0), stage_record(2, tau0=-2.0)]
    axis = generated()
    found = identify(axis, records, methods=["idm-iv", "didim"], local="tau0")
    turned = identify(axis, records[::-1], methods="didim", local="tau0")
    didim = found["didim"]
    assert [v.value for v in found.local["tau0"]] == pytest.approx([3.0, -2.0], abs=0.3)
    assert didim.weights is not None
    assert turned.preferred.physical[:3] == pytest.approx(didim.physical[:3], rel=1e-9)
    assert turned.preferred.physical[3:] == pytest.approx(didim.physical[:2:-1], rel=1e-9)
    for name, value in didim.parameters.items():
        assert value.deviation < 1.05 * found["idm-iv"].parameters[name].deviation
    assert statuses(found)["method"] == "pass"
    assert "fail" not in statuses(turned).values()


@pytest.mark.slow
def test_a_second_record_is_estimated_anew_by_its_own_loops_rows(
    emps2015: GeneratedAxis, alone: Identification
) -> None:
    other = twin_record(emps2015, seed=7)
    held = validate(alone, other)["didim"]
    assert held.holds
    assert held.equation_error_percent == held.simulation_error_percent
    own = identify(emps2015, other, methods="didim")["didim"]
    assert [*held.reestimate.own.values()] == pytest.approx(own.corrected, rel=1e-9)


SAMPLES = 5000


def shaken(name: str, amplitude: float, seed: int, *, noisy: bool) -> tuple[GeneratedAxis, Record]:
    """An axis of the library under a white reference, in parts of its own travel."""
    axis = build(load_axis(name))
    experiment, law = axis.axis.experiment, axis.axis.control
    truth = [experiment.truth.get(p.name, p.nominal) for p in axis.axis.parameters]
    travel = float(np.ptp(twin_record(axis, position_noise=0.0).position))
    rng = np.random.default_rng(seed)
    reference = rng.normal(0.0, amplitude * travel, SAMPLES)
    noise = rng.normal(0.0, experiment.position_noise, SAMPLES) if noisy else None
    loop = simulate(axis, truth, reference, law.period, position_noise=noise)
    record = Record(
        time=loop.time,
        position=loop.measured_position,
        reference=reference,
        control=loop.control,
    )
    return axis, record


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "amplitude", "seed", "noisy"),
    [
        ("emps2015", 1e-3, 1, False),
        ("rotary_table", 1e-2, 1, False),
        ("linear_motor", 1e-3, 1, True),
        ("belt_axis", 1e-3, 0, True),
        ("crank", 1e-2, 0, False),
    ],
)
def test_a_white_reference_lets_the_instruments_end(
    name: str, amplitude: float, seed: int, noisy: bool
) -> None:
    axis, record = shaken(name, amplitude, seed, noisy=noisy)
    estimate = identify(axis, record, methods="idm-iv")["idm-iv"]
    last, before = (estimate.iterates[k].physical for k in (-1, -2))
    moved = np.abs(last - before) / np.sqrt(np.diag(estimate.covariances["iid"]))
    assert moved.max() <= 2 * CONVERGED.value
    assert not any("jumps with the parameters" in remark for remark in estimate.remarks)


def test_a_loop_that_jumps_ends_near_and_says_so() -> None:
    axis, record = shaken("rotary_table", 1e-2, 1, noisy=True)
    estimate = identify(axis, record, methods="idm-iv")["idm-iv"]
    (told,) = (r for r in estimate.remarks if "jumps with the parameters" in r)
    assert float(told.split(" standard errors")[0].split()[-1]) <= NEARLY_CONVERGED


@pytest.mark.slow
def test_estimates_without_inertia_fail_the_simulation(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Least squares needs no simulation, and yet says that there can be none."""
    turned = replace(twin, control=-twin.control)
    result = identify(emps2015, turned, methods="idm-ls")
    found = finding_of(checks_of(result)["simulation"], LoopNotSimulated)
    assert "no positive inertia" in found.reason
    with refuses("simulation", says="no positive inertia"):
        identify(emps2015, turned, methods="idm-iv")


_STIFF = NotSimulated("it is too stiff.", by_estimate=True)


@pytest.mark.parametrize(
    ("percent", "rest", "reproduces"),
    [(2.0, 0.0, True), (46.0, 0.0, True), (60.0, 0.0, False), (300.0, 0.6, False)],
)
def test_how_closely_the_loop_follows_is_reported_and_rests_that_prevent_it(
    result: Identification, percent: float, rest: float, reproduces: bool
) -> None:
    estimate = replace(result["idm-ls"], simulation_error_percent=percent)
    check = simulation_error_check(estimate, rest)
    found = finding_of(check, SimulatedLoop)
    assert check.status == ("pass" if reproduces else "fail")
    assert (found.percent, found.left) == (percent, "force")
    assert found.reproduces is reproduces
    assert (found.rest.percent if found.rest else 0.0) == pytest.approx(100 * rest)


@pytest.mark.parametrize("misspecified", [False, True])
def test_an_estimate_that_cannot_be_simulated_fails_with_the_reason(
    result: Identification, misspecified: bool
) -> None:
    estimate = replace(result["idm-ls"], simulated=_STIFF, simulation_error_percent=None)
    check = simulation_error_check(estimate, 0.0, misspecified=misspecified)
    assert check.status == "fail"
    assert finding_of(check, LoopNotSimulated) == LoopNotSimulated(
        reason="it is too stiff", is_misspecified=misspecified
    )


def test_a_loop_that_no_law_makes_is_no_objection(result: Identification) -> None:
    untried = replace(
        result["idm-ls"].with_inference(noise_free=None),
        simulated=NotSimulated("it has no law"),
        simulation_error_percent=None,
    )
    assert simulation_error_check(untried, 0.0) == untried.simulated


IV = ["idm-iv", "ddm-iv"]
STARTS = ("least-squares", "nominal")


@pytest.mark.slow
def test_instruments_start_at_least_squares_and_end_where_the_published_start_does(
    library_axis: GeneratedAxis,
) -> None:
    record = twin_record(library_axis)
    found = {start: identify(library_axis, record, start=start) for start in STARTS}
    for method in (method for method in IV if method in found["nominal"]):
        here, there = (found[start][method] for start in STARTS)
        deviations = np.sqrt(np.diag(here.covariance))
        assert np.abs(here.physical - there.physical).max() <= 1e-4 * deviations.max()
        assert here.started == "least-squares"
        assert here.iterates[0].physical == pytest.approx(found["nominal"]["idm-ls"].physical)
        assert len(here.iterates) <= len(there.iterates)
        if library_axis.is_linear:
            assert there.started == "nominal"
            assert there.iterates[0].physical.tolist() == library_axis.nominal.tolist()


def test_least_squares_whose_loop_does_not_follow_is_no_start_and_it_is_said(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Noise of 0.2 mm leaves least squares a tenth of the mass."""
    rng = np.random.default_rng(3)
    noisy = replace(twin, position=twin.position + rng.normal(0.0, 2e-4, len(twin)))
    result = identify(emps2015, noisy)
    for method in IV:
        estimate = result[method]
        assert estimate.started == "nominal"
        assert estimate.iterates[0].physical.tolist() == emps2015.nominal.tolist()
        (said,) = [str(r) for r in estimate.remarks if "starts from the nominal values" in str(r)]
        assert "least squares" in said
    assert result["ddm-iv"].physical == pytest.approx(result["idm-iv"].physical, rel=1e-6)


def test_the_nominal_values_serve_where_least_squares_leads_to_no_end() -> None:
    """A white reference: from least squares the first iterate's loop diverges."""
    axis, record = shaken("belt_axis", 1e-3, 0, noisy=True)
    found, usual = (
        identify(axis, record, methods=["idm-iv"], start=start)["idm-iv"] for start in STARTS
    )
    assert found.started == "nominal"
    assert "starts from the nominal values" in str(found.remarks[0])
    assert found.physical.tolist() == usual.physical.tolist()
