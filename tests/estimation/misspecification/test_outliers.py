"""Single samples that leave their course are named by signal, sample and size; right logs none."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, identify, load_axis, twin_record
from axisid.estimation.checks import Check


def _coarse(name: str, spikes: int = 0) -> Record:
    """The twin with a measured velocity in steps of 2 % of its size, and single samples far off."""
    record = twin_record(build(load_axis(name)), velocity_noise=0.0)
    exact = np.asarray(record.velocity)
    step = 0.02 * float(np.sqrt(np.mean(exact**2)))
    coarse = step * np.round(exact / step)
    coarse[3000 : 3000 + 500 * spikes : 500] += 40 * step
    return replace(record, velocity=coarse)


def _outliers(name: str, record: Record, **options: str) -> Check:
    result = identify(build(load_axis(name)), record, methods=["idm-iv"], **options)
    (check,) = (c for c in result.verdict if c.name == "outliers")
    return check


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps", "pendulum", "rotary_table"])
def test_a_right_log_with_a_coarse_velocity_has_none(name: str) -> None:
    assert _outliers(name, _coarse(name)).status == "pass"


@pytest.mark.slow
def test_several_are_named_with_their_sample_and_no_more_than_a_note_with_a_bounded_loss() -> None:
    record = _coarse("emps", spikes=3)
    check = _outliers("emps", record)
    assert check.status == "fail"
    for sample in (3001, 3501, 4001):
        assert f"at sample {sample}, " in check.meaning
    assert _outliers("emps", record, loss="huber").status != "fail"
