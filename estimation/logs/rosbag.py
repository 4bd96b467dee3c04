"""Reading of ROS bags with rosbags: the joints of JointState messages, timed from one origin."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.raw_tables import Table, TableBuilder
from axisid.support.libraries import library, refusing
from axisid.support.memory import Room

_JOINT_STATE = "sensor_msgs/msg/JointState"
_CALENDAR = 10**17  # ns since 1970, in 1973: a later time is a date


def read_bag(path: Path, room: Room) -> Table:
    """Return the table of the joints in the JointState messages of a ROS 1 bag or ROS 2 bag.

    A ROS 2 bag is given by its folder, or by a file in the folder. Columns are ``JOINT.position``,
    ``JOINT.velocity`` and ``JOINT.effort``; the topic precedes the name if several topics have such
    messages. Times are those of the messages' headers. If headers of a topic have no time, its
    times are those of recording. All times count from the earliest time of all topics.

    Raises
    ------
    DataError
        The bag is damaged, has no JointState messages, needs more memory than is available, or
        rosbags is not installed.
    """
    highlevel = library("rosbags.highlevel", "rosbags", path)
    stores = library("rosbags.typesys", "rosbags", path)
    with (
        refusing(f"{path} cannot be read as a ROS bag. Record the bag again. The error is"),
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
            # The difference is one of integers, as a double would lose the nanoseconds.
            builder.add(
                f"{before}{name}",
                [values[row] for row in rows],
                clock=(times[rows] - origin).astype(np.float64) * 1e-9,
                note=f"{topic}: {note}",
            )
    return builder.table(
        str(path),
        notes=("ROS bag, JointState in SI",),
        advice=f"record messages of the type {_JOINT_STATE}; the bag has messages of the types "
        f"{', '.join(others) or 'none'}",
    )


def is_bag(path: Path) -> bool:
    """Return True if a path is the folder of a ROS 2 bag."""
    return os.path.isfile(path / "metadata.yaml")


def bag_of(path: Path) -> Path:
    """Return the path to read for a bag: for a file of a ROS 2 bag its folder, else the path.

    The path of a file is also returned if there is no metadata next to the file.
    """
    whole = path.suffix.lower() != ".bag" and path.is_file() and is_bag(path.parent)
    return path.parent if whole else path


def _joints(
    reader: Any, topic: str, room: Room
) -> tuple[NDArray[np.int64], str, dict[str, dict[int, float]]]:
    """Return the joints of a topic.

    Returns
    -------
    (n,) array of int
        Time of each message, ns: of its header, or of recording if a header has no time.
    str
        Note on the times.
    dict of str to dict of int to float
        Values by joint and quantity (``JOINT.position``), and by number of the message.
    """
    chosen = [c for c in reader.connections if c.topic == topic and c.msgtype == _JOINT_STATE]
    recorded, stamps = [], []
    joints: dict[str, dict[int, float]] = {}
    for row, (connection, time, raw) in enumerate(reader.messages(connections=chosen)):
        room.take(len(raw) + 1500)  # a message takes about 1500 bytes in addition to its content
        message = reader.deserialize(raw, connection.msgtype)
        recorded.append(time)
        stamps.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)
        for k, joint in enumerate(message.name):
            for kind in ("position", "velocity", "effort"):
                for value in getattr(message, kind)[k : k + 1]:  # a message may lack a quantity
                    joints.setdefault(f"{joint}.{kind}", {})[row] = value
    note = "time of the messages' headers"
    # A time of 0 is missing, unless it is the first time of a clock that begins at 0.
    if 0 in stamps[1:] or (0 in stamps and max(stamps) > _CALENDAR):
        stamps = recorded
        note = "time of recording, because not all messages have a time"
    times = np.array(stamps, dtype=np.int64)
    early = int(np.sum(times < np.maximum.accumulate(times)))
    if early:
        note += f"; {early} of {len(times)} messages came after later messages and were sorted"
    return times, note, joints
