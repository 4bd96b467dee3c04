"""Columns that a log may have besides: measured motion, a test signal, signals of the axis."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import Record, build, load_axis, read_record
from axisid.estimation import Repairs
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.arrays import Array
from tests.axes.recorded import recorded_axis
from tests.refusals import refuses

N = 2000
TIME = 1e-3 * np.arange(N)
VELOCITY = 30 * np.cos(30 * TIME)
PRESSURE = 6e5 + 1e5 * np.sin(7 * TIME)
LOG: dict[str, Array] = {
    "time": TIME,
    "position": np.sin(30 * TIME),
    "reference": np.sin(30 * TIME),
    "control": np.cos(7 * TIME),
}
MOTION = {**LOG, "velocity": VELOCITY, "acceleration": -900 * np.sin(30 * TIME)}
NAMED = {"velocity": "velocity", "acceleration": "acceleration"}
ALONE = {name: values for name, values in MOTION.items() if name != "position"}
INJECTED = {**LOG, "exc": 0.1 * np.sin(60 * TIME)}
AXIS = recorded_axis("pressure")
EMPS = load_axis("emps2015")


def test_measured_motion_is_of_a_record_where_it_is_named() -> None:
    record, without = read_record(MOTION, columns=NAMED), read_record(MOTION)
    assert record.motion == ("position", "velocity", "acceleration")
    assert np.array_equal(np.asarray(record.velocity), VELOCITY)
    assert record.provenance.columns["velocity"] == "velocity"
    assert without.motion == ("position",)
    assert without.digest != record.digest
    assert sum("left out, as nobody named" in note for note in without.provenance.assumed) == 2


@pytest.mark.parametrize(
    ("unit", "each"),
    [("rpm", np.pi / 30), ("deg/s", np.pi / 180), ("rad/s", 1.0), ("rev/s", 2 * np.pi)],
)
def test_a_velocity_has_a_unit_of_its_own_kind(unit: str, each: float) -> None:
    columns = {"velocity": f"velocity:{unit}"}
    record = read_record(MOTION, load_axis("pendulum"), columns=columns)
    assert np.asarray(record.velocity) == pytest.approx(each * VELOCITY)


def test_without_a_position_it_is_the_velocitys_integral_from_the_reference() -> None:
    assert read_record(ALONE, columns={"velocity": "velocity"}).motion == ("velocity",)
    record = Record(time=TIME, velocity=VELOCITY, reference=LOG["position"] + 0.25, control=TIME)
    assert record.integrated
    assert record.position == pytest.approx(LOG["position"] + 0.25, abs=1e-3)
    assert "position" not in record.channels()
    for cut in (record.windowed((0.1, 0.3), (0.9, 1.4)), record.shifted(control=2)):
        starts = [start for start, _ in cut.spans]
        assert cut.position[starts] == pytest.approx(np.asarray(cut.reference)[starts])
        assert cut.integrated


def test_a_test_signal_is_added_to_what_is_said() -> None:
    at_control, at_reference = (
        read_record(INJECTED, columns={"injected": "exc"}, injected_at=place)
        for place in ("control", "reference")
    )
    assert at_control.injected_at == "control"
    np.testing.assert_array_equal(at_control.added_control, INJECTED["exc"])
    np.testing.assert_array_equal(at_control.commanded, LOG["reference"])
    assert at_reference.added_control is None
    np.testing.assert_array_equal(at_reference.commanded, LOG["reference"] + INJECTED["exc"])
    assert "'exc' was added to the reference" in at_reference.provenance.assumed


@pytest.mark.parametrize(("unit", "place"), [("mm", "reference"), ("mV", "control")])
def test_its_unit_is_that_of_what_it_is_added_to(unit: str, place: str) -> None:
    record = read_record(INJECTED, EMPS, columns={"injected": f"exc:{unit}"}, injected_at=place)
    np.testing.assert_allclose(record.injected, 1e-3 * INJECTED["exc"])


def test_a_column_that_only_bears_the_roles_name_is_left_out_and_told() -> None:
    log = {**LOG, "injected": INJECTED["exc"]}
    record = read_record(log)
    assert record.injected is None
    assert "'injected' is left out" in str(record.provenance.assumed)
    assert read_record(log, injected_at="control").injected is not None


def test_the_axis_may_say_both_and_its_log_may_lack_the_column() -> None:
    declared = {"injected": "exc", "position": "position"}
    axis = replace(EMPS, columns=declared, injected_at="control")
    assert read_record(INJECTED, axis).injected_at == "control"
    assert read_record(INJECTED, axis, injected_at="reference").injected_at == "reference"
    without = read_record(LOG, axis)
    assert without.injected is None
    assert "no test signal is reckoned with" in str(without.provenance.assumed)
    with refuses("test-signal", says="'force'"):
        replace(axis, injected_at="force")


def test_it_is_resampled_as_what_it_is_added_to() -> None:
    lines, smooth = (
        read_record(
            INJECTED,
            repairs=Repairs(resample=2000.0),
            columns={"injected": "exc"},
            injected_at=place,
        )
        for place in ("control", "reference")
    )
    np.testing.assert_allclose(lines.injected, np.interp(lines.time, TIME, INJECTED["exc"]))
    np.testing.assert_allclose(smooth.injected, 0.1 * np.sin(60 * smooth.time), atol=1e-6)


def columns(**changed: Any) -> dict[str, Array]:
    """Of an axis that declares a pressure."""
    given = {**LOG, "pressure": PRESSURE, **changed}
    return {name: v for name, v in given.items() if v is not None}


def written(folder: Path, log: Mapping[str, Array]) -> Path:
    file = folder / "log.csv"
    rows = np.column_stack(list(log.values()))
    np.savetxt(file, rows, delimiter=",", header=",".join(log), comments="", fmt="%.17g")
    return file


@pytest.mark.parametrize("named", ["p:bar", "#5:bar", "p:mbar*1000"])
def test_a_signal_is_found_by_name_number_and_unit(named: str, tmp_path: Path) -> None:
    log = columns(pressure=None, p=PRESSURE / 1e5)
    record = read_record(written(tmp_path, log), AXIS, columns={"pressure": named})
    assert record.signals["pressure"] == pytest.approx(PRESSURE, rel=1e-12)
    assert record.provenance.columns["pressure"] == "p"


def test_a_signal_may_be_constant() -> None:
    still = columns(pressure=np.full(N, 6e5))
    assert np.ptp(read_record(still, AXIS).signals["pressure"]) == 0


@pytest.mark.parametrize(
    ("code", "said", "log", "axis", "asked"),
    [
        ("columns", "", ALONE, None, {}),
        ("wrap", "", ALONE, None, {"columns": NAMED, "repairs": Repairs(wrap="360:deg")}),
        ("not-shown", "reference is 0", columns(reference=0 * TIME), None, {}),
        (
            "units",
            "injected of axis 'emps2015' is measured in V",
            *(INJECTED, EMPS, {"columns": {"injected": "exc:mm"}, "injected_at": "control"}),
        ),
        (
            "test-signal",
            'add injected_at = "control"',
            INJECTED,
            None,
            {"columns": {"injected": "exc"}},
        ),
        ("test-signal", "", INJECTED, None, {"injected_at": "control"}),
        (
            "test-signal",
            'added to .force.; give injected_at = "control"',
            *(INJECTED, None, {"columns": {"injected": "exc"}, "injected_at": "force"}),
        ),
        ("columns", "no column 'pressure' for the pressure; found time, position", LOG, AXIS, {}),
        ("units", "in Pa", columns(), AXIS, {"columns": {"pressure": "pressure:mm"}}),
        ("columns", "injected, pressure", columns(), AXIS, {"columns": {"flow": "pressure"}}),
        ("columns", "", columns(), AXIS, {"columns": {"pressure": "control"}}),
        ("shift", "flow", columns(), AXIS, {"repairs": Repairs(shift={"flow": 2})}),
    ],
)
def test_a_log_that_lacks_or_mistakes_one_is_refused(
    code: str, said: str, log: Any, axis: Any, asked: dict[str, Any]
) -> None:
    with refuses(code, said):
        read_record(log, axis, **asked)


@pytest.mark.parametrize(
    ("code", "said", "parts"),
    [
        ("missing-column", "", {"control": TIME}),
        ("record", "differ in length", {"velocity": VELOCITY[:-1]}),
        ("test-signal", "None", {**LOG, "injected": VELOCITY}),
        (
            "not-finite",
            "pressure is nan in data row 1",
            {**LOG, "signals": {"pressure": np.nan * TIME}},
        ),
        ("record", "no signal's name", {**LOG, "signals": {"force": TIME}}),
        ("record", "differ in length", {**LOG, "signals": {"pressure": TIME[1:]}}),
    ],
)
def test_a_record_of_such_columns_is_refused(code: str, said: str, parts: dict[str, Any]) -> None:
    with refuses(code, said):
        Record(**{"time": TIME, **parts})


def test_what_is_needed_and_not_there_is_refused_where_it_is() -> None:
    with refuses("missing-column", "pressure"):
        FilteredRecord.bind(build(AXIS), Record(**LOG), Prefilter())
    with refuses("shift"):
        read_record(ALONE, columns=NAMED).shifted(position=1)
    still = {**INJECTED, "reference": np.zeros(N)}
    moved = read_record(still, columns={"injected": "exc"}, injected_at="control")
    assert moved.injected is not None


@pytest.mark.parametrize(
    "settings",
    [{"windows": [(0.2, 0.7), (1.0, 1.5)]}, {"repairs": Repairs(gaps="split")}],
)
def test_windows_and_gaps_take_the_signal_along(settings: Any) -> None:
    log = {name: np.delete(values, slice(800, 900)) for name, values in columns().items()}
    record = read_record(columns() if "windows" in settings else log, AXIS, **settings)
    for piece in (record, record.longest(), record.windowed((1.1, 1.4))):
        assert piece.signals["pressure"] == pytest.approx(6e5 + 1e5 * np.sin(7 * piece.time))


def test_a_signal_is_shifted_by_its_name() -> None:
    early = columns(pressure=np.append(PRESSURE[2:], [6e5, 6e5]))
    record = read_record(early, AXIS, repairs=Repairs(shift={"pressure": 2}))
    assert record.signals["pressure"] == pytest.approx(6e5 + 1e5 * np.sin(7 * record.time))
    moved = read_record(early, AXIS).shifted(pressure="2ms")
    assert np.array_equal(moved.signals["pressure"], record.signals["pressure"])


@pytest.mark.parametrize("between", ["linear", "held"])
def test_a_signal_of_its_own_clock_is_resampled_as_it_runs(between: str) -> None:
    """Every tenth sample alone is logged; between them it is straight, or held."""
    log = columns(pressure=np.where(np.arange(N) % 10 == 0, PRESSURE, np.nan))
    axis = recorded_axis("pressure", between)
    record = read_record(log, axis, repairs=Repairs(resample="auto"))
    seldom, rows = PRESSURE[::10], np.arange(len(record)) / 10
    straight = np.interp(rows, np.arange(200), seldom)
    expected = seldom[rows.astype(int)] if between == "held" else straight
    assert record.signals["pressure"] == pytest.approx(expected, rel=1e-12)
    how = {"held": "held", "linear": "by straight lines"}[between]
    assert f"pressure {how}" in "".join(repair.text for repair in record.provenance.repairs)
