"""Text that TwinCAT Scope exports: a head for the file, a head for each channel, then columns.

The heads are rows of a label and its value, repeated for every channel (``Name``, ``Data-Type``,
``SampleTime[ms]``, ``Unit``, ...), all or few of them, as the export was set. Below them stands a
time column, in milliseconds or in units of 100 ns since 1601, before each channel (`Timelines:
All`) or before each group of channels of one sample time. Channels that were sampled less often end
earlier and leave their cells empty, or repeat their last time and value.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.tables import Column, Table, loaded_column, numbered
from axisid.support.arrays import Array
from axisid.support.errors import DataError

from .dialect import Line, how_written, is_number

_NAME = "Name"
_SEPARATORS = "\t;,| "
#: Labels that no other text has.
_OWN = frozenset(("SampleTime[ms]", "Starttime of export"))
#: Labels of a channel's head; others may have one of them, but not right above their numbers.
_LABELS = frozenset(
    (
        *("Name", "SymbolComment", "Data-Type", "SampleTime[ms]", "SampleTime", "VariableSize"),
        *("SymbolBased", "IndexGroup", "IndexOffset", "SymbolName", "NetID", "Port", "Offset"),
        *("ScaleFactor", "BitMask", "Unit", "Unit ScaleFactor", "Unit Offset"),
    )
)
_HEAD = 80  # lines in which the heads are looked for
_FILETIME = 1e15  # beyond it a time counts units of 100 ns
_TICK = 1e-7
_MILLISECOND = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class _Channel:
    name: str
    unit: str
    value: int  # column
    time: int  # column


def is_twincat(lines: Sequence[Line]) -> bool:
    """Whether filled lines begin as an export of TwinCAT Scope does."""
    if not lines or not lines[0][1].startswith((_NAME, "File")):
        return False
    separator = lines[0][1][len(_NAME) : len(_NAME) + 1]
    if not separator or separator not in _SEPARATORS:
        return False
    heads = _heads([line for _, line in lines[:_HEAD]], separator)
    names = [cells for cells in heads if cells[0] == _NAME]
    if not names:
        return False
    labels = {cells[0] for cells in heads}
    return bool(
        labels & _OWN
        or names[-1].count(_NAME) > 1
        or (len(labels & _LABELS) > 1 and heads[-1][0] in _LABELS)
    )


def _heads(lines: Sequence[str], separator: str) -> list[list[str]]:
    first = next((k for k, line in enumerate(lines) if _is_data(line, separator)), len(lines))
    return [line.rstrip("\r\n").split(separator) for line in lines[:first]]


def read_twincat(source: str, lines: Sequence[Line]) -> Table:
    """Read an export of TwinCAT Scope.

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
            f"{source}: the export of TwinCAT Scope has no samples below its heads.",
            code="log-text",
        )
    body = [line for line in lines[len(heads) :] if line[1].strip() != "EOF"]
    channels = _channels(source, heads)
    comma = any("," in line for _, line in body[:200]) and separator != ","
    times = {c.time for c in channels}
    width = 1 + max(c.value for c in channels)
    values = _values(source, body, separator, width, times, comma=comma)
    clocks = {k: values[k] * _MILLISECOND for k in times}
    names = numbered([c.name for c in channels])
    columns = {
        name: _column(name, c, values, clocks[c.time])
        for name, c in zip(names, channels, strict=True)
    }
    return Table(
        source=source,
        columns=columns,
        notes=(f"TwinCAT Scope export, {how_written(separator, comma=comma)}",),
    )


def _is_data(line: str, separator: str) -> bool:
    cell = line.split(separator, 1)[0].strip()
    return is_number(cell) or is_number(cell, comma=True)


def _channels(source: str, heads: list[list[str]]) -> list[_Channel]:
    """Channels by their place in the heads; a cell that repeats the label begins a time column."""
    last = max(i for i, cells in enumerate(heads) if cells[0] == _NAME)
    rows = {cells[0]: cells for cells in heads[last:]}
    found: list[_Channel] = []
    time = -1
    for k, name in enumerate(rows[_NAME]):
        if name == _NAME:
            time = k
        elif name.strip():
            attributes = {label: cells[k] for label, cells in rows.items() if k < len(cells)}
            unit = attributes.get("Unit", "").partition("(")[0].strip()
            found.append(
                _Channel(
                    name=name.strip(),
                    unit=unit,
                    value=k,
                    time=time,
                )
            )
    if not found:
        raise DataError(f"{source}: the export of TwinCAT Scope names no channels.")
    return found


def _values(
    source: str,
    lines: Sequence[Line],
    separator: str,
    width: int,
    times: set[int],
    *,
    comma: bool,
) -> list[Array]:
    """The columns, nan where a cell is empty; times since 1601 are counted from the first."""
    table = [_cells(source, line, separator, width, comma=comma) for line in lines]
    try:
        if float(table[0][0]) >= _FILETIME:
            # 64 bits of a double are too few for such a time, not for a difference of two.
            start = int(table[0][0])
            for row in table:
                for k in times:
                    ticks = row[k] if row[k] == "nan" else int(row[k]) - start
                    row[k] = repr(float(ticks) * _TICK / _MILLISECOND)
        return list(np.array(table, dtype=float).T)
    except ValueError as error:
        raise _malformed(source, lines, table) from error


def _cells(source: str, of: Line, separator: str, width: int, *, comma: bool) -> list[str]:
    """Cells of a line for the channels, nan where one is empty."""
    number, line = of
    cells = (line.replace(",", ".") if comma else line).rstrip("\r\n").split(separator)
    if len(cells) > width + 1 or any(cell.strip() for cell in cells[width:]):
        raise DataError(
            f"{source}, line {number}: more than the {width} cells that the channels need. "
            "Export with Timelines 'All' or 'For each sampletime', separated by tab or semicolon.",
            code="log-text",
        )
    cells = cells[:width] + [""] * (width - len(cells))
    return [cell if cell.strip() else "nan" for cell in cells]


def _malformed(source: str, lines: Sequence[Line], table: list[list[str]]) -> DataError:
    for (number, _), cells in zip(lines, table, strict=True):
        wrong = next((cell for cell in cells if not is_number(cell)), None)
        if wrong is not None:
            return DataError(
                f"{source}, line {number}: {wrong.strip()!r} is not a number.",
                code="log-text",
            )
    return DataError(f"{source}: its rows cannot be read as numbers.")


def _column(name: str, channel: _Channel, values: list[Array], clock: Array) -> Column:
    """A channel with its times, without rows that it left empty or filled with its last sample.

    A sample that lacks its value or its time alone stays, and is told by whoever needs it.
    """
    samples = values[channel.value]
    dropped = np.isnan(samples) & np.isnan(clock)
    repeated = np.zeros(len(samples), dtype=bool)
    repeated[1:] = (samples[1:] == samples[:-1]) & (clock[1:] == clock[:-1])
    dropped |= repeated
    if dropped.any():  # columns of one clock share its array
        samples, clock = samples[~dropped], clock[~dropped]
    count = np.count_nonzero(repeated)
    note = f"{name}: {count} rows that repeat its last time and value left out" if count else ""
    return loaded_column(samples, unit=channel.unit, clock=clock, label=channel.name, note=note)
