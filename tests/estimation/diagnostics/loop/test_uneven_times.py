"""Jitter is told with what it does to the estimate, and whose it is: samples' or stamps'."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from axisid import Identification, Record, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.checks import Check


def with_jitter(twin: Record, share: float, *, sampled: bool, seed: int = 1) -> Record:
    """A twin whose stamps are off by up to a share of its period, and its samples with them."""
    rng = np.random.default_rng(seed)
    time = twin.time + rng.uniform(-share, share, len(twin)) * twin.period
    position = CubicSpline(twin.time, twin.position)(time) if sampled else twin.position
    return replace(twin, time=time, position=position, sample_period=None)


def check_of(result: Identification) -> Check | None:
    return next((c for c in result.verdict if c.name == "uneven times"), None)


def error_of(result: Identification, name: str) -> float:
    truth = result.record.provenance.truth[name]
    return 100 * (result.preferred.parameters[name].value / truth - 1)


@pytest.mark.parametrize("share", [0.0, 0.01])
def test_nothing_is_said_of_times_that_are_even_to_a_hundredth(
    emps2015: GeneratedAxis, twin: Record, share: float
) -> None:
    record = with_jitter(twin, share, sampled=True)
    assert check_of(identify(emps2015, record, methods=["idm-ls"])) is None


def test_jitter_that_biases_least_squares_fails_by_as_much_as_it_does(
    emps2015: GeneratedAxis,
) -> None:
    exact = twin_record(emps2015, position_noise=0.0)
    result = identify(emps2015, with_jitter(exact, 0.15, sampled=True), methods=["idm-ls"])
    check = check_of(result)
    assert check is not None
    assert check.status == "fail"
    assert error_of(result, "M") == pytest.approx(-1.2, abs=0.2)
    assert "M is +1.2 % (" in check.meaning
    assert "8.7 % of a period" in check.meaning
    assert "so that the stamps are when it was sampled" in check.meaning
    assert 'resample="auto"' in str(check.note)


def test_instruments_do_not_mind_jitter(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, with_jitter(twin, 0.15, sampled=True), methods=["idm-iv"])
    check = check_of(result)
    assert check is not None
    assert check.status == "pass"
    assert abs(error_of(result, "M")) < 0.1


@pytest.mark.parametrize("method", ["idm-ls", "idm-iv"])
@pytest.mark.parametrize("share", [0.05, 0.15])
def test_stamps_that_jitter_over_even_samples_are_no_fault(
    emps2015: GeneratedAxis, twin: Record, method: str, share: float
) -> None:
    result = identify(emps2015, with_jitter(twin, share, sampled=False), methods=[method])
    check = check_of(result)
    assert check is not None
    assert check.status == "pass"
    assert "rather the stamps are uneven than the sampling" in check.meaning


@pytest.mark.slow
def test_several_records_are_taken_together(emps2015: GeneratedAxis, twin: Record) -> None:
    records = [twin, with_jitter(twin_record(emps2015, seed=2), 0.1, sampled=True)]
    check = check_of(identify(emps2015, records, methods=["idm-iv"]))
    assert check is not None
    assert check.status == "pass"
