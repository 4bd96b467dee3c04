"""A law is held against what it read of a log with jitter, resampled or not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from axisid import Record, build, identify, load_axis, read_record, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import Repairs
from axisid.estimation.diagnostics.law import check_law
from axisid.support.errors import Missing


@pytest.fixture(scope="module")
def emps() -> GeneratedAxis:
    return build(load_axis("emps"))


def log(axis: GeneratedAxis, share: float, *, sampled: bool, noise: float = 0.0) -> dict[str, Any]:
    """A twin whose stamps jitter, and its positions with them where they were sampled so."""
    twin = twin_record(axis)
    rng = np.random.default_rng(3)
    time = twin.time + share * twin.period * rng.normal(size=len(twin))
    columns = dict(twin.channels()) | {"time": time}
    if sampled:
        columns["position"] = CubicSpline(twin.time, twin.position)(time)
    columns["position"] = columns["position"] + noise * rng.normal(size=len(twin))
    return columns


def read(axis: GeneratedAxis, columns: dict[str, Any], *, resampled: bool) -> Record:
    repairs = Repairs(resample="auto") if resampled else None
    return read_record(columns, axis, columns={name: name for name in columns}, repairs=repairs)


@pytest.mark.parametrize("resampled", [False, True])
@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize("share", [0.01, 0.05])
def test_a_right_law_passes_whatever_of_a_log_jitters(
    emps: GeneratedAxis, share: float, sampled: bool, resampled: bool
) -> None:
    found = check_law(emps, read(emps, log(emps, share, sampled=sampled), resampled=resampled))
    assert found.passed, found.meaning


@pytest.mark.slow
@pytest.mark.parametrize("resampled", [False, True])
@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize("gain", ["kp", "kv"])
def test_a_wrong_gain_fails_whatever_of_a_log_jitters(
    emps: GeneratedAxis, gain: str, sampled: bool, resampled: bool
) -> None:
    law = emps.axis.control
    wrong = replace(law, gains={**law.gains, gain: 1.1 * law.gains[gain]})
    axis = build(replace(emps.axis, control=wrong))
    found = check_law(axis, read(emps, log(emps, 0.05, sampled=sampled), resampled=resampled))
    assert not found.passed
    assert f"{gain} is 0.909" in found.meaning


@pytest.mark.slow
@pytest.mark.parametrize("resampled", [False, True])
def test_noise_of_its_own_between_the_ticks_leaves_the_law_open(resampled: bool) -> None:
    axis = build(load_axis("pendulum"))
    quiet = twin_record(axis, position_noise=0.0)
    rng = np.random.default_rng(3)
    time = quiet.time + 0.05 * quiet.period * rng.normal(size=len(quiet))
    position = CubicSpline(quiet.time, quiet.position)(time)
    noise = 1e-5 * rng.normal(size=len(quiet))
    columns = dict(quiet.channels()) | {"time": time, "position": position + noise}
    found = check_law(axis, read(axis, columns, resampled=resampled))
    assert isinstance(found, Missing), found.meaning
    assert "leaves" in str(found)


@pytest.mark.slow
def test_stamps_of_few_digits_excuse_no_wrong_law(emps: GeneratedAxis) -> None:
    columns = log(emps, 0.0, sampled=False)
    rng = np.random.default_rng(1)
    columns["time"] = np.round(columns["time"] + 1e-7 * rng.normal(size=len(columns["time"])), 7)
    columns["control"] = 1.2 * columns["control"]
    found = check_law(emps, read(emps, columns, resampled=False))
    assert not found.passed


@pytest.mark.slow
def test_stamps_alone_that_jitter_need_no_resampling(emps: GeneratedAxis) -> None:
    record = read(emps, log(emps, 0.05, sampled=False), resampled=True)
    told = {c.name: c for c in identify(emps, record, methods=["idm-iv"]).verdict}["control law"]
    assert told.status == "note"
    assert "in the rows as they were sampled" in told.meaning
    assert "leave resample out" in told.meaning
