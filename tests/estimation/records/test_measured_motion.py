"""Measured velocity and acceleration as columns of a log: roles, units, shifts, windows, gaps."""

from typing import Any

import numpy as np
import pytest

from axisid import DataError, Record, load_axis, read_record
from axisid.estimation import Repairs
from tests.refusals import refuses

N, PERIOD = 2000, 1e-3
TIME = PERIOD * np.arange(N)
POSITION, VELOCITY, ACCELERATION = (
    np.sin(30 * TIME),
    30 * np.cos(30 * TIME),
    -900 * np.sin(30 * TIME),
)
NAMED = {"velocity": "velocity", "acceleration": "acceleration"}


def log(**changes: Any) -> dict[str, Any]:
    columns = {"time": TIME, "position": POSITION, "velocity": VELOCITY}
    return {**columns, "acceleration": ACCELERATION, "control": np.cos(7 * TIME)} | changes


def test_both_are_columns_of_a_record_where_they_are_named() -> None:
    record = read_record(log(), columns=NAMED)
    assert record.motion == ("position", "velocity", "acceleration")
    assert np.array_equal(np.asarray(record.velocity), VELOCITY)
    assert record.provenance.columns["velocity"] == "velocity"
    without = read_record(log())
    assert without.motion == ("position",)
    assert without.digest != record.digest
    assert sum("left out, as nobody named" in note for note in without.provenance.assumed) == 2


@pytest.mark.parametrize(
    ("unit", "each"),
    [("rpm", np.pi / 30), ("deg/s", np.pi / 180), ("rad/s", 1.0), ("rev/s", 2 * np.pi)],
)
def test_a_velocity_has_a_unit_of_its_own_kind(unit: str, each: float) -> None:
    pendulum = load_axis("pendulum")
    record = read_record(log(), pendulum, columns={"velocity": f"velocity:{unit}"})
    assert np.asarray(record.velocity) == pytest.approx(each * VELOCITY)


class TestVelocityAlone:
    def test_the_position_is_its_integral_from_the_reference(self) -> None:
        reference = POSITION + 0.25
        record = Record(time=TIME, velocity=VELOCITY, reference=reference, control=TIME)
        assert record.integrated
        assert record.motion == ("velocity",)
        assert record.position == pytest.approx(reference, abs=1e-3)
        assert "position" not in record.channels()

    def test_each_window_begins_at_its_own_reference(self) -> None:
        record = Record(time=TIME, velocity=VELOCITY, reference=POSITION, control=TIME)
        for cut in (record.windowed((0.1, 0.3), (0.9, 1.4)), record.shifted(control=2)):
            starts = [start for start, _ in cut.spans]
            assert cut.position[starts] == pytest.approx(np.asarray(cut.reference)[starts])
            assert cut.integrated

    def test_a_log_without_a_position_serves_where_the_velocity_is_named(self) -> None:
        columns = {k: v for k, v in log().items() if k != "position"}
        record = read_record(columns, columns={"velocity": "velocity"})
        assert record.motion == ("velocity",)
        with refuses("columns"):
            read_record(columns)

    def test_what_is_done_to_a_position_is_refused(self) -> None:
        columns = {k: v for k, v in log().items() if k != "position"}
        with refuses("wrap"):
            read_record(columns, columns=NAMED, repairs=Repairs(wrap="360:deg"))
        with refuses("shift"):
            read_record(columns, columns=NAMED).shifted(position=1)

    def test_neither_is_refused(self) -> None:
        with refuses("missing-column"):
            Record(time=TIME, control=TIME)
        with pytest.raises(DataError, match="differ in length"):
            Record(time=TIME, velocity=VELOCITY[:-1], control=TIME)
