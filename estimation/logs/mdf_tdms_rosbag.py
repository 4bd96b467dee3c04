"""Files of measurement systems: MDF (asammdf), TDMS (npTDMS) and ROS bags (rosbags).

Of a bag the joints of JointState messages are read, all counted from one origin.
"""

import logging
import os
import textwrap
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.raw_tables import Table, TableBuilder, numbered
from axisid.support.libraries import library, one_line, refusing
from axisid.support.memory import Room


def read_mdf(file: Path, room: Room) -> Table:
    """Read an MDF file; a channel has the master time of its group, and its unit.

    Channels whose names occur several times are named ``GROUP.NAME``, groups numbered from 0 as in
    MDF tools; where that occurs twice too, ``GROUP.INDEX.NAME``. Samples marked as invalid are nan.

    Raises
    ------
    DataError
        It is damaged, unfolds to more than there is room for, or asammdf is not installed.
    """
    asammdf, builder = library("asammdf", "mdf", file), TableBuilder(room=room)
    with (
        refusing(f"{file} cannot be read as an MDF file (write it anew)"),
        asammdf.MDF(file) as mdf,
    ):
        for name, group, index in _mdf_names(mdf):
            # Its samples and its times are made before they are seen.
            room.take(2 * 8 * mdf.groups[group].channel_group.cycles_nr)
            try:
                signal = mdf.get(group=group, index=index, ignore_invalidation_bits=True)
            except Exception as error:
                builder.pass_over(name, f"data that asammdf cannot read ({one_line(error)})")
                continue
            values, invalid = np.asarray(signal.samples), signal.invalidation_bits
            if invalid is not None and values.dtype.kind in "fiub":
                values = np.where(np.asarray(invalid, dtype=bool), np.nan, values)
            count = 0 if invalid is None else np.count_nonzero(invalid)
            builder.add(
                name,
                values,
                unit=signal.unit or "",
                clock=np.asarray(signal.timestamps, dtype=np.float64),
                note=f"{name}: {count} samples are marked as invalid" if count else "",
            )
    return builder.table(str(file), advice="record channels of numbers")


def _mdf_names(mdf: Any) -> list[tuple[str, int, int]]:
    """Channels by names of their own, with group and index; masters are none."""
    places = [
        (name, group, index)
        for name, where in mdf.channels_db.items()
        for group, index in where
        if mdf.masters_db.get(group) != index
    ]
    names = [name for name, _, _ in places]
    for longer in ("{1}.{0}", "{1}.{2}.{0}"):
        often = Counter(names)
        names = [
            longer.format(*place) if often[name] > 1 else name
            for name, place in zip(names, places, strict=True)
        ]
    return [(name, *place[1:]) for name, place in zip(numbered(names), places, strict=True)]


def read_tdms(file: Path, room: Room) -> Table:
    """Read a TDMS file; a waveform channel has its own time track, and its unit.

    Channels are named ``GROUP.NAME``; the name alone serves where it is the only one. Times count
    from the earliest start of a waveform.

    Raises
    ------
    DataError
        It is damaged, too large, or npTDMS is not installed.
    """
    nptdms, log = library("nptdms", "tdms", file), library("nptdms.log", "tdms", file)
    builder = TableBuilder(room=room)
    with refusing(f"{file} cannot be read as a TDMS file (write it anew)"):
        room.take(file.stat().st_size)
        with _warnings(log.log_manager.console_handler) as warned:
            content = nptdms.TdmsFile.read(file)
        channels = [c for group in content.groups() for c in group.channels()]
        starts = (_waveform(channel)[0] for channel in channels)
        origin = min((start for start in starts if start is not None), default=None)
        for channel in channels:
            _add_channel(builder, channel, origin)
    return builder.table(
        str(file),
        warnings=tuple(f"npTDMS: {warning}" for warning in dict.fromkeys(warned)),
        advice="record channels of numbers",
    )


def _waveform(channel: Any) -> tuple[np.datetime64 | None, float]:
    """When a waveform began, if it says so, and its step, s; 0 for none."""
    start, step = (channel.properties.get(f"wf_{each}") for each in ("start_time", "increment"))
    begun = step and isinstance(start, np.datetime64) and not np.isnat(start)
    return start if begun else None, float(step or 0)


def _add_channel(builder: TableBuilder, channel: Any, origin: np.datetime64 | None) -> None:
    name = f"{channel.group_name}.{channel.name}"
    try:
        values = channel[:]
    except Exception as error:
        builder.pass_over(name, f"data that npTDMS cannot read ({one_line(error)})")
        return
    properties = channel.properties
    clock, note, (start, step) = None, "", _waveform(channel)
    if step > 0 and len(channel):
        begin = float(properties.get("wf_start_offset", 0.0))
        if start is not None:
            begin += (start - origin) / np.timedelta64(1, "s")
        elif origin is not None:
            note = f"{channel.name}: no wf_start_time, assumed to begin with the first waveform"
        clock = begin + step * np.arange(len(channel), dtype=np.float64)
    builder.add(
        name,
        values,
        unit=str(properties.get("unit_string", properties.get("NI_UnitDescription", ""))),
        clock=clock,
        note=note,
    )


@contextmanager
def _warnings(handler: logging.Handler) -> Iterator[list[str]]:
    """What a library logs of a file, which is the user's to know, in place of standard error."""
    messages: list[str] = []

    def kept(record: logging.LogRecord) -> bool:
        messages.append(textwrap.shorten(record.getMessage(), 100))
        return False

    handler.addFilter(kept)
    try:
        yield messages
    finally:
        handler.removeFilter(kept)


_JOINT_STATE = "sensor_msgs/msg/JointState"
_CALENDAR = 10**17  # ns, in 1973, beyond which a clock is one of the calendar


def read_bag(path: Path, room: Room) -> Table:
    """Read the JointState messages of a ROS 1 bag or a ROS 2 bag (its folder, or a file of it).

    Columns are ``JOINT.position``, ``JOINT.velocity`` and ``JOINT.effort``, before them the topic
    where several have such messages. Times are those of the messages' headers, or of a topic
    whose headers lack some those of recording, and count from the earliest of all topics.

    Raises
    ------
    DataError
        It is damaged, has no such messages or more than there is room for, or rosbags is not
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
    """Return whether a folder is a ROS 2 bag."""
    return os.path.isfile(path / "metadata.yaml")


def bag_of(path: Path) -> Path:
    """Return the path to read for a bag: the folder of a ROS 2 bag for a file in it.

    A file that was passed on alone has no metadata beside it.
    """
    whole = path.suffix.lower() != ".bag" and path.is_file() and is_bag(path.parent)
    return path.parent if whole else path


def _joints(
    reader: Any, topic: str, room: Room
) -> tuple[NDArray[np.int64], str, dict[str, dict[int, float]]]:
    """Times of a topic's messages, ns, what these are, and values by joint and message.

    Where a header of the topic has no time, all times are those of recording.
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
