"""Bias and deviations by twins hold where single loops cannot tell them."""

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from axisid import (
    Prefilter,
    Record,
    build,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.signals import matching_decimation
from benchmarks.machines import Machine, white
from tests.refusals import refuses
from tests.unjudged import identify

field: Any = import_module("field")


def errors(case: Any, count: int, method: str, bootstrap: int) -> np.ndarray[Any, Any]:
    """Of corrected values, in their deviations, (records, parameters)."""
    found = []
    for record in case.records(count, 11):
        values = identify(case.axis, record, methods=method, bootstrap=bootstrap)[method]
        of = [(values[name], truth) for name, truth in case.truth.items()]
        found.append([(v.corrected - truth) / v.deviation for v, truth in of])
    return np.array(found)


NOISY = Machine(position_noise=white(5e-6))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "count", "method", "without", "left"),
    [
        (lambda: field.FIXED["PD, sampled with jitter of 5 %"], 3, "idm-iv", 8, 4),
        # Half of the simulated force; the control is the law's, and twins leave as much.
        (lambda: field.wrong(1)["sampled with jitter of 20 %; stage"], 2, "didim", 8, 4),
        (lambda: field.Case(machine=NOISY, declared=NOISY), 4, "idm-ls", 3, 3.5),
    ],
    ids=["jitter", "half of the force", "noise of the position"],
)
def test_what_noise_moves_is_known_and_taken_off(
    case: Any, count: int, method: str, without: float, left: float
) -> None:
    assert np.abs(errors(case(), count, method, 0)).max() > without
    assert np.abs(errors(case(), count, method, 32)).max() < left


@pytest.mark.slow
@pytest.mark.parametrize("delay", [5e-3, 2e-2])
def test_what_another_delay_leaves_of_the_force_is_no_noise(delay: float) -> None:
    axis = load_axis("emps2015")
    late = build(replace(axis, drive=replace(axis.drive, delay=delay)))
    estimate = identify(late, twin_record(build(axis)), methods="idm-ls")["idm-ls"]
    assert not estimate.inference.chains
    assert "does not follow" in estimate.covariance_notes["hac"].no_replicas


def test_jitter_of_the_log_alone_is_taken_off_least_squares(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """Its law measured the position at even times, and held each control as long."""
    time = twin.time + np.random.default_rng(1).uniform(-0.15, 0.15, len(twin)) * twin.period
    position = CubicSpline(twin.time, twin.position)(time)
    record = replace(twin, time=time, position=position, sample_period=None)
    found = identify(emps2015, record, methods="idm-ls")["idm-ls"]
    (chain,) = found.inference.chains
    assert not chain.is_measured_by_law
    assert chain.jitter == pytest.approx(0.3 / np.sqrt(12) * twin.period, rel=0.05)
    for name, value in found.parameters.items():
        assert abs(value.corrected - twin.provenance.truth[name]) < 3 * value.deviation
    assert abs(found["M"].filter_bias or 0.0) > 8 * found["M"].deviation


@pytest.mark.slow
def test_a_right_estimate_keeps_its_values_and_nearly_its_deviations(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    plain = identify(emps2015, twin, methods=["idm-iv", "ddm-iv"], bootstrap=0)
    made = identify(emps2015, twin, methods=["idm-iv", "ddm-iv"])
    for method in ("idm-iv", "ddm-iv"):
        for name in emps2015.names:
            one, other = plain[method][name], made[method][name]
            assert other.value == one.value
            assert other.sd == one.sd
            assert other.sd_robust == one.sd_robust
            assert 0.5 < other.deviation / one.deviation < 2
            assert one.filter_bias is None
            assert abs(other.corrected - one.value) < one.deviation
    (chain,) = made["idm-iv"].inference.chains
    assert chain.position == pytest.approx(3.8e-6, rel=0.05)
    assert plain["idm-iv"].inference.chains == ()


def test_a_measured_velocity_has_its_noise_in_the_chain(emps2015: GeneratedAxis) -> None:
    record = twin_record(emps2015, velocity_noise=1e-3)
    result = identify(emps2015, record, methods="idm-iv")["idm-iv"]
    assert result.inference.chains[0].velocity == pytest.approx(1e-3, rel=0.05)
    for name, value in result.parameters.items():
        low, high = value.interval
        assert low < record.provenance.truth[name] < high


@pytest.mark.parametrize("count", [-1, 3, 1.5, 10**6, "many", None, True])
def test_a_number_of_twins_that_is_none_is_refused(emps2015: GeneratedAxis, count: Any) -> None:
    with refuses("noise", says="simulated replicas"):
        identify(emps2015, twin_record(emps2015), methods="idm-ls", bootstrap=count)


METHODS = ["idm-ls", "idm-iv", "didim"]


@pytest.mark.slow
def test_what_several_parameters_make_together_is_as_sure_as_it_scatters(
    emps2015: GeneratedAxis,
) -> None:
    """Friction at 0.1 m/s: noise of the position moves viscous and Coulomb against each other."""
    found: dict[str, list[tuple[float, float]]] = {method: [] for method in METHODS}
    by = np.array([0.0, 0.1, 1.0])
    for seed in range(8):
        record = twin_record(emps2015, seed=seed, position_noise=3e-5)
        truth = np.array([*record.provenance.truth.values()])
        for method, estimate in identify(emps2015, record, methods=METHODS).estimates.items():
            away = float(by @ (estimate.corrected - truth))
            found[method].append((away, float(np.sqrt(by @ estimate.covariance @ by))))
    for of_method in found.values():
        away, told = np.transpose(of_method)
        assert 0.4 < np.mean(told) / np.sqrt(np.mean(away**2)) < 2.5


@pytest.mark.slow
def test_no_disturbance_is_simulated_that_is_not_there(emps2015: GeneratedAxis) -> None:
    for seed in range(4):
        record = twin_record(emps2015, seed=seed, position_noise=3e-5)
        (chain,) = identify(emps2015, record, methods="idm-iv").preferred.inference.chains
        assert not chain.likeliest.disturbances
        assert chain.likeliest.position == pytest.approx(3e-5, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("cutoff", [5.25, 6.9, 11.9])
def test_below_a_low_cutoff_noise_is_that_of_the_record(cutoff: float) -> None:
    """There all rows are near a turn, where steps alone look like a force beside the control."""
    machine = next(each for name, each in field.drawn(71, 6).items() if "joystick" in name)
    record = next(machine.records(1, 71))
    prefilter = Prefilter(cutoff=cutoff, decimate=matching_decimation(cutoff, record.period))
    estimate = identify(machine.axis, record, prefilter)["didim"]
    values = estimate.parameters.items()
    assert max(abs(v.corrected - machine.truth[n]) / v.deviation for n, v in values) < 5
