"""A drive's lag and delay, and what a command passes on its way: what contradicts them."""

from dataclasses import replace
from typing import Any

import pytest

from axisid import Axis, ModelError
from axisid.control import cascade_pd
from axisid.elements import Drive
from axisid.modeling.declaration import CommandPath
from tests.axes.lagging import PERIOD, Fc, Fv, M, lagging
from tests.refusals import refused, refuses


def test_a_delay_is_whole_samples_and_a_part_of_one() -> None:
    response = Drive(gain=1.0, delay=2.35e-3).response(1e-3)
    assert (response.whole, round(response.share, 9), response.late) == (2, 0.35, 3)
    assert not response.is_held
    whole = Drive(gain=1.0, delay=3 * 0.1e-3).response(0.1e-3)  # 3 but for rounding
    assert (whole.whole, whole.share, whole.late, whole.is_held) == (3, 0.0, 3, True)


def test_a_drive_without_lag_and_delay_responds_at_once() -> None:
    plain = lagging()
    assert plain.response is None
    assert plain.holds_force
    assert lagging(delay=PERIOD).holds_force
    assert not lagging(lag=PERIOD).holds_force
    assert replace(lagging(lag=PERIOD), control=None).response is None


test_a_time_a_place_and_a_path_that_contradict_are_refused = refused(
    (code, "", lambda given=given: Drive(gain=1.0, **given))
    for given, code in [
        ({"lag": -1e-3}, "drive"),
        ({"delay": -1e-3}, "drive"),
        ({"logged": "measured"}, "drive"),
        ({"logged": "applied"}, "drive"),
        ({"logged": "applied", "lag": 1e-3}, "drive"),
        ({"logged": "current", "delay": 1e-3}, "drive"),
        ({"rate_limit": 0.0}, "drive"),
        ({"rate_limit": -1.0}, "drive"),
        ({"deadband": -0.1}, "drive"),
        ({"quantisation": -0.1}, "drive"),
        ({"quantisation": 1e-309}, "drive"),
        ({"quantisation": 1e-309, "limit": 10.0}, "drive"),
        ({"deadband": float("inf")}, "axis"),
        ({"deadband": "0.1"}, "axis"),
        ({"limit": 1.0, "deadband": 1.0}, "drive"),
        ({"limit": 1.0, "quantisation": 2.5}, "drive"),
        ({"limit": 1.0, "quantisation": 0.6, "deadband": 0.7, "logged": "current"}, "drive"),
    ]
)


def _changed(axis: Axis, **control: Any) -> Axis:
    return replace(axis, control=replace(axis.control, **control))


def test_a_law_that_contradicts_the_drive_is_refused() -> None:
    with refuses("drive"):
        _changed(lagging(delay=1e-3), delay=1)
    assert _changed(lagging(lag=1e-3), delay=1).response is not None
    with refuses("drive"):
        lagging(delay=0.5)


@pytest.mark.parametrize("name", ["force_now", "force_of_command1", "force_target"])
def test_a_name_that_generated_code_gives_to_the_drives_forces_is_refused(name: str) -> None:
    plain, late = lagging(), lagging(lag=1e-3)
    named = {"parameters": (M, replace(Fv, name=name), Fc)}
    force = plain.force.xreplace({Fv.symbol: replace(Fv, name=name).symbol})
    assert replace(plain, force=force, experiment=None, **named).parameters[1].name == name
    with pytest.raises(ModelError, match=name):
        replace(late, force=force, experiment=None, **named)


PATH: dict[str, float] = {"rate_limit": 300.0, "quantisation": 0.05, "deadband": 0.3}


def test_a_continuous_law_has_no_samples_for_it() -> None:
    continuous = cascade_pd(kp=1.0, kv=1.0, period=PERIOD, continuous=True)
    for name, value in {"lag and delay": 1e-3, **PATH}.items():
        with refuses("drive", name):
            replace(lagging(**dict.fromkeys(name.split(" and "), value)), control=continuous)


def test_what_acts_in_the_end_and_which_command_it_was() -> None:
    path = CommandPath(quantisation=0.25, deadband=0.5)
    commands = (-1.1, -0.4, 0.0, 0.375, 0.874, 2.0)
    assert [path.end(u) for u in commands] == [-0.5, 0.0, 0.0, 0.0, 0.25, 1.5]
    assert [path.command(a) for a in (-0.5, 0.0, 0.25)] == [-1.0, 0.0, 0.75]
    drive = Drive(gain=2.0, deadband=0.5, delay=1e-3, lag=2e-3, logged="applied")
    assert drive.behind_path() == Drive(gain=2.0, lag=2e-3)
