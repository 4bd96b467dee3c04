"""Reading of TDMS files of LabVIEW with npTDMS."""

import logging
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.raw_tables import Table, TableBuilder
from axisid.support.libraries import library, one_line, refusing
from axisid.support.memory import Room


def read_tdms(file: Path, room: Room) -> Table:
    """Return the table of a TDMS file; a waveform channel has its own times, and its unit.

    Channels are named ``GROUP.NAME``. A name without its group can be used if it is unique. Times
    count from the earliest start of a waveform.

    Raises
    ------
    DataError
        The file is damaged or too large, or npTDMS is not installed.
    """
    nptdms, log = library("nptdms", "tdms", file), library("nptdms.log", "tdms", file)
    builder = TableBuilder(room=room)
    with refusing(f"{file} cannot be read as a TDMS file. Write the file again. The error is"):
        room.take(file.stat().st_size)
        with _collected_warnings(log.log_manager.console_handler) as warned:
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
    """Return the start of a waveform, or None, and its time step, s; 0 for no waveform."""
    start, step = (channel.properties.get(f"wf_{each}") for each in ("start_time", "increment"))
    begun = step and isinstance(start, np.datetime64) and not np.isnat(start)
    return start if begun else None, float(step or 0)


def _add_channel(builder: TableBuilder, channel: Any, origin: np.datetime64 | None) -> None:
    """Add a channel to the table, with times from `origin`, the earliest start of a waveform."""
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
def _collected_warnings(handler: logging.Handler) -> Iterator[list[str]]:
    """Yield a list to which the warnings of a library are added, instead of being printed.

    `handler` prints the warnings of the library.
    """
    messages: list[str] = []

    def kept(record: logging.LogRecord) -> bool:
        """Store a message, shortened, and return False, so that it is not printed."""
        messages.append(textwrap.shorten(record.getMessage(), 100))
        return False

    handler.addFilter(kept)
    try:
        yield messages
    finally:
        handler.removeFilter(kept)
