"""Reading of an export of TwinCAT Scope: headers of the file and of each channel, then columns.

The headers are rows of a label and its value, repeated for every channel (``Name``, ``Data-Type``,
``SampleTime[ms]``, ``Unit``, ...); the settings of the export determine which rows there are. Below
the headers are the columns of numbers. A time column, in milliseconds or in units of 100 ns since
1601, precedes each channel (`Timelines: All`) or each group of channels with one sample time.
Channels that were sampled less often end earlier: their cells are empty, or repeat the last time
and value.
"""

from collections.abc import Sequence
from decimal import Decimal
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from axisid.estimation.raw_tables import RawColumn, Samples, Table, numbered
from axisid.support.arrays import Array
from axisid.support.errors import DataError

from .dialect import Line, how_written, is_number

_NAME = "Name"
#: Labels of a channel's header; another text may have one of them, but not just above its numbers.
_LABELS = frozenset(
    (
        *("Name", "SymbolComment", "Data-Type", "SampleTime[ms]", "SampleTime", "VariableSize"),
        *("SymbolBased", "IndexGroup", "IndexOffset", "SymbolName", "NetID", "Port", "Offset"),
        *("ScaleFactor", "BitMask", "Unit", "Unit ScaleFactor", "Unit Offset"),
    )
)


class _Channel(NamedTuple):
    """A channel, by name and unit, with the indices of its columns of values and of times."""

    name: str
    unit: str
    value: int
    time: int


def is_twincat(lines: Sequence[Line]) -> bool:
    """Return True if the filled lines of a text are an export of TwinCAT Scope.

    The first labels, and the rows of the header, decide.
    """
    if not lines or not lines[0][1].startswith((_NAME, "File")):
        return False
    separator = lines[0][1][len(_NAME) : len(_NAME) + 1]
    if not separator or separator not in "\t;,| ":
        return False
    heads = _heads([line for _, line in lines[:80]], separator)
    names = [cells for cells in heads if cells[0] == _NAME]
    labels = {cells[0] for cells in heads}
    return bool(names) and bool(
        labels & {"SampleTime[ms]", "Starttime of export"}  # no other text has these labels
        or names[-1].count(_NAME) > 1
        or (len(labels & _LABELS) > 1 and heads[-1][0] in _LABELS)
    )


def _heads(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Return the cells of each line of the header: all lines above the first number.

    The header ends above the first line that begins with a number.
    """
    rows = (line.rstrip("\r\n").split(separator) for line in lines)
    return [*takewhile(lambda row: not is_number(row[0].strip().replace(",", ".")), rows)]


def read_twincat(source: str, lines: Sequence[Line]) -> Table:
    """Return the table of an export of TwinCAT Scope.

    Parameters
    ----------
    source : str
        File name, for messages.
    lines : sequence of (int, str)
        Numbers and texts of the filled lines.

    Raises
    ------
    DataError
        A row is malformed, or the export has no time columns.
    """
    separator = lines[0][1][len(_NAME)]
    heads = _heads([line for _, line in lines], separator)
    if len(heads) == len(lines):
        raise DataError(
            f"{source}: the export of TwinCAT Scope has no samples below its headers. Export the "
            "log again.",
            code="log-text",
        )
    body = [line for line in lines[len(heads) :] if line[1].strip() != "EOF"]
    channels = _channels(source, heads)
    comma = any("," in line for _, line in body[:200]) and separator != ","
    values = _values(source, body, separator, channels, comma=comma)
    clocks = {k: values[k] * 1e-3 for k in {c.time for c in channels}}
    names = numbered([c.name for c in channels])
    return Table(
        source=source,
        columns={
            name: _column(name, c, values[c.value], clocks[c.time])
            for name, c in zip(names, channels, strict=True)
        },
        notes=(f"TwinCAT Scope export, {how_written(separator, comma=comma)}",),
    )


def _channels(source: str, heads: list[list[str]]) -> list[_Channel]:
    """Return the channels of the header.

    In the row of names, a cell with the label `Name` marks a time column; the channels after it
    have these times.

    Raises
    ------
    DataError
        There are no channels.
    """
    last = max(i for i, cells in enumerate(heads) if cells[0] == _NAME)
    rows = {cells[0]: cells for cells in heads[last:]}
    channels: list[_Channel] = []
    time = -1
    for k, name in enumerate(rows[_NAME]):
        if name == _NAME:
            time = k
        elif name.strip():
            attributes = {label: cells[k] for label, cells in rows.items() if k < len(cells)}
            unit = attributes.get("Unit", "").partition("(")[0].strip()
            channels.append(_Channel(name.strip(), unit, value=k, time=time))
    if not channels:
        raise DataError(
            f"{source}: the export of TwinCAT Scope names no channels. Export the log with the "
            "names of its channels."
        )
    return channels


def _values(
    source: str,
    lines: Sequence[Line],
    separator: str,
    channels: Sequence[_Channel],
    *,
    comma: bool,
) -> list[Array]:
    """Return all columns, (N,) each, with NaN for empty cells.

    Times since 1601 are converted to milliseconds from the first time. `comma` is True for a
    decimal comma.

    Raises
    ------
    DataError
        A row has too many cells, or a cell that is not a number.
    """
    width, times = 1 + max(c.value for c in channels), {c.time for c in channels}
    rows: list[list[float]] = []
    start = Decimal()
    for number, line in lines:
        cells = (line.replace(",", ".") if comma else line).rstrip("\r\n").split(separator)
        if len(cells) > width + 1 or any(cell.strip() for cell in cells[width:]):
            raise DataError(
                f"{source}, line {number}: the line has more than the {width} cells of the "
                "channels. Export with Timelines 'All' or 'For each sampletime', separated by tab "
                "or semicolon.",
                code="log-text",
            )
        # Missing cells at the end of a row are empty too.
        cells = [*(cell.strip() or "nan" for cell in cells[:width]), *["nan"] * width][:width]
        try:
            row = [*map(float, cells)]
            if not rows and row[0] >= 1e15:
                start = Decimal(cells[0])
            if start:  # a double is exact enough for a difference of such times only
                for k in times:
                    row[k] = float(Decimal(cells[k]) - start) * 1e-7 / 1e-3
        except ValueError as error:
            wrong = next(cell for cell in cells if not is_number(cell))
            raise DataError(
                f"{source}, line {number}: {wrong!r} is not a number. Correct the cell, or remove "
                "the line.",
                code="log-text",
            ) from error
        rows.append(row)
    return list(np.array(rows).T)


def _column(name: str, channel: _Channel, samples: Array, clock: Array) -> RawColumn:
    """Return the column of a channel with its times, s.

    Rows in which both cells are empty, or repeat the last time and value, are left out. A row in
    which only the value or only the time is empty is kept, and reported when the column is used.
    """
    repeated = (np.diff(samples, prepend=np.nan) == 0) & (np.diff(clock, prepend=np.nan) == 0)
    dropped = repeated | (np.isnan(samples) & np.isnan(clock))
    if dropped.any():  # columns of one clock share its array
        samples, clock = samples[~dropped], clock[~dropped]
    count = np.count_nonzero(repeated)
    note = f"{name}: {count} repetitions of the last time and value are left out" if count else ""
    return RawColumn(
        samples=Samples(values=samples, clock=clock),
        unit=channel.unit,
        label=channel.name,
        note=note,
    )
