"""The chain that is measured in a record is the one that it was made with."""

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from axisid import Identification, Prefilter, Record, build, identify, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.methods import METHODS
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.twins import Chain, measured_chain
from axisid.estimation.twins.chain import Draws
from axisid.estimation.twins.measured_chain import control_step, likeliest_variances
from axisid.estimation.twins.twins import twin_of
from axisid.support.arrays import Array
from benchmarks.machines import Machine, autoregressive, white

field: Any = import_module("field")


def chain_of(axis: Any, record: Record) -> Chain:
    """As it is measured at the output error of the force."""
    problem = identify(axis, record, methods="didim").problem
    fit = METHODS["didim"].fit(problem)
    return measured_chain(problem.data[0], fit.form.physical(fit.solution.theta)[0], fit.loops)


def test_variances_are_those_that_the_powers_are_made_of() -> None:
    bands = np.linspace(0.1, 3.0, 20)
    units = np.array([np.ones(20), 1 / (1 + bands**2), bands**2])
    truth, known = np.array([2.0, 5.0, 0.0]), 0.3 / bands
    found = likeliest_variances(truth @ units + known, units, known, np.full(20, 30.0))
    np.testing.assert_allclose(found @ units, truth @ units, rtol=0.03)
    np.testing.assert_allclose(found[:2], truth[:2], rtol=0.1)
    assert found[2] < 0.05


def test_nothing_is_measured_where_nothing_is() -> None:
    units = np.ones((2, 5))
    none = likeliest_variances(np.zeros(5), units, np.zeros(5), np.ones(5))
    np.testing.assert_array_equal(none, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("chain", "slack"),
    [
        (Chain(position=4e-6), 0.05),
        (Chain(position_step=5e-6), 0.05),
        (Chain(position=1.5e-6, position_step=5e-6), 0.05),
        (Chain(position=2e-6, jitter=6e-5), 0.1),
        (Chain(position_step=1e-6, disturbances=((0.0, 0.05),)), 0.15),
        (Chain(position_step=1e-6, disturbances=((0.03, 0.05),)), 0.3),
    ],
    ids=["noise", "steps", "dithered steps", "jitter", "white force", "coloured force"],
)
def test_the_chain_of_a_twin_is_its_chain(chain: Chain, slack: float) -> None:
    axis = build(load_axis("emps2015"))
    (plain,) = identify(axis, twin_record(axis), methods="didim").problem.data
    truth: Array = np.array([100.0, 237.0, 25.0])
    twin: FilteredRecord = twin_of(plain, truth, chain, Draws(np.random.default_rng(3)))
    found = chain_of(axis, twin.record)
    assert found.position_step == pytest.approx(chain.position_step, rel=1e-6)
    assert found.position == pytest.approx(chain.position, rel=slack, abs=3e-7)
    assert found.jitter == pytest.approx(chain.jitter, rel=slack, abs=3e-6)
    sizes = [np.sqrt(sum(sd**2 for _, sd in each.disturbances)) for each in (found, chain)]
    assert sizes[0] == pytest.approx(sizes[1], rel=slack, abs=0.03)


@pytest.mark.slow
def test_the_chain_of_a_machine_that_is_simulated_apart_is_measured() -> None:
    machine = Machine(
        position_noise=white(4e-6), force_noise=autoregressive(1.5, 0.1, 1e-3), clock_jitter=0.04
    )
    case = field.Case(machine=machine, declared=machine)
    (record,) = case.records(1, 7)
    found = chain_of(case.axis, record)
    assert found.position_step == 0
    assert found.position == pytest.approx(4e-6, rel=0.05)
    assert found.jitter == pytest.approx(4e-5, rel=0.1)
    slow = [(time, sd) for time, sd in found.disturbances if time >= 0.03]
    assert np.sqrt(sum(sd**2 for _, sd in slow)) * 35.15 == pytest.approx(1.5, rel=0.35)


def test_a_short_record_has_a_chain_too() -> None:
    axis = build(load_axis("emps2015"))
    record = twin_record(axis).windowed((0.3, 0.9))
    filtering = Prefilter(cutoff=60.0, decimate=4)
    result = identify(axis, record, filtering, "idm-ls", bootstrap=8)["idm-ls"]
    assert np.all(np.isfinite(np.sqrt(np.diag(result.covariance))))


def test_noise_of_the_position_that_is_not_white_has_no_chain() -> None:
    """All of it at half the sampling rate: rows behind a filter have nothing of it."""
    axis = build(load_axis("emps2015"))
    record = twin_record(axis)
    shaken = replace(record, position=record.position + 1e-4 * (-1.0) ** np.arange(len(record)))
    result = identify(axis, shaken, methods="didim")
    assert result["didim"].inference.chains == ()
    assert "not white" in result["didim"].covariance_names["hac"]
    for name, value in result["didim"].parameters.items():
        assert abs(value.corrected - record.provenance.truth[name]) < 3 * value.deviation


@pytest.fixture(scope="module")
def quiet(emps2015: GeneratedAxis) -> Record:
    """A sensor whose noise does not carry the control from one step to the next."""
    return twin_record(emps2015, position_noise=1e-8)


def _rounded(record: Record, bits: int) -> Record:
    control = np.asarray(record.control)
    step = float(np.ptp(control)) / 2**bits
    return replace(record, control=step * np.round(control / step))


def _deviations(result: Identification) -> Array:
    return np.array([value.deviation for value in result.preferred.parameters.values()])


def _apart(result: Identification, record: Record) -> Array:
    """From the truth, in deviations."""
    truth = record.provenance.truth
    values = result.preferred.parameters
    apart = np.array([value.corrected - truth[name] for name, value in values.items()])
    return np.abs(apart) / _deviations(result)


@pytest.mark.parametrize("bits", [6, 7, 14])
def test_deviations_hold_what_a_control_of_few_steps_moves(
    emps2015: GeneratedAxis, quiet: Record, bits: int
) -> None:
    result = identify(emps2015, _rounded(quiet, bits))
    assert _apart(result, quiet).max() < 2.5  # 3.3 and more by neighbouring rows alone
    (chain,) = result.preferred.inference.chains
    assert chain.control_step > 0


def test_noise_that_averages_the_steps_adds_nothing(emps2015: GeneratedAxis, twin: Record) -> None:
    fine, coarse = (
        identify(emps2015, each, methods="idm-iv") for each in (twin, _rounded(twin, 8))
    )
    assert _deviations(coarse) == pytest.approx(_deviations(fine), rel=0.3)


def test_a_relay_has_no_steps_that_round_anything(quiet: Record) -> None:
    control = np.asarray(quiet.control)
    assert not control_step(replace(quiet, control=np.sign(control)))
    assert control_step(_rounded(quiet, 6)) == pytest.approx(np.ptp(control) / 64)
