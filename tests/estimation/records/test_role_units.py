"""Units of columns: factors against closed forms, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest

from axisid import DataError, UsageError, load_axis, read_record
from axisid.estimation.records.role_units import modulus_si
from axisid.estimation.tables.unit_labels import known_unit, split_label, split_labels
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.declaration.drive import Drive
from axisid.modeling.declaration.newton import newton
from axisid.modeling.quantities.symbols import Coordinate, Parameter
from axisid.modeling.quantities.units import parse_unit

N = 20
TIME = np.arange(N) * 1e-3
VALUES = np.sin(np.arange(N))


@pytest.fixture(scope="module")
def rotary() -> Axis:
    q, J = Coordinate("q", unit="rad"), Parameter("J", "kg m^2", nominal=1.0)
    drive = Drive(gain=2.0, unit="A")
    return newton("motor", coordinate=q, parameters=(J,), inertia=J, resistance=(), drive=drive)


@pytest.mark.parametrize(
    ("text", "factor", "coherent"),
    [
        ("mm", 1e-3, "m"),
        ("um", 1e-6, "m"),
        ("\u00b5m", 1e-6, "m"),
        ("Millimeter", 1e-3, "m"),
        ("inch", 0.0254, "m"),
        ("deg", math.pi / 180, "rad"),
        ("\u00b0", math.pi / 180, "rad"),
        ("rev", 2 * math.pi, "rad"),
        ("arcsec", math.pi / 648000, "rad"),
        ("rpm", math.pi / 30, "rad/s"),
        ("ms", 1e-3, "s"),
        ("us", 1e-6, "s"),
        ("mA", 1e-3, "A"),
        ("mV", 1e-3, "V"),
        ("kN", 1e3, "N"),
        ("Ncm", 1e-2, "N m"),
        ("N\u00b7m", 1.0, "N m"),
        ("N*m", 1.0, "N m"),
        ("mN m", 1e-3, "N m"),
        ("m/s", 1.0, "m/s"),
    ],
)
def test_factors(text: str, factor: float, coherent: str) -> None:
    found = known_unit(text)
    assert found is not None
    assert found[0] == pytest.approx(factor, rel=1e-15)
    assert found[1].same_dimension(parse_unit(coherent))


def test_newton_metre_and_nanometre_are_told_apart() -> None:
    torque, length = known_unit("Nm"), known_unit("nm")
    assert torque is not None
    assert length is not None
    assert torque[0] == 1.0
    assert length[0] == 1e-9
    assert not torque[1].same_dimension(length[1])


def test_names_that_differ_by_their_units_only_stay_as_written() -> None:
    labels = ["t [s]", "angle [deg]", "angle [rad]"]
    assert split_labels(labels) == [("t", "s"), ("angle [deg]", "deg"), ("angle [rad]", "rad")]


@pytest.mark.parametrize("text", ["counts", "Hz", "NM", "MM", "", "deg/", "m m m m m m m" * 20])
def test_unknown_units_are_not_guessed(text: str) -> None:
    assert known_unit(text) is None


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("position [mm]", "position", "mm"),
        ("vel (rad/s)", "vel", "rad/s"),
        ("t / s", "t", "s"),
        ("q[1]", "q[1]", ""),
        ("axis/s", "axis/s", ""),
        ("torque (actual)", "torque (actual)", ""),
        ("position [inc]", "position", "inc"),
        ("position[%In]", "position", "%In"),
        ("position (Counts)", "position", "Counts"),
        ("slip [-]", "slip", ""),
        ("[mm]", "[mm]", ""),
    ],
)
def test_units_known_or_in_square_brackets_are_cut_from_a_name(
    label: str, name: str, unit: str
) -> None:
    assert split_label(label) == (name, unit)


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
    with pytest.raises(DataError, match="the position of axis 'motor' is measured in rad"):
        read_record(log, wrong)


def test_label_as_it_stands_in_the_file_names_the_column(rotary: Axis) -> None:
    log = {"time": TIME, "angle [deg]": VALUES}
    record = read_record(log, rotary, columns={"position": "angle [deg]"})
    assert record.position == pytest.approx(np.radians(VALUES))


def test_name_with_a_colon_needs_no_unit(rotary: Axis) -> None:
    log = {"time": TIME, "axis:deg": VALUES}
    record = read_record(log, rotary, columns={"position": "axis:deg"})
    assert np.array_equal(record.position, VALUES)


def test_no_unit_is_si_and_says_so(rotary: Axis) -> None:
    record = read_record({"time": TIME, "position": VALUES, "control": VALUES}, rotary)
    (note,) = record.provenance.assumed
    assert note == "no unit given, so SI: time s, position rad, control A"


def test_what_is_no_unit_in_parentheses_is_told(rotary: Axis) -> None:
    record = read_record({"time": TIME, "q (act)": VALUES}, rotary, columns={"position": "q (act)"})
    (note,) = record.provenance.assumed
    assert note == "no unit given, so SI: time s, position rad ('act' is no unit known)"


@pytest.mark.parametrize("name", ["angle", "angle [inc]"])
def test_unit_that_is_not_known_is_refused_by_any_name_of_its_column(
    rotary: Axis, name: str
) -> None:
    log = {"time": TIME, "angle [inc]": VALUES}
    with pytest.raises(DataError, match=r"unit 'inc', which is not known; encoder counts: scale"):
        read_record(log, rotary, columns={"position": name})
    record = read_record(log, rotary, columns={"position": f"{name}:mrad"})
    assert record.position == pytest.approx(1e-3 * VALUES)


def test_columns_whose_names_differ_by_the_unit_only_are_all_there(rotary: Axis) -> None:
    log = {"time": TIME, "angle [deg]": VALUES, "angle [rad]": 7 * VALUES}
    record = read_record(log, rotary, columns={"position": "angle [deg]"})
    assert record.position == pytest.approx(np.radians(VALUES))
    with pytest.raises(DataError, match=r"Did you mean 'angle \[deg\]' or 'angle \[rad\]'"):
        read_record(log, rotary, columns={"position": "angle"})


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"position": "q:mm"}, "the position of axis 'motor' is measured in rad"),
        ({"position": "q:Nm"}, "the position of axis 'motor' is measured in rad"),
        ({"position": "q:inc"}, "position has the unit 'inc', which is not known"),
        ({"position": "q", "control": "u:mV"}, "the control of axis 'motor' is measured in A"),
        ({"position": "q", "force": "u:N"}, "the force of axis 'motor' is measured in N m"),
        ({"position": "q", "time": "time:mm"}, "the time of axis 'motor' is measured in s"),
    ],
)
def test_unit_of_another_kind_is_refused(
    rotary: Axis, columns: dict[str, str], message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        read_record({"time": TIME, "q": VALUES, "u": VALUES}, rotary, columns=columns)


def test_unit_of_another_kind_in_the_file_is_a_data_error() -> None:
    log = {"t": TIME, "qm [deg]": VALUES, "qg": VALUES, "vir": VALUES}
    with pytest.raises(DataError, match="'deg', but the position of axis 'emps' is measured in m"):
        read_record(log, load_axis("emps"))


def test_modulus_has_a_unit_too(rotary: Axis) -> None:
    assert modulus_si("360:deg", rotary) == pytest.approx(2 * math.pi)
    assert modulus_si("6.5", None) == 6.5
    for text in ("0", "-1", "x", "inf", "1:mm"):
        with pytest.raises(UsageError):
            modulus_si(text, rotary)
