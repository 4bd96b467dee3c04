"""Files written by each format's own library are read back; damaged ones are refused."""

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import DataError, Repairs, UsageError, read_record

N = 50
T = 1e-3 * np.arange(N)
Q = np.sin(T * 200)
U = np.cos(T * 300)
NAMED = {"position": "q", "control": "u"}


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
    with pytest.raises(DataError, match="cannot be read as a NumPy archive: Object arrays"):
        read_record(file)


def test_parquet_with_time_stamps_and_units_of_its_fields(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    stamps = np.datetime64("2026-02-01T12:00:00") + np.round(1e6 * T).astype("timedelta64[us]")
    schema = pa.schema(
        [
            pa.field("time", pa.timestamp("us")),
            pa.field("q", pa.float64(), metadata={"unit": "deg"}),
            pa.field("u [mA]", pa.float64()),
            pa.field("state", pa.string()),
        ]
    )
    file = tmp_path / "log.parquet"
    parquet.write_table(pa.table([stamps, Q, U, ["run"] * N], schema=schema), file)
    record = read_record(file, columns=NAMED)
    assert record.time == pytest.approx(T, abs=1e-12)
    assert record.position == pytest.approx(np.radians(Q), rel=1e-15)
    assert record.control == pytest.approx(1e-3 * U, rel=1e-15)
    assert {"position: deg -> rad", "control: mA -> A"} <= set(record.provenance.assumed)
    assert "time: time stamps counted from the first" in record.provenance.assumed


@pytest.mark.parametrize("kind", ["mapping", "pandas", "polars", "pyarrow"])
def test_any_dataframe_of_a_script(kind: str) -> None:
    columns: dict[str, Any] = {"time": T, "q [mm]": Q, "u": U}
    frame: object = columns
    if kind != "mapping":
        pytest.importorskip("narwhals")
        library = pytest.importorskip(kind)
        frame = library.table(columns) if kind == "pyarrow" else library.DataFrame(columns)
    record = read_record(frame, columns=NAMED)
    assert record.position == pytest.approx(1e-3 * Q, rel=1e-15)
    assert np.array_equal(record.control, U)


def test_what_is_no_dataframe_is_refused() -> None:
    pytest.importorskip("narwhals")
    with pytest.raises(UsageError, match="the log is a int; give a path, a dataframe"):
        read_record(3)


def test_tdms_waveforms_have_their_own_time_and_unit(tmp_path: Path) -> None:
    nptdms = pytest.importorskip("nptdms")
    waveform = {"wf_increment": 1e-3, "wf_start_offset": 0.0, "wf_samples": N}
    file = tmp_path / "log.tdms"
    with nptdms.TdmsWriter(str(file)) as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("axis", "q", Q, waveform | {"unit_string": "mm"}),
                nptdms.ChannelObject("axis", "u", U, waveform),
            ]
        )
    record = read_record(file, columns=NAMED)
    assert record.time == pytest.approx(T, abs=1e-12)
    assert record.position == pytest.approx(1e-3 * Q, rel=1e-15)
    assert record.provenance.columns == {"position": "axis.q", "control": "axis.u"}


def test_tdms_that_breaks_off_says_so(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    nptdms = pytest.importorskip("nptdms")
    file = tmp_path / "log.tdms"
    with nptdms.TdmsWriter(str(file)) as writer:
        writer.write_segment([nptdms.ChannelObject("axis", "q", Q)])
    file.write_bytes(file.read_bytes()[:-80])
    record = read_record(file, columns={"position": "q"}, sample_period=1e-3)
    assert np.array_equal(record.position, Q[:-10])
    assert "less data than expected" in record.provenance.assumed[0]
    assert capfd.readouterr().err == ""


def test_mdf_groups_of_two_rates(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    file = tmp_path / "log.mf4"
    with asammdf.MDF(version="4.10") as mdf:
        mdf.append([asammdf.Signal(samples=Q, timestamps=T, name="q", unit="mm")])
        mdf.append([asammdf.Signal(samples=U[::2], timestamps=T[::2], name="u", unit="V")])
        mdf.save(file)
    with pytest.raises(DataError, match="position 50, control 25"):
        read_record(file, columns=NAMED)
    record = read_record(file, columns=NAMED, repairs=Repairs(resample="auto"))
    assert record.position == pytest.approx(1e-3 * Q[:49], abs=1e-12)
    assert np.asarray(record.control)[::2] == pytest.approx(U[::2], abs=1e-12)


def joint_states(types: Any, *, ros1: bool) -> list[tuple[int, Any]]:
    """Messages with their times, ns; the second joint comes first."""
    make = types["sensor_msgs/msg/JointState"]
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    found = []
    for k in range(N):
        now = 1_700_000_000_000_000_000 + 1_000_000 * k
        time = stamp(sec=now // 10**9, nanosec=now % 10**9)
        own = header(seq=k, stamp=time, frame_id="") if ros1 else header(stamp=time, frame_id="")
        message = make(
            header=own,
            name=["wrist", "elbow"],
            position=np.array([0.0, Q[k]]),
            velocity=np.array([]),
            effort=np.array([1.0, U[k]]),
        )
        found.append((now + 300, message))
    return found


def written_bag(tmp_path: Path, version: int) -> Path:
    module = pytest.importorskip(f"rosbags.rosbag{version}")
    stores = pytest.importorskip("rosbags.typesys")
    ros1 = version == 1
    which = stores.Stores.ROS1_NOETIC if ros1 else stores.Stores.LATEST
    store = stores.get_typestore(which)
    file = tmp_path / ("log.bag" if ros1 else "log")
    kind = "sensor_msgs/msg/JointState"
    with module.Writer(file) if ros1 else module.Writer(file, version=9) as writer:
        connection = writer.add_connection("/joint_states", kind, typestore=store)
        for now, message in joint_states(store.types, ros1=ros1):
            write = store.serialize_ros1 if ros1 else store.serialize_cdr
            writer.write(connection, now, write(message, kind))
    return file


@pytest.mark.parametrize("version", [1, 2])
def test_ros_bags_give_the_joints_of_their_joint_states(tmp_path: Path, version: int) -> None:
    file = written_bag(tmp_path, version)
    chosen = {"position": "elbow.position", "force": "elbow.effort"}
    for path in [file] if version == 1 else [file, next(file.glob("*.db3"))]:
        record = read_record(path, columns=chosen)
        assert record.time == pytest.approx(T, abs=1e-12)
        assert np.array_equal(record.position, Q)
        assert np.array_equal(record.force, U)
        assert len(record.provenance.sha256) == 64
    with pytest.raises(DataError, match=r"found wrist\.position, wrist\.effort, elbow\.position"):
        read_record(file)


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
    with pytest.raises(
        DataError, match=rf"needs the library {name}.*pip install {name}.*extra {extra}"
    ):
        read_record(file)


def test_extras_that_messages_name_are_declared(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    named = set()
    for file in (root / "estimation").glob("*.py"):
        named |= set(re.findall(r'library\("[\w.]+", "(\w+)"', file.read_text()))
    assert named == {"dataframe", "h5py", "mdf", "parquet", "rosbags", "tdms"}
    assert named <= set(project["optional-dependencies"])
