"""Reading of an export of TwinCAT Scope: headers of the file and of each channel, then columns.

The headers are rows of a label and its value, repeated for every channel (``Name``, ``Data-Type``,
``SampleTime[ms]``, ``Unit``, ...); the settings of the export determine which rows there are. Below
them are columns. A time column, in milliseconds or in units of 100 ns since 1601, precedes each
channel (`Timelines: All`) or each group of channels with one sample time. Channels that were
sampled less often end earlier: their cells are empty, or repeat the last time and value.
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
    """A channel: its name and unit, and the indices of its columns of values and of times."""

    name: str
    unit: str
    value: int  # column
    time: int  # column


def is_twincat(lines: Sequence[Line]) -> bool:
    """Return True if filled lines are an export of TwinCAT Scope, by their beginning."""
    if not lines or not lines[0][1].startswith((_NAME, "File")):
        return False
    separator = lines[0][1][len(_NAME) : len(_NAME) + 1]
    if not separator or separator not in "\t;,| ":
        return False
    heads = _heads([line for _, line in lines[:80]], separator)
    names = [cells for cells in heads if cells[0] == _NAME]
    labels = {cells[0] for cells in heads}
    return bool(names) and bool(
        labels & {"SampleTime[ms]", "Starttime of export"}  # which no other text has
        or names[-1].count(_NAME) > 1
        or (len(labels & _LABELS) > 1 and heads[-1][0] in _LABELS)
    )


def _heads(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Return the cells of the header: of all lines before the first that begins with a number."""
    cells = (line.rstrip("\r\n").split(separator) for line in lines)
    return [*takewhile(lambda c: not is_number(c[0].strip().replace(",", ".")), cells)]


def read_twincat(source: str, lines: Sequence[Line]) -> Table:
    """Return the table of an export of TwinCAT Scope.

    Parameters
    ----------
    source : str
        File name, for messages.
    lines : sequence of (int, str)
        The filled lines with their numbers.

    Raises
    ------
    DataError
        A row is malformed, or the export has no time columns.
    """
    separator = lines[0][1][len(_NAME)]
    heads = _heads([line for _, line in lines], separator)
    if len(heads) == len(lines):
        raise DataError(
            f"{source}: the export of TwinCAT Scope has no samples below its headers. Export it "
            "again.",
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
    """Return the channels of the header; a cell that repeats the label marks a time column."""
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
        raise DataError(f"{source}: the export of TwinCAT Scope names no channels.")
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

    Times since 1601 are converted to milliseconds from the first one. `comma` is True for a decimal
    comma.
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
        cells = [*(cell.strip() or "nan" for cell in cells[:width]), *["nan"] * width][:width]
        try:
            row = [*map(float, cells)]
            if not rows and row[0] >= 1e15:
                start = Decimal(cells[0])
            if start:  # 64 bits of a double are too few for units of 100 ns, not for a difference
                for k in times:
                    row[k] = float(Decimal(cells[k]) - start) * 1e-7 / 1e-3
        except ValueError as error:
            wrong = next(cell for cell in cells if not is_number(cell))
            raise DataError(
                f"{source}, line {number}: {wrong!r} is not a number.", code="log-text"
            ) from error
        rows.append(row)
    return list(np.array(rows).T)


def _column(name: str, channel: _Channel, samples: Array, clock: Array) -> RawColumn:
    """Return the column of a channel with its times, s.

    Rows are left out in which both cells are empty, or repeat the last time and value. A row that
    lacks only its value or its time is kept; it is reported when the column is used.
    """
    repeated = (np.diff(samples, prepend=np.nan) == 0) & (np.diff(clock, prepend=np.nan) == 0)
    dropped = repeated | (np.isnan(samples) & np.isnan(clock))
    if dropped.any():  # columns of one clock share its array
        samples, clock = samples[~dropped], clock[~dropped]
    count = np.count_nonzero(repeated)
    note = f"{name}: {count} repetitions of its last time and value left out" if count else ""
    return RawColumn(
        samples=Samples(values=samples, clock=clock),
        unit=channel.unit,
        label=channel.name,
        note=note,
    )
