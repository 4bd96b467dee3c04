"""Files of measurement systems: MDF (asammdf), TDMS (npTDMS), ROS bags (rosbags)."""

import logging
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .arrays import Array
from .errors import DataError
from .table import Column, Samples, Table, at_hand, library, told

_JOINT_STATE = "sensor_msgs/msg/JointState"
_KINDS = ("position", "velocity", "effort")
_NANOSECOND = 1e-9
_LONGEST = 100  # of a warning


def read_mdf(file: Path) -> Table:
    """Read an MDF file; a channel has the master time of its group, and its unit.

    Channels that occur in several groups are named ``GROUP.NAME``, groups numbered from 0 as in
    MDF tools.

    Raises
    ------
    DataError
        It is damaged, or asammdf is not installed.
    """
    asammdf = library("asammdf", "mdf", file)
    try:
        with asammdf.MDF(file) as mdf:
            columns = _mdf_columns(mdf)
    except Exception as error:
        raise DataError(f"{file} cannot be read as an MDF file: {told(error)}.") from error
    if not columns:
        raise DataError(f"{file} holds no numeric channels.")
    return Table(source=str(file), columns=columns)


def _mdf_columns(mdf: Any) -> dict[str, Column]:
    columns: dict[str, Column] = {}
    for name, places in mdf.channels_db.items():
        for group, index in places:
            if mdf.masters_db.get(group) == index:
                continue
            signal = mdf.get(group=group, index=index)
            values = np.asarray(signal.samples)
            if values.dtype.kind not in "fiub" or values.ndim != 1:
                continue
            own = name if len(places) == 1 else f"{group}.{name}"
            columns[own] = at_hand(
                values.astype(np.float64),
                unit=signal.unit or "",
                clock=np.asarray(signal.timestamps, dtype=np.float64),
            )
    return columns


def read_tdms(file: Path) -> Table:
    """Read a TDMS file; a waveform channel has its own time track, and its unit.

    Channels are named ``GROUP.NAME``; the name alone serves where it is the only one.

    Raises
    ------
    DataError
        It is damaged, or npTDMS is not installed.
    """
    nptdms = library("nptdms", "tdms", file)
    columns: dict[str, Column] = {}
    try:
        with _warnings("nptdms") as warned:
            content = nptdms.TdmsFile.read(file)
        for group in content.groups():
            for channel in group.channels():
                column = _tdms_column(channel)
                if column is not None:
                    columns[f"{group.name}.{channel.name}"] = column
    except Exception as error:
        raise DataError(f"{file} cannot be read as a TDMS file: {told(error)}.") from error
    if not columns:
        raise DataError(f"{file} holds no numeric channels.")
    notes = tuple(f"npTDMS: {warning}" for warning in dict.fromkeys(warned))
    return Table(source=str(file), columns=columns, notes=notes)


@contextmanager
def _warnings(name: str) -> Iterator[list[str]]:
    """What a library logs of a file, which is the user's to know, in place of standard error."""
    found: list[str] = []
    handler = logging.Handler()
    handler.emit = lambda record: found.append(  # type: ignore[method-assign]
        textwrap.shorten(record.getMessage(), _LONGEST)
    )
    parts = [own for own in logging.root.manager.loggerDict if own.startswith(f"{name}.")]
    loggers = [logging.getLogger(own) for own in parts]
    before = [(logger, logger.handlers[:], logger.propagate) for logger in loggers]
    for logger in loggers:
        logger.handlers, logger.propagate = [handler], False
    try:
        yield found
    finally:
        for logger, handlers, propagate in before:
            logger.handlers, logger.propagate = handlers, propagate


def _tdms_column(channel: Any) -> Column | None:
    values = np.asarray(channel[:])
    if values.dtype.kind not in "fiub" or values.ndim != 1:
        return None
    clock = None
    if "wf_increment" in channel.properties and len(values):
        clock = np.asarray(channel.time_track(), dtype=np.float64)
    unit = str(channel.properties.get("unit_string", ""))
    return at_hand(values.astype(np.float64), unit=unit, clock=clock)


def read_bag(path: Path) -> Table:
    """Read the JointState messages of a ROS 1 bag or a ROS 2 bag (its folder, or a file in it).

    Columns are ``JOINT.position``, ``JOINT.velocity`` and ``JOINT.effort``, before them the topic
    where several have such messages. Time is the messages' own, or that of their recording where
    they have none.

    Raises
    ------
    DataError
        It is damaged, has no such messages, or rosbags is not installed.
    """
    highlevel = library("rosbags.highlevel", "rosbags", path)
    stores = library("rosbags.typesys", "rosbags", path)
    folder = path.parent if path.suffix.lower() in (".db3", ".mcap") else path
    stamped = {}
    try:
        usual = stores.get_typestore(stores.Stores.LATEST)
        with highlevel.AnyReader([folder], default_typestore=usual) as reader:
            topics = {c.topic: c for c in reader.connections if c.msgtype == _JOINT_STATE}
            others = sorted({c.msgtype for c in reader.connections})
            for topic in topics:
                stamped[topic] = _messages(reader, topic)
    except Exception as error:
        raise DataError(f"{path} cannot be read as a ROS bag: {told(error)}.") from error
    columns: dict[str, Column] = {}
    for topic, messages in stamped.items():
        before = f"{topic.strip('/')}." if len(stamped) > 1 else ""
        columns |= _joint_columns(path, before, messages)
    if not columns:
        raise DataError(
            f"{path} has no {_JOINT_STATE} messages; it has {', '.join(others) or 'none'}."
        )
    return Table(source=str(path), columns=columns, notes=("ROS bag, JointState in SI",))


def _messages(reader: Any, topic: str) -> list[tuple[float, Any]]:
    """Messages of a topic with their times, s, in the order of the times."""
    chosen = [c for c in reader.connections if c.topic == topic and c.msgtype == _JOINT_STATE]
    found = []
    for connection, recorded, raw in reader.messages(connections=chosen):
        message = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        own = stamp.sec * 10**9 + stamp.nanosec
        found.append((own or recorded, message))
    if not found:
        return []
    found.sort(key=lambda pair: pair[0])
    start = found[0][0]  # counted from the first, or a double loses the nanoseconds
    return [((time - start) * _NANOSECOND, message) for time, message in found]


def _joint_columns(path: Path, before: str, messages: list[tuple[float, Any]]) -> dict[str, Column]:
    columns: dict[str, Column] = {}
    joints = dict.fromkeys(name for _, message in messages for name in message.name)
    for joint in joints:
        rows = [(t, m, list(m.name).index(joint)) for t, m in messages if joint in m.name]
        clock = np.array([t for t, _, _ in rows])
        for kind in _KINDS:
            name = f"{before}{joint}.{kind}"
            values = [_at(getattr(m, kind), k) for _, m, k in rows]
            if any(value is not None for value in values):
                columns[name] = Column(read=partial(_whole, path, name, values, clock))
    return columns


def _at(values: Iterable[float], index: int) -> float | None:
    """A joint's entry of a message, whose list may be empty."""
    listed = list(values)
    return float(listed[index]) if index < len(listed) else None


def _whole(path: Path, name: str, values: list[float | None], clock: Array) -> Samples:
    there = [value is not None for value in values]
    if not any(there):
        raise DataError(f"{path}: {name} is in no message.")
    found = np.array([value for value in values if value is not None])
    return Samples(values=found, clock=clock[np.array(there)])
