"""Positions that start again after a turn are unwrapped on request, and recognised without one."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from axisid import load_axis, read_record
from axisid.estimation import Repairs
from axisid.estimation.raw_tables import Samples
from axisid.estimation.records.columns import RoleColumns
from axisid.estimation.records.wrapping import Modulus, unwound
from tests.refusals import refuses

N = 400
PERIOD = 1e-3
TIME = PERIOD * np.arange(N)
TURN = 2 * np.pi
TURNING = 3 + 4 * np.sin(10 * TIME) + 2 * TIME  # rad, over the seam and back
SEAMED = np.mod(TURNING, TURN)


def log(position: np.ndarray = TURNING, **changes: Any) -> dict[str, Any]:
    return {"time": TIME, "position": position, "control": np.cos(30 * TIME)} | changes


@pytest.mark.slow
@given(
    steps=st.lists(st.floats(-0.49, 0.49), min_size=3, max_size=60),
    start=st.floats(-20, 20),
    size=st.floats(0.1, 100),
)
def test_unwrapping_undoes_wrapping(steps: list[float], start: float, size: float) -> None:
    """Of a reference, whose steps may be any; a position's are even across its seam."""
    true = size * (start + np.cumsum(steps))
    even = size * (0.3 + 0.4 * np.arange(len(steps)))
    wrapped = {
        role: Samples(values=np.mod(values, size), clock=PERIOD * np.arange(len(steps)))
        for role, values in {"position": even, "reference": true}.items()
    }
    columns = RoleColumns(source="log", names={}, samples=wrapped)
    found, _ = unwound(columns, {"position": Modulus(size, 1.0, "rad")}, None, 1.5)
    for role, values in {"position": even, "reference": true}.items():
        unwrapped = np.diff(found.samples[role].values)
        assert unwrapped == pytest.approx(np.diff(values), abs=1e-9 * size)
    jumps = np.count_nonzero(np.diff(np.floor(true / size)))
    assert re.search(rf"reference {jumps}\b", found.repairs[0].text)


def test_position_and_reference_unwrap_onto_the_same_turn() -> None:
    true = 3 * np.sin(8 * TIME)
    wrapped = log(np.mod(true - 0.02, TURN), reference=np.mod(true, TURN))
    record = read_record(wrapped, repairs=Repairs(wrap="360:deg"))
    assert record.reference - record.position == pytest.approx(0.02, abs=1e-12)
    (repair,) = record.provenance.repairs
    assert (repair.kind, repair.count) == ("wrap", 4)
    assert re.search("360 deg.*position 2, reference 1;.*: 1$", repair.text)


FAR = np.deg2rad(190 + 10 * np.sin(8 * TIME))
TURNS = 20 * np.sin(8 * TIME) ** 2
STEP = np.where(TIME < 0.2, 6.0, 6.6)
SETTLING = 6.0 + np.where(TIME < 0.2, 0, 0.6 * (1 - np.exp(-50 * (TIME - 0.2))))


@pytest.mark.parametrize(
    ("position", "logged", "reference"),
    [
        (np.deg2rad(100) * np.sin(8 * TIME) ** 2, FAR, FAR),  # no jump: no turn is wrong
        (TURNS, TURNS + 2 * TURN, TURNS + 2 * TURN),  # several turns of its own
        (SETTLING, np.mod(STEP, TURN), STEP),  # a step across its seam
    ],
)
def test_reference_keeps_its_own_turn_or_begins_on_the_positions(
    position: np.ndarray, logged: np.ndarray, reference: np.ndarray
) -> None:
    record = read_record(
        log(np.mod(position, TURN), reference=logged), repairs=Repairs(wrap="360:deg")
    )
    assert record.reference == pytest.approx(reference, abs=1e-12)
    assert record.position == pytest.approx(position, abs=1e-12)


def test_reference_begins_on_the_positions_turn_after_every_gap() -> None:
    true = np.where(TIME < 0.15, 6.0, 6.0 + 0.45 * TURN) + 0.005 * np.sin(60 * TIME)
    ahead = true + np.where(TIME < 0.15, 0.0, 0.5)  # more than half a turn on from before
    whole = log(np.mod(true, TURN), reference=np.mod(ahead, TURN))
    wrapped = {role: np.delete(values, slice(100, 201)) for role, values in whole.items()}
    for more in ({}, {"resample": 1000.0}):
        record = read_record(wrapped, repairs=Repairs(wrap=TURN, gaps="split", **more))  # type: ignore[arg-type]
        apart = np.asarray(record.reference) - record.position
        assert apart[[0, -1]] == pytest.approx([0, 0.5], abs=1e-9)
        told = next(r for r in record.provenance.repairs if r.kind == "wrap").text
        assert "across a gap" in told
        assert told.endswith("whole moduli: 1")


@pytest.mark.parametrize(
    ("position", "wrap", "code", "says"),
    [
        (TURNING, 1.0, "wrap", "1 rad"),
        *((SEAMED, wrap, "wrap", "") for wrap in ("400:deg", "361:deg", "6.29", "7")),
        *((SEAMED, w, "wrap", r"jumps.*modulus.*360:deg") for w in ("360", "1000:deg")),
        # Recognised unasked.
        (SEAMED, None, "wrap", r"\(\d such jumps\).*wrap"),
        (np.rad2deg(SEAMED), None, "wrap", r"\(\d such jumps\).*columns.*wrap"),
        (TURNING, "torque=65536", "wrap", ""),
        (TURNING, "time=4294967296", "wrap", ""),
        (TURNING, "control=", "usage", ""),
        (TURNING, "control=65536:mm", "units", ""),
    ],
)
def test_modulus_that_no_column_has_is_refused(
    position: np.ndarray, wrap: Any, code: str, says: str
) -> None:
    with refuses(code, says=says):
        read_record(log(position), load_axis("pendulum"), repairs=Repairs(wrap=wrap))


def test_jump_by_another_distance_is_told() -> None:
    by_range = read_record(log(np.mod(TURNING, 1.5)), load_axis("emps2015"))
    assert any("the position jumps by 1." in note for note in by_range.provenance.doubts)


def test_motion_that_is_not_wrapped_says_nothing_of_jumps() -> None:
    outlier = TURNING.copy()
    outlier[77] += 20
    rest = replace(load_axis("rotary_table"), columns={})
    for position in (TURNING, outlier, np.round(0.3 * TURNING)):
        doubts = read_record(log(position), rest).provenance.doubts
        assert not any("jumps" in note for note in doubts)
    (repair,) = read_record(log(TIME), repairs=Repairs(wrap="360:deg")).provenance.repairs
    assert repair.count == 0


VOLTS = "control:counts*10V/32768"
#: What the column of a control may be, whose numbers are of 16 bits.
MEANINGS = (
    VOLTS,
    "control:mV",
    "control:counts*-10V/32768",
    "control:counts*10V/32768+0.5V",
    "control:counts*-10V/32768-0.5V",
    "control:V",
)
CONTROL = 9000 * np.cos(30 * TIME) + 40 * np.random.default_rng(3).standard_normal(N)


@pytest.mark.parametrize(
    ("given", "meaning"),
    [
        ("control=20:V", VOLTS),
        ("control=65536", VOLTS),
        *(({"control": 65536}, meaning) for meaning in MEANINGS),
    ],
)
def test_a_control_that_lost_its_sign_has_it_back(given: Any, meaning: str) -> None:
    """A modulus without a unit is of the numbers as they are written, whatever these mean."""
    axis = load_axis("emps2015")
    both = [
        read_record(
            log(0.01 * TURNING, control=control),
            axis,
            columns={"position": "position:m", "control": meaning},
            repairs=Repairs(wrap=wrap),
        )
        for control, wrap in (
            (np.mod(np.round(CONTROL), 2.0**16), given),
            (np.round(CONTROL), None),
        )
    ]
    assert both[0].control == pytest.approx(both[1].control, abs=1e-12)
    (repair,) = both[0].provenance.repairs
    assert repair.count == np.count_nonzero(np.round(CONTROL) < 0)


def test_a_modulus_without_a_unit_is_of_the_numbers_of_a_position() -> None:
    degrees, columns = np.rad2deg(SEAMED), {"position": "position:deg"}
    records = [
        read_record(log(degrees), columns=columns, repairs=Repairs(wrap=wrap))
        for wrap in (360, "360:deg")
    ]
    assert records[0].position == pytest.approx(records[1].position, abs=1e-12)
    assert records[0].position == pytest.approx(TURNING, abs=1e-9)
    with refuses("wrap", says="spans"):
        read_record(log(degrees), columns=columns, repairs=Repairs(wrap=TURN))
