"""Files of each format, by its own library or as writers give JSON, are read back or refused."""

import gzip
import json
import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest

from axisid import DataError, Record, load_axis, read_record
from axisid.estimation import Repairs
from tests.files import text_file
from tests.refusals import refuses

N = 50
T = 1e-3 * np.arange(N)
Q = np.sin(T * 200)
U = np.cos(T * 300)
NAMED = {"position": "q", "control": "u"}
STAMPS = np.datetime64("2026-02-01T12:00:00") + np.round(1e6 * T).astype("timedelta64[us]")


def test_numpy_archive(tmp_path: Path) -> None:
    file = tmp_path / "log.npz"
    joint = np.zeros(N, dtype=[("q", float), ("u", float)])
    joint["q"], joint["u"] = Q, U
    np.savez(file, time=T, joint=joint, M=np.column_stack([T, 2 * Q]), kp=np.array(3.0))
    record = read_record(file, columns=NAMED | {"reference": "M.2"})
    assert np.array_equal(record.position, Q)
    assert np.array_equal(record.control, U)
    assert np.array_equal(record.reference, 2 * Q)


def test_numpy_archive_of_objects_is_refused_since_it_could_run_code(tmp_path: Path) -> None:
    file = tmp_path / "log.npz"
    np.savez(file, time=np.array([{}, {}], dtype=object))
    with refuses("columns", says=r"time: Python objects, which could"):
        read_record(file)
    np.savez(file, time=T, position=Q, comment=np.array([{}], dtype=object))
    assert np.array_equal(read_record(file).position, Q)


def test_parquet_with_time_stamps_and_units_of_its_fields(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    schema = pa.schema(
        [
            pa.field("time", pa.timestamp("us")),
            pa.field("q", pa.float64(), metadata={"unit": "deg"}),
            pa.field("u [mA]", pa.float64()),
            pa.field("state", pa.string()),
        ]
    )
    file = tmp_path / "log.parquet"
    parquet.write_table(pa.table([STAMPS, Q, U, ["run"] * N], schema=schema), file)
    record = read_record(file, columns=NAMED)
    assert record.time == pytest.approx(T, abs=1e-12)
    assert record.position == pytest.approx(np.radians(Q), rel=1e-15)
    assert record.control == pytest.approx(1e-3 * U, rel=1e-15)
    assert {"position: deg -> rad", "control: mA -> A"} <= set(record.provenance.assumed)
    assert "time: time stamps, relative to the first" in record.provenance.assumed


@pytest.mark.parametrize("kind", ["mapping", "pandas", "polars", "pyarrow"])
def test_any_dataframe_of_a_script(kind: str) -> None:
    makers = {"mapping": "dict", "pyarrow": "table"}
    pytest.importorskip("narwhals")
    library = pytest.importorskip("builtins" if kind == "mapping" else kind)
    frame = getattr(library, makers.get(kind, "DataFrame"))({"time": T, "q [mm]": Q, "u": U})
    record = read_record(frame, columns=NAMED)
    assert record.position == pytest.approx(1e-3 * Q, rel=1e-15)
    assert np.array_equal(record.control, U)


def test_dataframe_without_one_name_for_each_column_is_explained() -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("narwhals")
    twice = pandas.DataFrame(np.column_stack([T, Q, Q]), columns=["time", "q", "q"])
    with refuses("log-file", says="'q' 2 times"):
        read_record(twice)
    levels = pandas.MultiIndex.from_tuples([("axis", "time"), ("axis", "position")])
    nested = pandas.DataFrame(np.column_stack([T, Q]), columns=levels)
    assert np.array_equal(read_record(nested).position, Q)
    indexed = pandas.DataFrame({"time": T, "position": Q}).set_index("time")
    with refuses("time", says=r"log\.reset_index"):
        read_record(indexed)


def test_time_stamp_that_is_missing_does_not_spoil_the_others() -> None:
    log = {"time": np.where(T > 0, STAMPS, np.datetime64("NaT")), "position": Q}
    with refuses("empty-cells", says=r"1 \(1 of 50 "):
        read_record(log)
    record = read_record(log, repairs=Repairs(resample="auto"))
    assert record.provenance.repairs[0].count == 1
    assert record.position == pytest.approx(Q[1:], abs=1e-9)


def tdms(file: Path, **channels: tuple[Any, dict[str, Any]]) -> Path:
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(str(file)) as writer:
        writer.write_segment(
            [nptdms.ChannelObject("axis", name, *each) for name, each in channels.items()]
        )
    return file


def test_tdms_waveforms_keep_the_time_between_their_starts(tmp_path: Path) -> None:
    start = np.datetime64("2026-02-01T12:00:00", "us")
    first, later = (
        {"wf_increment": 1e-3, "wf_start_time": start + np.timedelta64(delay, "us")}
        for delay in (0, 10_000)
    )
    file = tdms(
        tmp_path / "log.tdms",
        q=(1e3 * Q, {**first, "unit_string": "mm"}),
        u=(U, later),
        v=(U, {"wf_increment": 1e-3}),
    )
    with refuses("time", says="position and control"):
        read_record(file, columns=NAMED)
    record = read_record(file, columns=NAMED, repairs=Repairs(resample=1000.0))
    assert record.position == pytest.approx(Q[10:], abs=1e-9)
    assert record.control == pytest.approx(U[:-10], abs=1e-9)
    timeless = read_record(file, columns={"position": "q", "control": "v"})
    assert any("no wf_start_time" in note for note in timeless.provenance.assumed)


def test_tdms_that_breaks_off_says_so(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tdms(tmp_path / "log.tdms", q=(Q, {}))
    file.write_bytes(file.read_bytes()[:-80])
    record = read_record(file, columns={"position": "q"}, sample_period=1e-3)
    assert np.array_equal(record.position, Q[:-10])
    assert "less data than expected" in record.provenance.assumed[0]
    assert capfd.readouterr().err == ""


def mdf(file: Path, *groups: list[tuple[np.ndarray, np.ndarray, str, str]], **more: Any) -> Path:
    """A file of groups, each of channels: samples, their times, a name and a unit."""
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as content:
        for group in groups:
            content.append(
                [asammdf.Signal(x, t, name=name, unit=u, **more) for x, t, name, u in group]
            )
        content.save(file, overwrite=True)
    return file


def test_mdf_channels_of_one_name_in_one_group_stay_apart(tmp_path: Path) -> None:
    groups = [(Q, T, "q", ""), (Q + 1, T, "q", "")], [(Q + 2, T, "0.q", "")], [(Q + 3, T, "q", "")]
    file = mdf(tmp_path / "log.mf4", *groups)
    for k, name in enumerate(("0.1.q", "0.2.q", "0.q", "2.q")):
        assert np.array_equal(read_record(file, columns={"position": name}).position, Q + k)
    with refuses("columns", says=r"0\.1\.q, 0\.2\.q, 2\.q, 1\.1\.0\.q"):
        read_record(file, columns={"position": "q"})


def test_mdf_samples_marked_as_invalid_are_told_and_counted(tmp_path: Path) -> None:
    invalid = np.isin(np.arange(N), [5, 7])
    file = mdf(tmp_path / "log.mf4", [(Q, T, "q", "")], invalidation_bits=invalid)
    with refuses("empty-cells", says=r"position is nan in data row 6 \(2 of 50"):
        read_record(file, columns={"position": "q"})
    record = read_record(file, columns={"position": "q"}, repairs=Repairs(resample="auto"))
    empty = record.provenance.repairs[0]
    assert (empty.kind, empty.count) == ("empty", 2)
    assert "q: 2 samples are marked as invalid" in record.provenance.assumed


ENDINGS = {
    ".npz": "numpy",
    ".parquet": "pyarrow",
    ".tdms": "nptdms",
    ".mf4": "asammdf",
    ".bag": "rosbags",
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_damaged_files_are_explained(tmp_path: Path, ending: str) -> None:
    pytest.importorskip(ENDINGS[ending])
    file = tmp_path / f"log{ending}"
    file.write_bytes(b"not what it seems" * 20)
    with pytest.raises(DataError, match=rf"log\{ending} cannot be read as an? ") as caught:
        read_record(file)
    assert not str(caught.value).endswith("..")


@pytest.mark.parametrize(
    ("ending", "library", "extra"),
    [
        (".parquet", "pyarrow.parquet", "parquet"),
        (".tdms", "nptdms", "tdms"),
        (".mf4", "asammdf", "mdf"),
        (".bag", "rosbags.highlevel", "rosbags"),
    ],
)
def test_library_that_is_not_installed_is_named_with_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, library: str, extra: str
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    file = tmp_path / f"log{ending}"
    file.write_bytes(b"x")
    name = library.partition(".")[0]
    with refuses(
        "missing-library", says=rf"needs the library {name}.*pip install {name}.*extra {extra}"
    ):
        read_record(file)


@pytest.mark.parametrize("declared", ["t", "time"])
def test_time_column_that_the_axis_declares_gives_way_to_the_files_own_clocks(
    tmp_path: Path, declared: str
) -> None:
    """The logger of the axis writes a time column; this file has masters in its place."""
    axis = replace(
        load_axis("emps2015"), columns={"time": declared, "position": "q", "control": "u"}
    )
    both = [(Q, T, "q", ""), (U, T, "u", "")]
    file = mdf(tmp_path / "log.mf4", both)
    for given in (None, 1e-3):
        record = read_record(file, axis, sample_period=given)
        assert record.time == pytest.approx(T)
        told = f"no column {declared!r} for the time, the clocks in the file are used"
        assert told in record.provenance.assumed
    mdf(file, both, [(T[::2] + 9, T[::2], declared, "")])
    record = read_record(file, axis)
    assert record.time == pytest.approx(T)
    assert record.provenance.columns == {"position": "q", "control": "u"}
    assert any("has 25 rows, the position 50" in said for said in record.provenance.assumed)
    with refuses("time", says="the columns differ in length"):
        read_record(file, axis, columns={"time": declared})


KIND = "sensor_msgs/msg/JointState"
EPOCH = 1_700_000_000_000_000_000
MILLISECOND = 1_000_000
ELBOW = {"position": "elbow.position", "force": "elbow.effort"}


Message = tuple[str, int, int, list[float]]


def bag_of(tmp_path: Path, messages: list[Message], version: int = 2) -> Path:
    """Messages by topic, with their times of recording and their stamps, ns, and their effort.

    Each is of two joints, of which the elbow comes second.
    """
    module = pytest.importorskip(f"rosbags.rosbag{version}")
    stores = pytest.importorskip("rosbags.typesys")
    ros1 = version == 1
    store = stores.get_typestore(stores.Stores.ROS1_NOETIC if ros1 else stores.Stores.LATEST)
    types: Any = store.types
    make, header = types[KIND], types["std_msgs/msg/Header"]
    write = store.serialize_ros1 if ros1 else store.serialize_cdr
    connections: dict[str, Any] = {}
    file = tmp_path / ("log.bag" if ros1 else "log")
    with module.Writer(file) if ros1 else module.Writer(file, version=9) as writer:
        for k, (topic, recorded, stamp, effort) in enumerate(messages):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, KIND, typestore=store)
            at = types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
            message = make(
                header=header(stamp=at, frame_id="", **({"seq": k} if ros1 else {})),
                name=["wrist", "elbow"],
                position=np.array([0.0, Q[k % N]]),
                velocity=np.array([]),
                effort=np.array([1.0, *effort] if effort else []),
            )
            writer.write(connections[topic], recorded, write(message, KIND))
    return file


def written_bag(tmp_path: Path, version: int) -> Path:
    times = [EPOCH + k * MILLISECOND for k in range(N)]
    messages = [("/joint_states", now + 300, now, [u]) for now, u in zip(times, U, strict=True)]
    return bag_of(tmp_path, messages, version)


@pytest.mark.parametrize("version", [1, 2])
def test_ros_bags_give_the_joints_of_their_joint_states(tmp_path: Path, version: int) -> None:
    file = written_bag(tmp_path, version)
    for path in [file] if version == 1 else [file, next(file.glob("*.db3"))]:
        record = read_record(path, columns=ELBOW)
        assert record.time == pytest.approx(T, abs=1e-12)
        assert np.array_equal(record.position, Q)
        assert np.array_equal(record.force, U)
        assert len(record.provenance.sha256) == 64
    with refuses("columns", says=r"wrist\.position, wrist\.effort, elbow\.position"):
        read_record(file)


def test_file_of_a_bag_that_was_passed_on_alone_is_read(tmp_path: Path) -> None:
    bag = written_bag(tmp_path, 2)
    alone = tmp_path / "elsewhere"
    alone.mkdir()
    file = shutil.copy(next(bag.glob("*.db3")), alone)
    assert np.array_equal(read_record(file, columns=ELBOW).position, Q)


def test_topics_that_begin_apart_stay_apart(tmp_path: Path) -> None:
    late = 10 * MILLISECOND
    measured = [
        ("/meas", EPOCH + k * MILLISECOND, EPOCH + k * MILLISECOND, [1.0 * k]) for k in range(N)
    ]
    commanded = [("/cmd", now, stamp + late, [0.0]) for _, now, stamp, _ in measured]
    file = bag_of(tmp_path, measured + commanded)
    columns = {"position": "meas.elbow.position", "reference": "cmd.elbow.position"}
    with refuses("time", says="position and reference"):
        read_record(file, columns=columns)
    record = read_record(file, columns=columns, repairs=Repairs(resample=1000.0))
    assert record.position == pytest.approx(Q[10:], abs=1e-9)
    assert record.reference == pytest.approx(Q[:-10], abs=1e-9)


def stamped(tmp_path: Path, stamp: Callable[[int], int], **settings: Any) -> Record:
    messages = [("/js", EPOCH + k * MILLISECOND, stamp(k), [float(U[k])]) for k in range(N)]
    return read_record(bag_of(tmp_path, messages), columns=ELBOW, **settings)


@pytest.mark.parametrize(
    ("stamp", "told"),
    [
        (lambda k: EPOCH + k * MILLISECOND, "time of the messages' headers"),
        (lambda k: k * MILLISECOND, "time of the messages' headers"),
        (lambda k: (k + 1) * MILLISECOND, "time of the messages' headers"),
        *(
            (stamp, "time of recording, because not all messages have a time")
            for stamp in (lambda k: k and EPOCH + k * MILLISECOND, lambda _: 0)
        ),
    ],
)
def test_it_is_said_which_time_is_taken(
    tmp_path: Path, stamp: Callable[[int], int], told: str
) -> None:
    record = stamped(tmp_path, stamp)
    assert record.time == pytest.approx(T, abs=1e-9)
    assert f"/js: {told}" in record.provenance.assumed


def test_messages_out_of_the_order_of_their_times_are_sorted_and_counted(tmp_path: Path) -> None:
    def swapped(k: int) -> int:
        return EPOCH + {20: 21, 21: 20, 30: 33, 33: 30}.get(k, k) * MILLISECOND

    record = stamped(tmp_path, swapped)
    assert record.time == pytest.approx(T, abs=1e-9)
    assert record.position[20:22] == pytest.approx(Q[[21, 20]])
    told = "time of the messages' headers; 4 of 50 came after later ones and were sorted"
    assert f"/js: {told}" in record.provenance.assumed


@pytest.mark.parametrize("lost", [(20,), (20, 30)])
def test_where_a_message_has_no_time_those_of_recording_are_taken(
    tmp_path: Path, lost: tuple[int, ...]
) -> None:
    record = stamped(tmp_path, lambda k: 0 if k in lost else EPOCH + 2 * k * MILLISECOND)
    assert record.time == pytest.approx(T, abs=1e-12)
    assert np.array_equal(record.position, Q)
    told = "/js: time of recording, because not all messages have a time"
    assert told in record.provenance.assumed


COLUMNS: dict[str, list[float]] = {
    "time": T.tolist(),
    "position": Q.tolist(),
    "control": U.tolist(),
}
ROWS = [list(row) for row in zip(*COLUMNS.values(), strict=True)]
RECORDS = [dict(zip(COLUMNS, row, strict=True)) for row in ROWS]
NUMBERED = {"time": "#1", "position": "#2", "control": "#3"}


def lines(each: Any) -> str:
    return "\n".join(map(json.dumps, each))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("arrays.json", json.dumps(COLUMNS)),
        ("below.json", json.dumps({"log": {"axis": COLUMNS}, "made by": "a drive"})),
        (
            "unit.json",
            json.dumps(
                {
                    **COLUMNS,
                    "position": {"unit": "m", "values": COLUMNS["position"]},
                    "time [ms]": (1e3 * T).tolist(),
                }
                | {"time": None}
            ),
        ),
        ("records.json", json.dumps(RECORDS)),
        ("nested.json", json.dumps([{"axis": record} for record in RECORDS])),
        (
            "entries.json",
            json.dumps({"mass": 0.7, "entries": RECORDS, "events": [{"at": 0.1, "of": "stop"}]}),
        ),
        ("rows.json", json.dumps([[*COLUMNS], *ROWS])),
        ("split.json", json.dumps({"columns": [*COLUMNS], "data": ROWS})),
        (
            "pandas.json",
            json.dumps({k: {str(i): x for i, x in enumerate(v)} for k, v in COLUMNS.items()}),
        ),
        ("records.jsonl", lines(RECORDS)),
        ("records.ndjson", lines(RECORDS) + "\n\n"),
        ("rows.jsonl", lines([[*COLUMNS], *ROWS])),
    ],
)
def test_every_shape_is_the_same_record(tmp_path: Path, name: str, text: str) -> None:
    file = text_file(tmp_path / name, text)
    record = read_record(file)
    assert record.position == pytest.approx(COLUMNS["position"], abs=1e-15)
    assert record.time == pytest.approx(T, abs=1e-12)
    assert np.asarray(record.control) == pytest.approx(COLUMNS["control"], abs=1e-15)


def test_rows_without_names_are_called_by_number(tmp_path: Path) -> None:
    file = text_file(tmp_path / "rows.jsonl", lines(ROWS))
    assert len(read_record(file, columns=NUMBERED)) == N


def test_time_stamps_and_packed_files_are_read(tmp_path: Path) -> None:
    stamps = [f"2026-02-01T12:00:00.{round(1e3 * t):03d}Z" for t in T]
    file = tmp_path / "log.jsonl.gz"
    records = [{**r, "time": s} for r, s in zip(RECORDS, stamps, strict=True)]
    file.write_bytes(gzip.compress(lines(records).encode()))
    record = read_record(file)
    assert record.time == pytest.approx(T, abs=1e-9)
    assert "time stamps, relative to the first" in " ".join(record.provenance.assumed)


def test_what_is_missing_in_a_record_is_an_empty_cell(tmp_path: Path) -> None:
    lacking = [{**record} for record in RECORDS]
    del lacking[7]["position"]
    text = json.dumps([*lacking[:9], lacking[9] | {"position": None}, *lacking[10:]])
    with refuses("empty-cells", r"data row 8 \(2 of 50"):
        read_record(text_file(tmp_path / "log.json", text))


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("log.json", "{1", "JSON: expecting property name"),
        ("log.jsonl", '{"time": 1}\n{"time":', "line 2"),
        ("log.json", "[" * 100_000, "nested too deep"),
        ("log.json", '{"a": "b"}', "no columns of numbers"),
        ("log.json", "[]", "no columns of numbers"),
        ("log.json", "3", "no columns of numbers"),
        ("log.json", "[[1, 2], [3]]", "no columns of numbers"),
        ("log.jsonl", lines([*RECORDS, [1, 2, 3]]), "no columns of numbers"),
        ("log.json", '{"a": [[1], [2]], "b": ["x", "y"]}', "b: text"),
        ("log.json", '{"schema": "axisid.stream/1"}', "a result of axisid"),
        ("log.csv", json.dumps(RECORDS), "file the ending .json, or .jsonl"),
    ],
)
def test_what_is_no_log_is_told(tmp_path: Path, name: str, text: str, said: str) -> None:
    file = text_file(tmp_path / name, text)
    with pytest.raises(DataError, match=said):
        read_record(file)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("log.json", '{"time": [0, 1, 2], "position": [0, 1, 2], "position": [3, 4, 5]}'),
        ("log.json", '[{"time": 0, "position": 1, "position": 2}, {"time": 1, "position": 1}]'),
        ("log.jsonl", '{"time": 0, "position": 1, "position": 2}\n{"time": 1, "position": 1}'),
        ("log.json", '{"a": {"b": [1, 2, 3]}, "a.b": [1, 2, 4]}'),
        ("log.json", '[{"a": {"b": 1}, "a.b": 2}, {"a": {"b": 1}, "a.b": 2}]'),
        ("log.json", '[["time", "time"], [0, 1], [1, 2]]'),
        ("log.json", '{"position": {"unit": "mm", "unit": "m", "values": [2, 3]}}'),
    ],
)
def test_a_name_that_occurs_twice_in_json_is_refused(tmp_path: Path, name: str, text: str) -> None:
    with refuses("columns", says="occurs twice"):
        read_record(text_file(tmp_path / name, text))


def test_a_name_that_occurs_twice_in_an_archive_is_refused(tmp_path: Path) -> None:
    clash = tmp_path / "clash.npz"
    np.savez(clash, **{"data": np.column_stack([T, Q]), "data.1": T})
    twice = tmp_path / "twice.npz"
    np.savez(twice, time=T, position=Q)
    with ZipFile(twice, "a") as packed, pytest.warns(UserWarning, match="Duplicate"):
        packed.writestr("position.npy", packed.read("position.npy"))
    for file in (clash, twice):
        with refuses("columns", says="occurs twice"):
            read_record(file)


@pytest.mark.parametrize("kind", ["json", "records", "mapping", "dataframe"])
def test_truths_among_numbers_are_no_column(tmp_path: Path, kind: str) -> None:
    """A column of nothing else is one, as of a switch."""
    pandas = pytest.importorskip("pandas")
    columns = {
        "time": T.tolist(),
        "position": Q.tolist(),
        "on": [False, *[True] * (N - 1)],
        "u": [True, *U[1:].tolist()],
    }
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    logs: dict[str, Any] = {
        "json": lambda: text_file(tmp_path / "log.json", json.dumps(columns)),
        "records": lambda: text_file(tmp_path / "log.json", json.dumps(rows)),
        "mapping": lambda: columns,
        "dataframe": lambda: pandas.DataFrame(columns),
    }
    log = logs[kind]()
    assert read_record(log, columns={"control": "on"}).control.sum() == N - 1
    with refuses("columns", says="true or false among numbers"):
        read_record(log, columns={"control": "u"})
