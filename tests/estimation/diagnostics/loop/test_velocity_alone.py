"""A velocity without a position is held against the loop, which follows the reference."""

import re
from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, identify, load_axis, twin_record
from axisid.estimation.checks.check import Check


def _alone(name: str, factor: float = 1.0, offset: float = 0.0) -> Record:
    record = twin_record(build(load_axis(name)), velocity_noise=1e-4)
    velocity = factor * np.asarray(record.velocity) + offset
    return replace(record, position=np.empty(0), velocity=velocity)


def _check(name: str, record: Record) -> Check:
    result = identify(build(load_axis(name)), record, methods=["idm-ls"])
    (found,) = (c for c in result.verdict if c.name == "measured velocity")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps", "belt_axis"])
def test_a_right_one_passes(name: str) -> None:
    found = _check(name, _alone(name))
    assert found.status == "pass"
    assert "that of the simulated loop, which follows the reference" in found.meaning


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps", "belt_axis"])
@pytest.mark.parametrize("factor", [1.05, 0.98])
def test_a_wrong_scale_is_told(name: str, factor: float) -> None:
    found = _check(name, _alone(name, factor))
    assert found.status == "fail"
    told = re.search(r"the measured velocity is (\S+) ", found.meaning)
    assert float(told[1]) == pytest.approx(factor, abs=1e-3)
    assert "and those of the reference" in found.meaning


@pytest.mark.slow
def test_a_wrong_zero_is_told() -> None:
    assert _check("emps", _alone("emps", offset=0.01)).status == "fail"
