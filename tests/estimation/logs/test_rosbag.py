"""Joints of ROS bags are read with the times of their messages."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import Record, read_record
from axisid.estimation import Repairs
from tests.estimation.logs.samples import N, Q, T, U
from tests.refusals import refuses

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
    with refuses("time", says="position and the reference"):
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
    told = (
        "time of the messages' headers; 4 of 50 messages came after later messages and were sorted"
    )
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
