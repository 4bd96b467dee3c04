"""Units and scalings of columns: read exactly, and mistakes told in a sentence."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import (
    ModelError,
    load_axis,
    read_record,
    twin_record,
)
from axisid.estimation import Repairs
from axisid.estimation.records.columns.units import is_scaling, read_scaling
from axisid.modeling import LIBRARY, Column
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.declaration.drive import Drive
from tests.axes.bodies import rotor
from tests.refusals import refuses

TIME = 1e-3 * np.arange(200)
COUNTS = np.round(2000 * np.sin(20 * TIME)) + 17
VALUES = np.sin(20 * TIME)


def log(**changes: Any) -> dict[str, Any]:
    return {"time": TIME, "position": COUNTS, "control": np.cos(20 * TIME)} | changes


@pytest.mark.parametrize(
    ("text", "own", "factor", "offset"),
    [
        ("counts*360deg/4096/50", "", 2 * math.pi / (4096 * 50), 0.0),
        ("counts*360deg/4096/50+0.2deg", "", 2 * math.pi / 204800, math.pi / 900),
        ("360deg/4096", "", 2 * math.pi / 4096, 0.0),
        ("*360deg/4096", "inc", 2 * math.pi / 4096, 0.0),
        ("ticks * 1 rev / 4096 - 2048 ticks", "", 2 * math.pi / 4096, -math.pi),
        ("mm/50", "", 2e-5, 0.0),
        ("/50", "mm", 2e-5, 0.0),
        ("counts*-360deg/4096", "", -2 * math.pi / 4096, 0.0),
        ("mm*-1-2mm", "", -1e-3, -2e-3),
        ("mm*2-1.5mm", "", 2e-3, -1.5e-3),
        ("mm*+2", "", 2e-3, 0.0),
        ("V*10mm/1V-2.5V", "", 1e-2, -2.5e-2),
        ("1e-3mm", "", 1e-6, 0.0),
        ("mm*1e-003", "", 1e-6, 0.0),
        ("inc*.5um", "", 5e-7, 0.0),
        ("rpm*2", "", 2 * math.pi / 30, 0.0),
        ("m/s**2*3", "", 3.0, 0.0),
        ("m/s^-2*3", "", 3.0, 0.0),
        ("rpm*5mm/rev/3", "", 5e-3 / 180, 0.0),
        ("rpm*5mm/rad", "", 5e-3 * 2 * math.pi / 60, 0.0),
        ("rpm*5mm/rev+60rpm", "", 5e-3 / 60, 5e-3),
        ("mA*10mm/1A-2mA", "", 1e-5, -2e-5),
        ("V*10 mm/V-2mm", "", 1e-2, -2e-3),
        ("mm*0.5rev/5mm", "", 0.2 * math.pi, 0.0),
        ("mm/5mm/rev", "", 0.4 * math.pi, 0.0),
    ],
)
def test_a_scaling_is_read_to_the_last_bit(
    text: str, own: str, factor: float, offset: float
) -> None:
    assert is_scaling(text)
    of, added = read_scaling(text, own)
    assert float(of) == pytest.approx(factor, rel=2.3e-16)
    assert float(added or 0.0) == pytest.approx(offset, rel=2.3e-16)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("counts*36Odeg", "'Odeg'"),
        ("counts*360dag/3", "'dag'"),
        ("furlongs*3", "'furlongs'"),
        ("counts*360deg+3", "an offset needs its unit"),
        ("counts*360deg+1deg*3", "one offset at most"),
        ("counts*360deg+1deg-2deg", "one offset at most"),
        ("counts*3counts", "length or an angle"),
        ("counts*0deg", r"\*0 makes"),
        ("mm/0", "/0 makes"),
        ("mm*nan", "'nan'"),
        ("mm/-Infinity", "'-Infinity'"),
        ("mm*", "a number is missing after '*'"),
        ("mm *2 -", "a number is missing after '-'"),
        ("mm*1e999999999", "'e999999999'"),
        ("mm*1e99*1e99*1e99*1e99", "product of the factors"),
        (f"mm*{'9' * 300}", "more than 200"),
        ("rpm*5mm/furlong", "'mm/furlong'"),
        ("mm+2V", "an offset in V cannot be added to m"),
    ],
)
def test_a_mistake_is_told(text: str, said: str) -> None:
    with refuses("units", said):
        read_record(log(), columns={"position": f"position:{text}"})


def test_counts_are_scaled_in_every_way_alike() -> None:
    each = 2 * math.pi / (4096 * 50)
    for column in (
        "position:counts*360deg/4096/50",
        "#2:360deg/4096/50",
        Column("position", resolution=4096, gear=50),
        Column(2, unit="inc", scale="360deg/204800"),
        "position:counts*-360deg/-204800",
    ):
        record = read_record(log(), columns={"position": column})
        assert record.position == pytest.approx(each * COUNTS, rel=1e-15)
    (told,) = [said for said in record.provenance.assumed if "position" in said]
    assert "3.06796158e-05 rad each" in told


def axis_file(folder: Any, columns: str) -> Any:
    file = folder / "a.toml"
    file.write_text(
        'name = "a"\n[coordinate]\nname = "q"\nunit = "rad"\n[parameters.J]\nunit = "kg m^2"\n'
        f'[newton]\ninertia = "J"\n[drive]\ngain = 1\nunit = "A"\n[columns]\n{columns}\n'
    )
    return file


def test_an_axis_declares_it_once(tmp_path: Any) -> None:
    column = Column("position", resolution=4096, gear="121/3", offset="-0.2deg")
    assert str(column) == "position:counts*1rev/4096/121*3-0.2deg"
    entry = '{ name = "position", resolution = 4096, gear = "121/3", offset = "-0.2deg" }'
    axis = load_axis(axis_file(tmp_path, f"position = {entry}"))
    assert axis.columns["position"] == str(column)
    expected = 2 * math.pi * 3 / (4096 * 121) * COUNTS - math.pi / 900
    assert read_record(log(), axis).position == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("{ unit = 'mm' }", "name: the key is missing"),
        ("{ name = 'q', gears = 3 }", "the key is unknown"),
        ("{ name = 'q', gear = 'x' }", "the gear of a column is 'x'"),
        ("{ name = 'q', scale = 'deg' }", "the scale of a column is 'deg'"),
        ("{ name = 'q', offset = 0.2 }", "offset: the value is 0.2"),
        ("{ name = 'q', unit = 'mm', resolution = 4096 }", "'mm' and a resolution"),
        ("{ name = 'q', resolution = 'rev' }", "the resolution of a column is 'rev'"),
        ("{ name = 'q', scale = nan }", "the scale of a column is nan"),
        ("{ name = 0 }", "the name of a column is 0"),
    ],
)
def test_a_column_of_an_axis_file_that_is_none_is_told_with_its_key(
    tmp_path: Any, entry: str, said: str
) -> None:
    with pytest.raises(ModelError, match=f"columns\\.position.*{said}"):
        load_axis(axis_file(tmp_path, f"position = {entry}"))


@pytest.mark.parametrize(
    ("axis", "role", "scaling", "what"),
    [
        ("emps2015", "velocity", "rpm*5mm/3", "m/s times an angle.*5mm/rev for a screw"),
        ("emps2015", "position", "counts*360deg/4096*5mm", "m times an angle"),
        ("emps2015", "position", "counts*5mm/rev/4096", "m divided by an angle"),
        ("emps2015", "acceleration", "rev/s^2*5mm", "m/s\\^2 times an angle"),
        ("pendulum", "velocity", "mm/s/5mm", "divided by an angle"),
        (None, "position", "deg*5mm", "m times an angle"),
    ],
)
def test_an_angle_that_no_length_is_given_for_is_refused(
    axis: str | None, role: str, scaling: str, what: str
) -> None:
    unit = load_axis(axis).coordinate.unit if axis else "m"
    columns = {"position": f"#2:{unit}", role: f"#4:{scaling}"}
    with refuses("units", what):
        read_record(log(other=COUNTS + 0.5), axis and load_axis(axis), columns=columns)


@pytest.mark.parametrize(
    ("axis", "role", "scaling", "each"),
    [
        ("emps2015", "velocity", "rpm*5mm/rev", 5e-3 / 60),
        ("emps2015", "velocity", "rad/s*5mm/rad", 5e-3),
        ("emps2015", "velocity", "deg/s*5mm/360deg", 5e-3 / 360),
        ("emps2015", "position", "counts*5mm/4096", 5e-3 / 4096),
        ("emps2015", "position", "counts*360deg/4096*5mm/rev", 5e-3 / 4096),
        ("pendulum", "position", "mm*1rev/5mm", 0.4 * math.pi),
        ("pendulum", "control", "mm*2A/5mm", 0.4),
        ("emps2015", "force", "Nm/5mm/rev", 400 * math.pi),
    ],
)
def test_a_length_of_a_turn_or_of_a_radian_makes_an_angle_a_length(
    axis: str, role: str, scaling: str, each: float
) -> None:
    unit = load_axis(axis).coordinate.unit
    columns = {"position": f"#2:{unit}", role: f"#4:{scaling}"}
    record = read_record(log(other=COUNTS + 0.5), load_axis(axis), columns=columns)
    assert record.channels()[role] == pytest.approx(each * (COUNTS + 0.5), rel=1e-12)


def test_a_position_of_whole_numbers_is_not_believed_to_be_radians() -> None:
    with refuses("units", r"from -1470 to 2017.*position:counts\*360deg/4096/50"):
        read_record(log())
    assert len(read_record(log(), columns={"position": "position:rad"})) == len(TIME)


@pytest.mark.slow
def test_right_logs_are_not_told_to_be_counts() -> None:
    """Rounded to an encoder's steps, to decimals, at rest, of few samples."""
    for position in (
        2 * math.pi / 4096 * COUNTS,
        np.round(0.5 * np.sin(20 * TIME), 3),
        np.round(np.sin(5 * TIME)),
        1e-3 * COUNTS,
    ):
        assert len(read_record(log(position=position))) == len(TIME)
    for name in LIBRARY:
        axis = load_axis(name)
        twin = twin_record(axis)
        assert len(read_record(dict(twin.channels()), replace(axis, columns={}))) == len(twin)


def test_columns_go_by_number_also_without_a_name_or_a_header(tmp_path: Any) -> None:
    file, table = tmp_path / "log.csv", np.column_stack([TIME, 0 * TIME, COUNTS, TIME])
    columns = {"time": "#1", "position": "#3:360deg/4096", "control": "#4"}
    frame = {"time": TIME, "state": np.array(["on"] * 200), "x": COUNTS, "u": TIME}
    np.savetxt(file, table, delimiter=";")
    for log in (file, frame):
        record = read_record(log, columns=columns)
        assert record.position == pytest.approx(2 * math.pi / 4096 * COUNTS)
    assert "no header row" in " ".join(read_record(file, columns=columns).provenance.assumed)
    with refuses("columns", "column '#5'.*#1, #2, #3"):
        read_record(file, columns={**columns, "control": "#5"})
    np.savetxt(file, table, delimiter=";", header="t;state;;u", comments="")
    assert read_record(file, columns=columns).position.shape == (200,)


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
    record = read_record({"clock": 1e6 * TIME, "enc": VALUES}, axis)
    assert record.time == pytest.approx(TIME)
    assert record.position == pytest.approx(2 * math.pi * VALUES)


@pytest.mark.parametrize(
    ("name", "unit"), [("axis:deg", ""), ("q (act)", " ('act' is not a known unit)")]
)
def test_a_name_with_what_may_be_a_unit_is_taken_whole(rotary: Axis, name: str, unit: str) -> None:
    record = read_record({"time": TIME, name: VALUES}, rotary, columns={"position": name})
    assert np.array_equal(record.position, VALUES)
    (note,) = record.provenance.assumed
    assert note.endswith(f"time in s, position in rad{unit}")


@pytest.mark.parametrize("name", ["angle", "angle [inc]"])
def test_a_column_of_an_unknown_unit_is_read_where_its_unit_is_given(
    rotary: Axis, name: str
) -> None:
    log = {"time": TIME, "angle [inc]": VALUES}
    record = read_record(log, rotary, columns={"position": f"{name}:mrad"})
    assert record.position == pytest.approx(1e-3 * VALUES)


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"position": "angle"}, "'inc'"),
        ({"position": "angle [inc]"}, "'inc'"),
        ({"position": "q:mm"}, "position of axis 'motor' is measured in rad"),
        ({"position": "q:Nm"}, "position of axis 'motor' is measured in rad"),
        ({"position": "q:inch^"}, "'inch.'"),
        ({"position": "q:deg/rev"}, "'deg/rev'"),
        ({"position": "q", "control": "u:A/rev"}, "'A/rev'"),
        ({"position": "q", "control": "u:mV"}, "control of axis 'motor' is measured in A"),
        ({"position": "q", "force": "u:N"}, "force of axis 'motor' is measured in N m"),
        ({"position": "q", "time": "time:mm"}, "time of axis 'motor' is measured in s"),
        ({"position": "q:counts"}, "'counts'.*counts.360deg/4096"),
        ({"position": "q:counts/4096"}, "'counts/4096'.*size of one count"),
        (
            {"position": "q:counts*5mm/4096"},
            "which is m, but the position of axis .motor. is measured in rad",
        ),
        ({"position": "q:V*2"}, "but the position of axis .motor. is measured in rad"),
    ],
)
def test_unit_of_another_kind_is_refused(rotary: Axis, columns: dict[str, str], says: str) -> None:
    log = {"time": TIME, "q": VALUES, "u": VALUES, "angle [inc]": VALUES}
    with refuses("units", says):
        read_record(log, rotary, columns=columns)


@pytest.mark.parametrize(
    ("role", "unit"),
    [
        ("velocity", "1/s"),
        ("velocity", "s^-1"),
        ("acceleration", "1/s^2"),
        ("position", "1"),
        ("reference", "%"),
    ],
)
def test_unit_without_an_angle_is_refused_of_a_rotary_axis(
    rotary: Axis, role: str, unit: str
) -> None:
    log = {"time": TIME, "position": VALUES, "control": VALUES, "x": VALUES}
    for axis in (rotary, None):
        with refuses("units", "rad"):
            read_record(log, axis, columns={role: f"x:{unit}"})


def test_unit_without_an_angle_in_a_header_is_refused(rotary: Axis) -> None:
    log = {"time": TIME, "position": VALUES, "control": VALUES, "w [1/s]": VALUES}
    with refuses("units", "rad/s"):
        read_record(log, rotary, columns={"velocity": "w"})


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("rad/s", 1.0), ("rpm", math.pi / 30), ("1/min", math.pi / 30), ("rev/s", 2 * math.pi)],
)
def test_unit_of_turns_is_read_of_a_rotary_axis(rotary: Axis, unit: str, factor: float) -> None:
    log = {"time": TIME, "position": VALUES, "control": VALUES, "x": VALUES}
    record = read_record(log, rotary, columns={"velocity": f"x:{unit}"})
    assert record.velocity == pytest.approx(factor * VALUES)


def test_modulus_has_a_unit_too(rotary: Axis) -> None:
    wrap = {"position": "360:deg", "control": "6.5"}
    sizes = {role: modulus.si for role, modulus in Repairs(wrap=wrap).moduli(rotary).items()}
    assert sizes == pytest.approx({"position": 2 * math.pi, "control": 6.5})
