"""ROS bags (rosbags): the joints of JointState messages, all counted from one origin."""

import os
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.tables import Table, TableBuilder, library, refusing
from axisid.support.errors import DataError
from axisid.support.files.memory import Room

# typical steps from a stamp of zero to the next; beyond, there was no stamp
_MAX_FIRST_STAMP = 1000

_JOINT_STATE = "sensor_msgs/msg/JointState"
_KINDS = ("position", "velocity", "effort")
_NANOSECOND = 1e-9
_METADATA = "metadata.yaml"
_HELD = 1500  # bytes that a message takes beside its own


#: Time in ns by the topic's clock, None where the message does not give it; and the JointState.
_Message = tuple[int | None, Any]


def read_bag(path: Path, room: Room) -> Table:
    """Read the JointState messages of a ROS 1 bag or a ROS 2 bag (its folder, or a file of it).

    Columns are ``JOINT.position``, ``JOINT.velocity`` and ``JOINT.effort``, before them the topic
    where several have such messages. Times are those of the messages' headers, or of a topic
    without such times those of recording, and count from the earliest of all topics.

    Raises
    ------
    DataError
        It is damaged, has no such messages or more than there is room for, or rosbags is not
        installed.
    """
    topics, others = _read(path, room)
    times = [time for messages, _ in topics.values() for time, _ in messages if time is not None]
    origin = min(times, default=0)
    found = TableBuilder(room=room)
    for topic, (messages, note) in topics.items():
        before = f"{topic.strip('/')}." if len(topics) > 1 else ""
        for name in _add_joints(found, before, messages, origin):
            found.note(name, f"{topic}: {note}")
    return found.table(
        str(path),
        notes=("ROS bag, JointState in SI",),
        advice=f"of messages {_JOINT_STATE} are read, and it has {', '.join(others) or 'none'}",
    )


def is_bag(path: Path) -> bool:
    """Whether a folder is a ROS 2 bag."""
    return os.path.isfile(path / _METADATA)


def bag_of(path: Path) -> Path:
    """What is read of a bag's path: of a file of a ROS 2 bag its folder, where it has one.

    A file that was passed on alone has no metadata beside it.
    """
    whole = path.suffix.lower() != ".bag" and path.is_file() and is_bag(path.parent)
    return path.parent if whole else path


def _read(path: Path, room: Room) -> tuple[dict[str, tuple[list[_Message], str]], list[str]]:
    """Messages by topic, each with what was assumed of their times, and the types of all."""
    highlevel = library("rosbags.highlevel", "rosbags", path)
    stores = library("rosbags.typesys", "rosbags", path)
    topics = {}
    with refusing(DataError(f"{path} cannot be read as a ROS bag", code="damaged-rosbag")):
        usual = stores.get_typestore(stores.Stores.LATEST)
        with highlevel.AnyReader([bag_of(path)], default_typestore=usual) as reader:
            others = sorted({c.msgtype for c in reader.connections})
            for topic in dict.fromkeys(
                c.topic for c in reader.connections if c.msgtype == _JOINT_STATE
            ):
                topics[topic] = _messages(reader, topic, room)
    return topics, others


def _messages(reader: Any, topic: str, room: Room) -> tuple[list[_Message], str]:
    """Messages of a topic in the order of their times, and which times these are."""
    chosen = [c for c in reader.connections if c.topic == topic and c.msgtype == _JOINT_STATE]
    recorded, stamps, found = [], [], []
    for connection, time, raw in reader.messages(connections=chosen):
        room.take(len(raw) + _HELD)
        message = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        recorded.append(time)
        stamps.append(stamp.sec * 10**9 + stamp.nanosec)
        found.append(message)
    if not any(stamps):
        times: list[int | None] = [*recorded]
        note = "its messages have no time, so that of their recording"
    else:
        times, lost = _stamped(stamps)
        note = "time of the messages' headers"
        note += f"; {lost} of {len(stamps)} have none" if lost else ""
    order, last = [], 0
    for time in times:  # one without a time stays behind the one before it
        last = last if time is None else time
        order.append(last)
    early = sum(time < latest for time, latest in zip(order, accumulate(order, max), strict=True))
    note += f"; {early} of {len(order)} came after later ones and were sorted" if early else ""
    ranked = sorted(range(len(found)), key=lambda k: order[k])
    return [(times[k], found[k]) for k in ranked], note


def _stamped(stamps: list[int]) -> tuple[list[int | None], int]:
    """Times of headers; a zero is none, but for one that a clock from zero begins with."""
    later = np.sort([stamp for stamp in stamps if stamp])
    typical = float(np.median(np.diff(later))) if len(later) > 1 else 0.0
    begins = stamps.count(0) == 1 and later[0] <= _MAX_FIRST_STAMP * typical
    times = [stamp if stamp or begins else None for stamp in stamps]
    return times, times.count(None)


def _add_joints(
    found: TableBuilder, before: str, messages: list[_Message], origin: int
) -> Iterator[str]:
    """Take the joints of a topic, and name them."""
    joints = dict.fromkeys(name for _, state in messages for name in state.name)
    for joint in joints:
        places = [(t, m, list(m.name).index(joint)) for t, m in messages if joint in m.name]
        # Counted in integers first, or a double would lose the nanoseconds.
        since = [np.nan if time is None else (time - origin) * _NANOSECOND for time, *_ in places]
        for kind in _KINDS:
            lists = [(getattr(m, kind), k) for _, m, k in places]  # which may be empty
            if any(k < len(entries) for entries, k in lists):
                values = np.array(
                    [entries[k] if k < len(entries) else np.nan for entries, k in lists]
                )
                name = f"{before}{joint}.{kind}"
                found.add(name, values, clock=np.array(since))
                yield name
