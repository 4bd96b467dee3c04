"""A control of few steps: deviations hold what these hide from neighbouring rows."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, Record, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.twins.measured_chain import control_step
from axisid.support.arrays import Array


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


@pytest.mark.parametrize("bits", [6, 7])
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
