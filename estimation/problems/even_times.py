"""How far a record's stamps are from even times, and the record at these.

Position and reference are interpolated by cubic splines, the others by straight lines, as
`--resample` does.
"""

from collections.abc import Sequence

import numpy as np

from axisid.estimation.records import Record
from axisid.support.arrays import Array


def jitter_of(record: Record) -> Array:
    """How far the samples of a record are from even times, (N,), s: what a line leaves of them."""
    pieces = []
    for first, last in record.spans:
        count, own = np.arange(last - first, dtype=float), record.time[first:last]
        pieces.append(own - np.polyval(np.polyfit(count, own - own[0], 1), count) - own[0])
    return np.concatenate(pieces)


def evenly(record: Record, roles: Sequence[str] = ()) -> Record:
    """A record at the even times that fit its own best, by its stamps.

    Parameters
    ----------
    record : Record
    roles : sequence of str
        The columns that are moved there; all by default. Position and reference go by cubic
        splines, as does what was added to the reference, and others by straight lines.
    """
    from scipy.interpolate import CubicSpline

    even = record.time - jitter_of(record)
    splined = ("position", "reference") + ("injected",) * (record.injected_at == "reference")
    columns = {**record.channels()}
    for name in columns.keys() & {*(roles or columns)} - {"time"}:
        values, moved = columns[name], np.empty(len(record))
        for first, last in record.spans:
            at, own, piece = even[first:last], record.time[first:last], values[first:last]
            moved[first:last] = (
                CubicSpline(own, piece)(at) if name in splined else np.interp(at, own, piece)
            )
        columns[name] = moved
    return record.with_channels(columns)
