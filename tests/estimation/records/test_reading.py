"""Files in, records out; what cannot be read is explained by file, line and column.

Columns that a log may have besides: measured motion, a test signal, signals of the axis.

A record's period is the declared law's, or the verdict says so; right logs raise no alarm.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import axisid
from axisid import (
    DataError,
    Record,
    build,
    load_axis,
    read_record,
    validate,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation import Repairs
from axisid.estimation.diagnostics.control_law.law_agreement import LawAgreement, law_agreement
from axisid.estimation.model_validation.validation_findings import DoubtfulTimeBase
from axisid.estimation.records import OtherPeriod
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.support.arrays import Array
from axisid.support.missing import Missing
from tests.axes.recorded import recorded_axis
from tests.files import csv_file, text_file
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of

ROWS = [(0.001 * k, np.sin(k / 9), np.cos(k / 9), 0.1 * k % 0.7) for k in range(40)]


def text(delimiter: str = ",", header: str = "time,position,reference,control") -> str:
    lines = [header.replace(",", delimiter)]
    return "\n".join(lines + [delimiter.join(f"{x:.17g}" for x in row) for row in ROWS]) + "\n"


def test_columns_are_found_by_the_users_names_then_the_axis_then_the_role(tmp_path: Path) -> None:
    file = text_file(tmp_path / "log.csv", text(header="t,qm,qg,volts"))
    record = read_record(file, load_axis("emps"), columns={"control": "volts"})
    assert record.provenance.columns == {
        "time": "t",
        "position": "qm",
        "reference": "qg",
        "control": "volts",
    }


def test_quoted_cells_blank_lines_and_byte_order_marks_are_read(tmp_path: Path) -> None:
    quoted = "\ufeff" + text().replace("\n", "\n\n").replace("0.001,", '"0.001",')
    assert len(read_record(text_file(tmp_path / "log.csv", quoted))) == 40


@pytest.mark.parametrize(
    ("content", "code", "says"),
    [
        ("", "log-text", "has 0 filled lines"),
        ("time,position\n", "log-text", "has 1 filled lines"),
        ("0.0,1.0\n0.1,2.0\n", "columns", "#1, #2"),
        ("time,position,position\n0,1,2\n", "columns", "position.1, position.2"),
        ("time,position\n0,1\n1,x\n", "log-text", "line 3: 'x' in column 'position'"),
        ("time,position\n0,1\n1\n", "log-text", "header names 2"),
        ("time,position\n0,1\n1,\n", "empty-cells", "position is nan in data row 2"),
        (
            "time;position\n0;1.5\n1;2,5\n",
            "log-text",
            "line 3: '2,5' in column 'position'.*decimal point",
        ),
        (
            "time;position\n0;1,5\n1;2.5\n",
            "log-text",
            "line 2: '1,5' in column 'position'.*decimal point",
        ),
        ("time;position\n0;1,234\n1;2,345\n", "log-text", "'1,234'"),
        ("time,position\n0,1,2\n1,2,3\n", "log-text", "names 2 columns"),
        ("time,position\n0,1_000\n1,2\n", "log-text", "line 2: '1_000' in column 'position'"),
        (
            "time,position\n0,001,1,5\n0,002,1,6\n",
            "log-text",
            "2 columns.*the rows have 4.*semicolon",
        ),
        (
            "time,angle,control\n0,1,1\n1,2,2\n",
            "columns",
            "'position'.*time, angle, control",
        ),
    ],
)
def test_bad_text_is_explained(tmp_path: Path, content: str, code: str, says: str) -> None:
    with refuses(code, says):
        read_record(text_file(tmp_path / "log.csv", content))


def test_all_missing_columns_are_told_at_once(tmp_path: Path) -> None:
    file = text_file(tmp_path / "log.csv", text(header="t,pos,ref,volts"))
    declared = (
        "no column 'qm' for the position, 'qg' for the reference, 'vir' for the control. Found:"
    )
    advice = 'columns={"position": "NAME", "reference": "NAME", "control": "NAME"}'
    with refuses("columns", says=f"{declared} t, pos, ref, volts.*{advice}"):
        read_record(file, load_axis("emps"))
    with refuses("columns", says='"position": "NAME", "time": "NAME", "reference": "NAME"'):
        read_record(file)


@pytest.mark.parametrize("wanted", ["ISTPOSITION", "Istpositon", "istposition", "Soll"])
def test_column_of_nearly_the_name_is_proposed(tmp_path: Path, wanted: str) -> None:
    file = text_file(
        tmp_path / "log.csv", text(header="time,Istposition,Soll position of axis 1,control")
    )
    with refuses("columns", says="Did you mean '(Istposition|Soll position of axis 1)'"):
        read_record(file, columns={"position": wanted})


def test_names_that_occur_twice_matter_only_where_they_are_asked_for(tmp_path: Path) -> None:
    file = text_file(tmp_path / "log.csv", text(header="time,position,x,x"))
    assert len(read_record(file)) == len(ROWS)
    with refuses("columns", says=r"'x' for the control.*x\.1, x\.2"):
        read_record(file, columns={"control": "x"})
    record = read_record(file, columns={"reference": "x.1", "control": "x.2"})
    assert np.array_equal(record.control, np.array(ROWS)[:, 3])


def test_period_that_is_given_stands_for_a_time_column_that_the_axis_declares() -> None:
    axis = replace(load_axis("emps2015"), columns={"time": "t", "position": "q", "control": "u"})
    log = {"q": np.sin(np.arange(50)), "u": np.cos(np.arange(50))}
    assert read_record(log, axis, sample_period=1e-3).period == 1e-3
    for more in ({}, {"columns": {"time": "t"}, "sample_period": 1e-3}):
        with refuses("columns", says="'t' for the time"):
            read_record(log, axis, **more)  # type: ignore[arg-type]


def test_log_without_the_reference_that_the_axis_names_serves_least_squares() -> None:
    axis = load_axis("emps2015")
    twin = axisid.twin_record(axis)
    axis = replace(axis, columns={"position": "q", "reference": "set", "control": "u"})
    log = {"time": twin.time, "q": twin.position, "u": twin.control}
    record = read_record(log, axis)
    assert any("no column 'set' for the reference" in note for note in record.provenance.assumed)
    assert "has no reference column" in axisid.identify(axis, record).skipped["idm-iv"]
    with refuses("columns", says="'set' for the reference"):
        read_record(log, axis, columns={"reference": "set"})


@pytest.mark.parametrize("repairs", [{}, {"wrap": 1.0}, {"resample": 100.0}])
def test_log_without_a_number_is_refused_whatever_is_asked_for(repairs: dict[str, Any]) -> None:
    said = r"position (has no row with a number|is inf in data row 1)"
    for rows, period in ((0, None), (0, 0.01), (9, None)):
        log = {"time": 0.01 * np.arange(rows), "position": np.full(rows, np.inf)}
        with pytest.raises(DataError, match=said):
            asked = axisid.estimation.Repairs(**repairs)
            read_record(log, sample_period=period, repairs=asked)


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
    assert sum("is not used" in note for note in without.provenance.assumed) == 2


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
    assert "'exc' was added to the reference" in str(at_reference.provenance.assumed)


@pytest.mark.parametrize(("unit", "place"), [("mm", "reference"), ("mV", "control")])
def test_its_unit_is_that_of_what_it_is_added_to(unit: str, place: str) -> None:
    record = read_record(INJECTED, EMPS, columns={"injected": f"exc:{unit}"}, injected_at=place)
    np.testing.assert_allclose(record.injected, 1e-3 * INJECTED["exc"])


def test_a_column_that_only_bears_the_roles_name_is_left_out_and_told() -> None:
    log = {**LOG, "injected": INJECTED["exc"]}
    record = read_record(log)
    assert record.injected is None
    assert "'injected' is not used" in str(record.provenance.assumed)
    assert read_record(log, injected_at="control").injected is not None


def test_the_axis_may_say_both_and_its_log_may_lack_the_column() -> None:
    declared = {"injected": "exc", "position": "position"}
    axis = replace(EMPS, columns=declared, injected_at="control")
    assert read_record(INJECTED, axis).injected_at == "control"
    assert read_record(INJECTED, axis, injected_at="reference").injected_at == "reference"
    without = read_record(LOG, axis)
    assert without.injected is None
    assert "no test signal is considered" in str(without.provenance.assumed)
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


@pytest.mark.parametrize("named", ["p:bar", "#5:bar", "p:mbar*1000"])
def test_a_signal_is_found_by_name_number_and_unit(named: str, tmp_path: Path) -> None:
    log = columns(pressure=None, p=PRESSURE / 1e5)
    record = read_record(csv_file(tmp_path / "log.csv", log), AXIS, columns={"pressure": named})
    assert record.signals["pressure"] == pytest.approx(PRESSURE, rel=1e-12)
    assert record.provenance.columns["pressure"] == "p"


def test_a_signal_may_be_constant() -> None:
    record = read_record(columns(pressure=np.full(N, 6e5)), AXIS)
    assert np.ptp(record.signals["pressure"]) == 0


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
            'injected_at = "control"',
            INJECTED,
            None,
            {"columns": {"injected": "exc"}},
        ),
        ("test-signal", "", INJECTED, None, {"injected_at": "control"}),
        (
            "test-signal",
            'injected_at = "control"',
            *(INJECTED, None, {"columns": {"injected": "exc"}, "injected_at": "force"}),
        ),
        ("columns", "column 'pressure' for the pressure", LOG, AXIS, {}),
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
        ("record", "'force'", {**LOG, "signals": {"force": TIME}}),
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


def timed(record: Record, factor: float, **changes: Any) -> Record:
    """The record without its reference, by another clock."""
    changes = {"sample_period": None, "reference": None} | changes
    return replace(record, time=factor * record.time, **changes)


@pytest.mark.parametrize("factor", [0.5, 0.999, 0.9996, 1.0, 1.0004, 1.0006, 1000.0])
def test_other_time_fails_without_a_reference_but_crystals_may_differ(
    emps2015: GeneratedAxis, twin: Record, factor: float
) -> None:
    law = law_agreement(emps2015, timed(twin, factor))
    if abs(factor - 1) < 5e-4:
        assert isinstance(law, Missing)
        return
    kept = 1000 if factor == 1000 else None
    other = OtherPeriod(
        period=pytest.approx(factor * 1e-3), law_period=1e-3, kept=kept, is_given=False
    )
    assert (law.passed, law.finding) == (False, other)


@pytest.mark.slow
def test_every_result_fails_by_another_time(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, timed(twin, 1.05), methods=["idm-ls"])
    assert checks_of(result)["control law"].status == "fail"
    right = identify(emps2015, twin, methods=["idm-ls"])
    validated = validate(right, timed(twin, 1.05))
    assert DoubtfulTimeBase(reason=validated.time_base) in validated.notes
    assert validated.to_dict()["time_base"]
    assert validate(right, twin).to_dict()["time_base"] is None


def test_confirmation_is_that_of_the_log_that_was_read(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    read = read_record(twin.channels(), emps2015, sample_period=1e-3)
    changed = replace(read, time=1.05 * read.time, sample_period=None)
    assert not law_agreement(emps2015, changed).passed


def test_resampling_hides_no_other_time(emps2015: GeneratedAxis, twin: Record) -> None:
    slower = timed(twin, 2.0).channels()
    asked = Repairs(resample=1000.0)
    law = law_agreement(emps2015, read_record(slower, emps2015, repairs=asked))
    other = OtherPeriod(period=pytest.approx(2e-3), law_period=1e-3, kept=2, is_given=False)
    assert (law.passed, law.finding) == (False, other)
    confirmed = read_record(slower, emps2015, sample_period=2e-3, repairs=asked)
    assert isinstance(law_agreement(emps2015, confirmed), Missing)
    with refuses("time", says=r"0\.003 s, but the time column steps by 0\.002"):
        read_record(slower, emps2015, sample_period=3e-3, repairs=asked)
    finer = read_record(twin.channels(), emps2015, repairs=Repairs(resample=2000.0))
    assert isinstance(law_agreement(emps2015, finer), Missing)
    with refuses("loop-period", says=r"resampled every 0\.0005 s"):
        identify(emps2015, finer, methods=["idm-iv"])


@pytest.mark.parametrize("jitter", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("rows", [300, 7801])
def test_jitter_and_lost_samples_are_no_other_time(
    emps2015: GeneratedAxis, twin: Record, rng: np.random.Generator, jitter: float, rows: int
) -> None:
    time = twin.time + 1e-3 * rng.uniform(-jitter, jitter, len(twin))
    kept = np.flatnonzero(rng.random(rows) > 0.03)
    uneven = {role: values[kept] for role, values in (twin.channels() | {"time": time}).items()}
    for factor in (1.0, 1.05):
        log = uneven | {"time": factor * uneven["time"]}
        record = read_record(log, emps2015, repairs=Repairs(resample="auto", gaps="split"))
        law = law_agreement(emps2015, record)
        is_other = isinstance(law, LawAgreement) and isinstance(law.finding, OtherPeriod)
        assert is_other is (factor != 1.0)
