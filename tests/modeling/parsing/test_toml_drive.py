"""The drive of a TOML declaration: by a gain, by figures of a motor, by formulas."""

from pathlib import Path

import pytest

from axisid import Axis, Parameter, load_axis
from axisid.elements import CONTROL, Drive, current_drive, voltage_drive
from tests.refusals import refuses

AXIS = """
name = "joint"
coordinate = {{ name = "q", unit = "rad" }}
drive = {{ {drive} }}

[parameters]
J = {{ unit = "kg m^2", nominal = 0.1 }}
fv = {{ unit = "N m/(rad/s)" }}

[constants]
kt = {{ value = 0.05, unit = "N m/A" }}
ohms = {{ value = 1.25, unit = "V/A" }}

[newton]
inertia = "J"
resistance = ["fv*dq"]
"""


def declared(folder: Path, drive: str) -> Axis:
    file = folder / "axis.toml"
    file.write_text(AXIS.format(drive=drive))
    return load_axis(file)


@pytest.mark.parametrize(
    ("text", "drive"),
    [
        (
            'kind = "voltage_drive", kt = 0.05, resistance = 1.25, ke = 0.05, ratio = 50, '
            'efficiency = 0.8, inductance = 1e-3, volts = 24, unit = "1", limit = 1',
            voltage_drive(
                kt=0.05,
                resistance=1.25,
                ke=0.05,
                ratio=50.0,
                efficiency=0.8,
                inductance=1e-3,
                volts=24.0,
                unit="1",
                limit=1.0,
            ),
        ),
        (
            'kind = "current_drive", kt = 0.05, supply = 24, resistance = 1.25, delay = 1e-3',
            current_drive(kt=0.05, supply=24.0, resistance=1.25, delay=1e-3),
        ),
        ("gain = 2.0", Drive(gain=2.0)),
        (
            "gain = 2.0, lag = { nominal = 5e-4 }",
            Drive(gain=2.0, lag=Parameter("lag", "s", nominal=5e-4)),
        ),
        (
            "gain = 18.0, lag = 8e-4, delay = 3.5e-4, logged = 'applied', rate_limit = 200.0, "
            "quantisation = 0.01, deadband = 0.1",
            Drive(
                gain=18.0,
                lag=8e-4,
                delay=3.5e-4,
                logged="applied",
                rate_limit=200.0,
                quantisation=0.01,
                deadband=0.1,
            ),
        ),
    ],
)
def test_a_drive_is_that_of_python(tmp_path: Path, text: str, drive: Drive) -> None:
    assert declared(tmp_path, text).drive == drive


def test_figures_may_be_constants_and_a_reach_an_expression(tmp_path: Path) -> None:
    axis = declared(tmp_path, 'kind = "voltage_drive", kt = "kt", resistance = "ohms", ratio = 50')
    assert axis.drive.gain == pytest.approx(2.0)
    limited = declared(tmp_path, 'kind = "current_drive", kt = "kt", reach = "min(8, 12 - 2*dq)"')
    force = limited.drive.force.subs({**limited.drive.constants, CONTROL: -1e3})
    assert float(force.subs(limited.coordinate.velocity, -5)) == -2.0


def test_formulas_are_read_with_the_motion_of_the_axis(tmp_path: Path) -> None:
    text = 'force = "drive_gain*control - 4*dq", inverse = "(tau + 4*dq)/drive_gain", gain = 3'
    axis = declared(tmp_path, text)
    q = axis.coordinate
    assert axis.drive.force.subs(axis.drive.constants) == 3.0 * CONTROL - 4 * q.velocity


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('kind = "voltage_driv", kt = 1', "voltage_drive"),
        ('kind = "voltage_drive", kt = 1', "drive.resistance: the key is missing"),
        (
            'kind = "voltage_drive", kt = 1, resistance = 1, gear = 3',
            "drive.gear: the key is unknown",
        ),
        (
            'kind = "voltage_drive", kt = 1, resistance = 1, gain = 3',
            "drive.gain: voltage_drive has",
        ),
        ('kind = "voltage_drive", kt = 1, resistance = 1, efficiency = 3', "efficiency is 3"),
        ('kind = "voltage_drive", kt = "x", resistance = 1', "kt"),
        ('force = "control - heat"', "drive.force"),
        ('force = "control**3"', "inverse"),
        ('force = "control", ratio = 3', "drive.ratio: the key is unknown"),
        ("gain = 2.0, ratio = 3", "drive.ratio: the key is unknown"),
    ],
)
def test_mistakes_are_told_with_their_place(tmp_path: Path, text: str, said: str) -> None:
    with refuses("declaration", said):
        declared(tmp_path, text)
