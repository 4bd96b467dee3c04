"""Read ROS bags with rosbags: the joints of JointState messages, timed from one origin."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.raw_tables import Table, TableBuilder
from axisid.support.libraries import library, refusing
from axisid.support.memory import Room

_JOINT_STATE = "sensor_msgs/msg/JointState"
_CALENDAR = 10**17  # ns, in 1973, beyond which a clock is one of the calendar


def read_bag(path: Path, room: Room) -> Table:
    """Return the joints of the JointState messages of a ROS 1 bag, or a ROS 2 bag.

    A ROS 2 bag is given by its folder, or by a file in it. Columns are ``JOINT.position``,
    ``JOINT.velocity`` and ``JOINT.effort``; the topic precedes the name if several topics have such
    messages. Times are those of the messages' headers. If headers of a topic have no time, its
    times are those of recording. All times count from the earliest one of all topics.

    Raises
    ------
    DataError
        The bag is damaged, has no such messages, needs more memory than there is, or rosbags is not
        installed.
    """
    highlevel = library("rosbags.highlevel", "rosbags", path)
    stores = library("rosbags.typesys", "rosbags", path)
    with (
        refusing(f"{path} cannot be read as a ROS bag (write it anew)"),
        highlevel.AnyReader(
            [bag_of(path)], default_typestore=stores.get_typestore(stores.Stores.LATEST)
        ) as reader,
    ):
        others = sorted({c.msgtype for c in reader.connections})
        names = dict.fromkeys(c.topic for c in reader.connections if c.msgtype == _JOINT_STATE)
        topics = {topic: _joints(reader, topic, room) for topic in names}
    origin = min((int(times.min()) for times, *_ in topics.values() if len(times)), default=0)
    builder = TableBuilder(room=room)
    for topic, (times, note, joints) in topics.items():
        before = f"{topic.strip('/')}." if len(topics) > 1 else ""
        for name, values in joints.items():
            rows = sorted(values, key=lambda row: times[row])
            # Counted in integers first, or a double would lose the nanoseconds.
            builder.add(
                f"{before}{name}",
                [values[row] for row in rows],
                clock=(times[rows] - origin).astype(np.float64) * 1e-9,
                note=f"{topic}: {note}",
            )
    return builder.table(
        str(path),
        notes=("ROS bag, JointState in SI",),
        advice=f"only messages {_JOINT_STATE} are read, and it has {', '.join(others) or 'none'}",
    )


def is_bag(path: Path) -> bool:
    """Return True if a folder is a ROS 2 bag."""
    return os.path.isfile(path / "metadata.yaml")


def bag_of(path: Path) -> Path:
    """Return the path to read for a bag: the folder of a ROS 2 bag for a file in it.

    A file that was passed on alone has no metadata next to it.
    """
    whole = path.suffix.lower() != ".bag" and path.is_file() and is_bag(path.parent)
    return path.parent if whole else path


def _joints(
    reader: Any, topic: str, room: Room
) -> tuple[NDArray[np.int64], str, dict[str, dict[int, float]]]:
    """Return the times of a topic's messages, ns, a note on them, and values by joint and message.

    If a header of the topic has no time, all times are those of recording.
    """
    chosen = [c for c in reader.connections if c.topic == topic and c.msgtype == _JOINT_STATE]
    recorded, stamps = [], []
    joints: dict[str, dict[int, float]] = {}
    for row, (connection, time, raw) in enumerate(reader.messages(connections=chosen)):
        room.take(len(raw) + 1500)  # which a message takes beside its own bytes
        message = reader.deserialize(raw, connection.msgtype)
        recorded.append(time)
        stamps.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)
        for k, joint in enumerate(message.name):
            for kind in ("position", "velocity", "effort"):
                for value in getattr(message, kind)[k : k + 1]:  # which may be empty
                    joints.setdefault(f"{joint}.{kind}", {})[row] = value
    note = "time of the messages' headers"
    # A clock may begin at zero, one of the calendar does not.
    if 0 in stamps[1:] or (0 in stamps and max(stamps) > _CALENDAR):
        stamps = recorded
        note = "time of recording, because not all messages have a time"
    times = np.array(stamps, dtype=np.int64)
    early = int(np.sum(times < np.maximum.accumulate(times)))
    note += f"; {early} of {len(times)} came after later ones and were sorted" if early else ""
    return times, note, joints
