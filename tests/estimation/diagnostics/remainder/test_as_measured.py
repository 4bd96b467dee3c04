"""A velocity in steps leaves what loops with such steps leave: heavy tails without an outlier."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Identification, build, identify, load_axis, twin_record
from axisid.estimation.diagnostics.remainder import tails_as_measured


def _identified(name: str, spikes: int = 0) -> Identification:
    """The twin with a measured velocity in steps of 2 % of its size, and single samples far off."""
    axis = build(load_axis(name))
    record = twin_record(axis, velocity_noise=0.0)
    exact = np.asarray(record.velocity)
    step = 0.02 * float(np.sqrt(np.mean(exact**2)))
    coarse = step * np.round(exact / step)
    coarse[3000 : 3000 + 500 * spikes : 500] += 40 * step
    return identify(axis, replace(record, velocity=coarse), methods=["idm-iv"])


def _status(result: Identification, name: str) -> tuple[str, str]:
    (check,) = (c for c in result.verdict if c.name == name)
    return check.status, str(check.note)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["emps", pytest.param("pendulum", marks=pytest.mark.slow), "rotary_table"]
)
def test_a_right_log_with_a_coarse_velocity_passes(name: str) -> None:
    result = _identified(name)
    status, said = _status(result, "normal residuals")
    assert status != "fail"
    if name != "rotary_table":
        assert "as those of loops that are measured in such steps" in said
        own = np.mean(result.preferred.residuals**4)
        assert own < 1.2 * tails_as_measured(result.problem, result.preferred)[0]


@pytest.mark.slow
def test_spikes_are_still_found_out() -> None:
    status, said = _status(_identified("emps", spikes=3), "normal residuals")
    assert status == "fail"
    assert "look for outliers" in said


@pytest.mark.slow
def test_a_log_without_a_reference_is_held_against_loops_that_follow_it() -> None:
    axis = build(load_axis("emps"))
    result = identify(axis, replace(twin_record(axis), reference=None), methods=["idm-ls"])
    estimate = result.preferred
    ratio = np.mean(estimate.residuals**4) / tails_as_measured(result.problem, estimate)[0]
    assert ratio == pytest.approx(1.0, abs=0.3)
