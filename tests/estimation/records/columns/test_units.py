"""Units of columns: factors against closed forms, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest

from axisid import UsageError, read_record
from axisid.estimation import Repairs
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.declaration.drive import Drive
from tests.axes.bodies import rotor
from tests.refusals import refuses

N = 20
TIME = np.arange(N) * 1e-3
VALUES = np.sin(np.arange(N))


@pytest.fixture(scope="module")
def rotary() -> Axis:
    return rotor(name="motor", drive=Drive(gain=2.0, unit="A"))


def test_units_come_from_the_user_over_those_of_the_file(rotary: Axis) -> None:
    log = {"time [us]": 1e6 * TIME, "angle [rad]": VALUES, "i": VALUES}
    record = read_record(log, rotary, columns={"position": "angle:deg", "control": "i:mA"})
    assert record.time == pytest.approx(TIME)
    assert record.position == pytest.approx(np.radians(VALUES))
    assert record.control == pytest.approx(1e-3 * VALUES)
    assert record.provenance.assumed == (
        "time: us -> s",
        "position: deg -> rad",
        "control: mA -> A",
    )


def test_units_come_from_the_axis_too(rotary: Axis) -> None:
    axis = replace(rotary, columns={"position": "enc:rev", "time": "clock:us"})
    log = {"clock": 1e6 * TIME, "enc": VALUES}
    record = read_record(log, axis)
    assert record.time == pytest.approx(TIME)
    assert record.position == pytest.approx(2 * math.pi * VALUES)
    wrong = replace(rotary, columns={"position": "enc:mm", "time": "clock:us"})
    with refuses("units", says="position of axis 'motor' is measured in rad"):
        read_record(log, wrong)


@pytest.mark.parametrize(
    ("name", "unit"), [("axis:deg", ""), ("q (act)", " ('act' is no unit known)")]
)
def test_a_name_with_what_may_be_a_unit_is_taken_whole(rotary: Axis, name: str, unit: str) -> None:
    record = read_record({"time": TIME, name: VALUES}, rotary, columns={"position": name})
    assert np.array_equal(record.position, VALUES)
    assert record.provenance.assumed == (f"no unit given, so SI: time s, position rad{unit}",)


@pytest.mark.parametrize("name", ["angle", "angle [inc]"])
def test_unit_that_is_not_known_is_refused_by_any_name_of_its_column(
    rotary: Axis, name: str
) -> None:
    log = {"time": TIME, "angle [inc]": VALUES}
    with refuses("units", says="'inc', which is not known; say what one"):
        read_record(log, rotary, columns={"position": name})
    record = read_record(log, rotary, columns={"position": f"{name}:mrad"})
    assert record.position == pytest.approx(1e-3 * VALUES)


@pytest.mark.parametrize(
    ("columns", "code", "says"),
    [
        ({"position": "q:mm"}, "units", "position of axis 'motor' is measured in rad"),
        ({"position": "q:Nm"}, "units", "position of axis 'motor' is measured in rad"),
        ({"position": "q:inc"}, "units", "position has the unit 'inc'"),
        (
            {"position": "q", "control": "u:mV"},
            "units",
            "control of axis 'motor' is measured in A",
        ),
        (
            {"position": "q", "force": "u:N"},
            "units",
            "force of axis 'motor' is measured in N m",
        ),
        (
            {"position": "q", "time": "time:mm"},
            "units",
            "time of axis 'motor' is measured in s",
        ),
    ],
)
def test_unit_of_another_kind_is_refused(
    rotary: Axis, columns: dict[str, str], code: str, says: str
) -> None:
    with refuses(code, says):
        read_record({"time": TIME, "q": VALUES, "u": VALUES}, rotary, columns=columns)


def modulus(text: str, axis: Axis | None) -> float:
    return Repairs(wrap=text).moduli(axis)["position"].si


def test_modulus_has_a_unit_too(rotary: Axis) -> None:
    assert modulus("360:deg", rotary) == pytest.approx(2 * math.pi)
    assert modulus("6.5", None) == 6.5
    for text in ("0", "-1", "x", "inf", "1:mm"):
        with pytest.raises(UsageError):
            modulus(text, rotary)
