"""What the simulated loop makes of samples that were left out near reversals."""

from dataclasses import replace

import pytest

from axisid import (
    Identification,
    Parameter,
    Prefilter,
    identify,
    leave_out,
    load_axis,
    twin_record,
)
from axisid.elements import stribeck
from axisid.estimation.checks import Check

LEFT_OUT = Prefilter(reversals="leave-out")


def check_of(result: Identification) -> Check:
    return next(check for check in result.verdict if check.name == "near reversals")


@pytest.mark.parametrize("seed", range(3))
def test_on_a_right_model_the_loop_is_right_there_too(seed: int) -> None:
    axis = load_axis("emps2015")
    check = check_of(identify(axis, twin_record(axis, seed=seed), LEFT_OUT, ["idm-iv"]))
    assert check.status == "pass"
    assert check.figure is not None
    assert check.figure < 1.6


def test_a_peak_of_friction_that_is_left_out_with_the_reversals_is_told() -> None:
    axis = load_axis("emps2015")
    peak = Parameter("Fs", "N", nominal=10.0)
    force = axis.force + stribeck(peak, axis.coordinate, velocity=0.01)
    truth = {**dict(axis.experiment.truth), "Fs": 10.0} if axis.experiment else {}
    assert axis.experiment is not None
    real = replace(
        axis,
        parameters=(*axis.parameters, peak),
        force=force,
        experiment=replace(axis.experiment, truth=truth),
    )
    record = twin_record(real)
    check = check_of(identify(leave_out(real, "Fs"), record, LEFT_OUT, ["idm-iv"]))
    assert check.status == "fail"
    assert "near reversals and rests" in check.meaning


def test_nothing_is_said_where_nothing_was_left_out() -> None:
    axis = load_axis("emps2015")
    result = identify(axis, twin_record(axis), Prefilter(reversals="keep"), ["idm-iv"])
    assert "near reversals" not in [check.name for check in result.verdict]
