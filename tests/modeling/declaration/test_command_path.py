"""Rate limit, quantisation and dead band of a drive: what they say, and what contradicts them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from axisid import load_axis
from axisid.control import cascade_pd
from axisid.elements import Drive
from axisid.modeling.declaration import CommandPath
from tests.axes.lagging import PERIOD, lagging
from tests.refusals import refuses

PATH: dict[str, float] = {"rate_limit": 300.0, "quantisation": 0.05, "deadband": 0.3}


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"rate_limit": 0.0}, "drive-rate"),
        ({"rate_limit": -1.0}, "drive-rate"),
        ({"deadband": -0.1}, "drive-band"),
        ({"quantisation": -0.1}, "drive-band"),
        ({"quantisation": 1e-309}, "drive-step"),
        ({"quantisation": 1e-309, "limit": 10.0}, "drive-step"),
        ({"deadband": float("inf")}, "number-not-finite"),
        ({"deadband": "0.1"}, "not-a-number"),
        ({"limit": 1.0, "deadband": 1.0}, "drive-band-and-limit"),
        ({"limit": 1.0, "quantisation": 2.5}, "drive-band-and-limit"),
        ({"limit": 1.0, "quantisation": 0.6, "deadband": 0.7, "logged": "current"}, "no-drive-lag"),
    ],
)
def test_a_path_through_which_no_command_comes_is_refused(given: dict[str, Any], code: str) -> None:
    with refuses(code):
        Drive(gain=1.0, **given)


def test_a_continuous_law_has_no_samples_for_it() -> None:
    continuous = cascade_pd(kp=1.0, kv=1.0, period=PERIOD, continuous=True)
    for name, value in PATH.items():
        with refuses("drive-continuous", name):
            replace(lagging(**{name: value}), control=continuous)


def test_a_control_behind_the_dead_band_may_be_what_is_recorded() -> None:
    assert lagging(deadband=0.3, logged="applied").drive.logs_what_acts
    with refuses("no-drive-delay"):
        lagging(logged="applied")


def test_what_acts_in_the_end_and_which_command_it_was() -> None:
    path = CommandPath(quantisation=0.25, deadband=0.5)
    commands = (-1.1, -0.4, 0.0, 0.375, 0.874, 2.0)
    assert [path.end(u) for u in commands] == [-0.5, 0.0, 0.0, 0.0, 0.25, 1.5]
    assert [path.command(a) for a in (-0.5, 0.0, 0.25)] == [-1.0, 0.0, 0.75]
    drive = Drive(gain=2.0, deadband=0.5, delay=1e-3, lag=2e-3, logged="applied")
    assert drive.behind_path() == Drive(gain=2.0, lag=2e-3)


TOML = """
name = "valve"
coordinate = { name = "q", unit = "m" }
drive = { gain = 18.0, unit = "A", rate_limit = 200.0, quantisation = 0.01, deadband = 0.1 }
control = { law = "cascade_pd", kp = 50.0, kv = 60.0, period = 1e-3 }

[parameters]
M = { unit = "kg", nominal = 10 }

[newton]
inertia = "M"
resistance = []
"""


def test_toml_says_the_same(tmp_path: Path) -> None:
    file = tmp_path / "valve.toml"
    file.write_text(TOML)
    drive = load_axis(str(file)).drive
    assert drive.path == CommandPath(rate_limit=200.0, quantisation=0.01, deadband=0.1)
