"""DIDIM: on the EMPS record, on twins with known truth, and through all that serves a method."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    read_record,
    twin_record,
    validate,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.control import cascade_pd_difference
from benchmarks.machines import Machine, records, white
from tests.axes.stage import generated, stage_record

#: The paper's, of the published record.
PUBLISHED = Prefilter(cutoff=100.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")


@pytest.fixture(scope="module")
def alone(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, methods="didim")


def checks_of(result: Identification) -> dict[str, str]:
    return {check.name: check.status for check in result.verdict}


@pytest.mark.slow
def test_emps_lands_on_the_instruments_without_the_filters_bias(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    """With no correction of its own: measured and simulated force pass the same filter."""
    result = identify(emps, emps_record, PUBLISHED, ["idm-iv", "didim"])
    didim, iv = result["didim"], result["idm-iv"]
    assert [f"{value:.4g}" for value in didim.physical] == ["94.89", "208.3", "20.04", "-3.17"]
    assert didim.simulation_error_percent == pytest.approx(4.514, abs=0.005)
    deviations = np.array([value.deviation for value in didim.parameters.values()])
    assert np.all(np.abs(didim.corrected - iv.corrected) < 0.3 * deviations)
    assert checks_of(result)["method"] == "pass"


@pytest.mark.parametrize("mass", [5.0, 100.0, 400.0, 1000.0])
def test_emps_ends_at_the_same_from_any_mass(
    emps: GeneratedAxis, emps_record: Record, mass: float
) -> None:
    first = [replace(p, nominal=mass) if p.name == "M" else p for p in emps.axis.parameters]
    started = build(replace(emps.axis, parameters=tuple(first)))
    found = identify(started, emps_record, PUBLISHED, "didim", start="nominal")["didim"]
    assert found.started == "nominal"
    assert found.iterates[0].physical[0] == mass
    assert found.physical == pytest.approx([94.8896, 208.2889, 20.03959, -3.169823], rel=2e-5)


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
        assert checks_of(result)["missing terms"] == "pass"
    assert missed >= 3


@pytest.mark.slow
def test_alone_every_check_is_of_the_loops_rows(
    emps2015: GeneratedAxis, alone: Identification
) -> None:
    assert "fail" not in checks_of(alone).values()
    assert "method" not in checks_of(alone)
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
    own = found.local["tau0"]
    assert [v.value for v in own] == pytest.approx([3.0, -2.0], abs=0.3)
    assert didim.weights is not None
    assert turned.preferred.physical[:3] == pytest.approx(didim.physical[:3], rel=1e-9)
    assert turned.preferred.physical[3:] == pytest.approx(didim.physical[:2:-1], rel=1e-9)
    for name, value in didim.parameters.items():
        assert value.deviation < 1.05 * found["idm-iv"].parameters[name].deviation
    assert checks_of(found)["method"] == "pass"
    judged = identify(axis, records, methods="didim", local="tau0")
    assert "fail" not in checks_of(judged).values()


def test_a_second_record_is_estimated_anew_by_its_own_loops_rows(
    emps2015: GeneratedAxis, alone: Identification
) -> None:
    other = twin_record(emps2015, seed=7)
    held = validate(alone, other)["didim"]
    assert held.holds
    assert held.equation_error_percent == held.simulation_error_percent
    own = identify(emps2015, other, methods="didim")["didim"]
    assert held.reestimate.apart.own == pytest.approx(own.corrected, rel=1e-9)
