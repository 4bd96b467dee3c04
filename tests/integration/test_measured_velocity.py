"""Logs with a measured velocity, and with nothing else of the motion, from file to result."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Identification,
    Record,
    build,
    identify,
    load_axis,
    twin_record,
    validate,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.law_replay import loop_starts
from tests.refusals import refuses

SIZE = 0.08  # m/s, of the velocity


@pytest.fixture(scope="module")
def record(emps: GeneratedAxis) -> Record:
    return twin_record(emps, velocity_noise=0.002 * SIZE)


def misses(result: Identification, record: Record, method: str = "idm-iv") -> list[str]:
    truth = record.provenance.truth or {}
    return [
        name
        for name, value in result[method].parameters.items()
        if not value.interval[0] <= truth[name] <= value.interval[1]
    ]


@pytest.mark.slow
def test_instruments_hold_the_truth_whatever_the_noise(emps: GeneratedAxis) -> None:
    missed = []
    for seed in range(8):
        noisy = twin_record(emps, seed=seed, velocity_noise=0.02 * SIZE)
        missed += misses(identify(emps, noisy, methods="idm-iv"), noisy)
    assert len(missed) <= 2, "of 32 intervals, each of 95 %"


def test_the_measured_velocity_takes_the_derivatives_place(
    emps: GeneratedAxis, record: Record
) -> None:
    data = identify(emps, record, methods="idm-ls").data
    low_passed = data.sampling.filter.low_passed(np.asarray(record.velocity))
    assert np.array_equal(data.motion[1], low_passed)
    assert np.array_equal(data.motion[2], np.gradient(low_passed, record.period))
    measured = replace(record, acceleration=np.gradient(np.asarray(record.velocity), 1e-3))
    acceleration = identify(emps, measured, methods="idm-ls").data.motion[2]
    inside = slice(100, -100)
    assert acceleration[inside] == pytest.approx(data.motion[2][inside], abs=2e-3)


@pytest.mark.slow
def test_an_accelerometer_serves(emps: GeneratedAxis) -> None:
    sensed = twin_record(emps, velocity_noise=1e-4, acceleration_noise=0.02)
    result = identify(emps, sensed)
    assert not misses(result, sensed)
    statuses = {check.name: check.status for check in result.verdict}
    assert statuses["measured acceleration"] == statuses["measured velocity"] == "pass"


@pytest.mark.slow
def test_the_noise_of_a_velocity_is_taken_off_where_there_is_no_reference(
    emps: GeneratedAxis,
) -> None:
    noisy = replace(twin_record(emps, seed=2, velocity_noise=0.01 * SIZE), reference=None)
    mass = identify(emps, noisy, methods="idm-ls")["idm-ls"].parameters["M"]
    true = (noisy.provenance.truth or {})["M"]
    assert mass.value < 0.993 * true
    assert mass.interval[0] < true < mass.interval[1]


class TestVelocityAlone:
    @pytest.mark.slow
    def test_it_identifies_an_axis_that_does_without_its_position(
        self, emps: GeneratedAxis, record: Record
    ) -> None:
        with_position = identify(emps, record)
        result = identify(emps, replace(record, position=np.empty(0)))
        assert len(misses(result, record)) <= 1, "of 4 intervals, each of 95 %"
        for method, estimate in with_position.estimates.items():
            alone = result[method].physical
            assert alone == pytest.approx(estimate.physical, rel=1e-3), method
        statuses = {check.name: check.status for check in result.verdict}
        assert statuses["control law"] == "not evaluated"
        assert statuses["measured velocity"] == "pass"  # by the loop that follows the reference
        assert "fail" not in statuses.values()

    def test_an_axis_that_needs_its_position_is_refused(
        self,
    ) -> None:
        pendulum = build(load_axis("pendulum"))
        swung = twin_record(pendulum, velocity_noise=0.0)
        with refuses("missing-column", "mx of axis 'pendulum' depends"):
            identify(pendulum, replace(swung, position=np.empty(0)))

    @pytest.mark.parametrize("begins", [0.0, 0.7, 1.06])
    def test_its_loop_begins_where_the_first_controls_say(
        self, emps: GeneratedAxis, record: Record, begins: float
    ) -> None:
        whole = record.windowed((begins, 6.0))
        (there,) = loop_starts(emps, whole)
        (alone,) = loop_starts(emps, replace(whole, position=np.empty(0)))
        assert alone.position == pytest.approx(there.position, abs=2e-5)
        assert alone.velocity == pytest.approx(there.velocity, abs=2e-3)


@pytest.mark.slow
def test_a_tachometers_ripple_is_no_delay_of_the_force(emps: GeneratedAxis) -> None:
    record = twin_record(emps, seed=4, velocity_noise=1e-4)
    ripple = 1 + 0.01 * np.sin(2 * np.pi * record.position / 0.003 + 1.0)
    rippled = replace(record, velocity=ripple * np.asarray(record.velocity))
    checks = {check.name: check for check in identify(emps, rippled, methods="idm-iv").verdict}
    assert checks["alignment"].status != "fail"
    assert checks["measured velocity"].status == "pass"


@pytest.mark.slow
def test_a_record_of_velocity_alone_validates_without_a_position_error(
    emps: GeneratedAxis, record: Record
) -> None:
    alone = replace(twin_record(emps, seed=5, velocity_noise=0.002 * SIZE), position=np.empty(0))
    held = validate(identify(emps, record, methods="idm-iv"), alone)
    assert all(each.holds for each in held)
    assert all(each.position_error_rms is None for each in held)
    assert all(each.simulation_error_percent is not None for each in held)
