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
from axisid.estimation.diagnostics.remainder.near_reversals import (
    NearReversals,
    near_reversals_check,
)

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


@pytest.mark.slow
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
    result = identify(leave_out(real, "Fs"), record, LEFT_OUT, ["idm-iv"])
    check = check_of(result)
    assert check.status == "note"  # it counts once, as the term that is missing
    assert "near reversals and rests" in check.meaning
    assert [c.name for c in result.verdict if c.status == "fail"] == ["missing terms"]


def test_what_nothing_else_names_is_a_failure() -> None:
    found = NearReversals(near=4.8, elsewhere=2.0, force=30.0, rows=40)
    alone, named = (near_reversals_check(found, "N", explained=e) for e in (False, True))
    assert isinstance(alone, Check)
    assert isinstance(named, Check)
    assert (alone.status, named.status) == ("fail", "note")
    assert "Stribeck" in alone.meaning
    assert "what fails besides may make it" in named.meaning


def test_a_delay_that_alignment_tells_of_is_named_before_friction() -> None:
    found = NearReversals(near=4.8, elsewhere=2.0, force=30.0, rows=40)
    late = near_reversals_check(found, "N", late=True)
    assert isinstance(late, Check)
    assert late.status == "note"
    assert "Stribeck" not in late.meaning
    assert "the delay that alignment tells of may make it; mend that first" in late.meaning


def test_nothing_is_said_where_nothing_was_left_out() -> None:
    axis = load_axis("emps2015")
    result = identify(axis, twin_record(axis), Prefilter(reversals="keep"), ["idm-iv"])
    assert "near reversals" not in [check.name for check in result.verdict]
