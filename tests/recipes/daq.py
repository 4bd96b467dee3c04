"""Files of a recorder: the names of the columns in a line, then rows of doubles."""

from pathlib import Path

import numpy as np

from axisid.estimation.raw_tables import Table, TableBuilder, split_labels
from axisid.support.errors import DataError
from axisid.support.memory import Room


def read_daq(file: Path, content: bytes, room: Room) -> Table:
    """Read the columns, whose names have their unit behind them, as in ``position[mm]``."""
    head, _, body = content.partition(b"\n")
    labels = head.decode("utf-8", "replace").split()[1:]
    if not labels or len(body) % (8 * len(labels)):
        raise DataError(f"{file} cannot be read as a DAQ file: its last row is cut off.")
    rows = np.frombuffer(body, "<f8").reshape(-1, len(labels))
    found = TableBuilder(room=room)
    for label, (name, unit), values in zip(labels, split_labels(labels), rows.T, strict=True):
        found.add(name, values, unit=unit, label=label)
    return found.table(str(file))
