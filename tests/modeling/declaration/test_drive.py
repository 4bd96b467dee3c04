"""Lag and delay of a drive: what they come to in samples, and what contradicts them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from axisid import Axis, ModelError, load_axis
from axisid.control import cascade_pd
from axisid.elements import Drive
from axisid.modeling.declaration import Response
from tests.axes.lagging import PERIOD, Fc, Fv, M, lagging
from tests.refusals import refuses


def test_a_delay_is_whole_samples_and_a_part_of_one() -> None:
    response = Response.of(0.0, 2.35e-3, 1e-3)
    assert (response.whole, round(response.share, 9), response.late) == (2, 0.35, 3)
    assert not response.is_held
    whole = Response.of(0.0, 3 * 0.1e-3, 0.1e-3)  # 3 but for rounding
    assert (whole.whole, whole.share, whole.late, whole.is_held) == (3, 0.0, 3, True)


def test_a_drive_without_lag_and_delay_responds_at_once() -> None:
    plain = lagging()
    assert plain.response is None
    assert plain.holds_force
    assert lagging(delay=PERIOD).holds_force
    assert not lagging(lag=PERIOD).holds_force
    assert replace(lagging(lag=PERIOD), control=None).response is None


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"lag": -1e-3}, "drive-time"),
        ({"delay": -1e-3}, "drive-time"),
        ({"logged": "measured"}, "drive-logged"),
        ({"logged": "applied"}, "no-drive-delay"),
        ({"logged": "applied", "lag": 1e-3}, "no-drive-delay"),
        ({"logged": "current", "delay": 1e-3}, "no-drive-lag"),
    ],
)
def test_a_time_and_a_place_that_contradict_are_refused(given: dict[str, Any], code: str) -> None:
    with refuses(code):
        Drive(gain=1.0, **given)


def _changed(axis: Axis, **control: Any) -> Axis:
    return replace(axis, control=replace(axis.control, **control))


def test_a_law_that_contradicts_the_drive_is_refused() -> None:
    with refuses("delay-twice"):
        _changed(lagging(delay=1e-3), delay=1)
    assert _changed(lagging(lag=1e-3), delay=1).response is not None
    with refuses("drive-continuous", "lag and delay"):
        continuous = cascade_pd(kp=1.0, kv=1.0, period=PERIOD, continuous=True)
        replace(lagging(lag=1e-3, delay=1e-3), control=continuous)
    with refuses("drive-delay"):
        lagging(delay=0.5)


@pytest.mark.parametrize("name", ["force_now", "force_of_command1", "force_target"])
def test_a_name_that_generated_code_gives_to_the_drives_forces_is_refused(name: str) -> None:
    plain, late = lagging(), lagging(lag=1e-3)
    named = {"parameters": (M, replace(Fv, name=name), Fc)}
    force = plain.force.xreplace({Fv.symbol: replace(Fv, name=name).symbol})
    assert replace(plain, force=force, experiment=None, **named).parameters[1].name == name
    with pytest.raises(ModelError, match=name):
        replace(late, force=force, experiment=None, **named)


TOML = """
name = "late"
coordinate = { name = "q", unit = "m" }
drive = { gain = 18.0, unit = "A", lag = 0.8e-3, delay = 0.35e-3, logged = "applied" }
control = { law = "cascade_pd", kp = 50.0, kv = 60.0, period = 1e-3 }

[parameters]
M = { unit = "kg", nominal = 10 }

[newton]
inertia = "M"
resistance = []
"""


def test_toml_says_the_same(tmp_path: Path) -> None:
    file = tmp_path / "late.toml"
    file.write_text(TOML)
    drive = load_axis(str(file)).drive
    assert (drive.lag, drive.delay, drive.logged) == (0.8e-3, 0.35e-3, "applied")
