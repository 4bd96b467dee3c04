"""Files of measurement systems in blocks: MDF (asammdf) and TDMS (npTDMS), channel by channel."""

import io
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.tables import Table, library, one_line
from axisid.support.errors import AxisidError, DataError

from .measurement import damaged_mdf, damaged_tdms, mdf_names, tdms_start, waveform_offset
from .measurement import unit_of as unit_of_tdms
from .sliced import SlicedColumn, sliced_tables


def tdms_blocks(source: str, raw: io.RawIOBase, rows: int) -> Iterator[Table]:
    """The table of a TDMS file, so many rows at a time; see `read_tdms`.

    Raises
    ------
    DataError
        It is damaged, holds no numeric channels, or npTDMS is not installed.
    """
    nptdms = library("nptdms", "tdms", Path(source))

    def columns(stream: Any) -> Sequence[SlicedColumn]:
        content = nptdms.TdmsFile.open(stream)
        channels = [c for group in content.groups() for c in group.channels()]
        starts = [start for channel in channels if (start := tdms_start(channel)) is not None]
        origin = np.min(starts) if starts else None
        numeric = [c for c in channels if c.dtype is not None and c.dtype.kind in "fiub"]
        return [_tdms_column(channel, origin) for channel in numeric if len(channel)]

    yield from _blocks(source, raw, rows, damaged_tdms, columns)


def _tdms_column(channel: Any, origin: np.datetime64 | None) -> SlicedColumn:
    offset, step, note = waveform_offset(channel, origin)

    def times(start: int, stop: int) -> NDArray[Any]:
        return offset + step * np.arange(start, stop, dtype=np.float64)

    def values(start: int, stop: int) -> NDArray[Any]:
        return np.asarray(channel.read_data(start, stop - start))

    return SlicedColumn(
        name=f"{channel.group_name}.{channel.name}",
        length=len(channel),
        read=values,
        clock=times if step > 0 else None,
        unit=unit_of_tdms(channel),
        note=note,
    )


def mdf_blocks(source: str, raw: io.RawIOBase, rows: int) -> Iterator[Table]:
    """The table of an MDF file, so many rows at a time; see `read_mdf`.

    Raises
    ------
    DataError
        It is damaged, holds no numeric channels, or asammdf is not installed.
    """
    asammdf = library("asammdf", "mdf", Path(source))

    def columns(stream: Any) -> Sequence[SlicedColumn]:
        mdf = asammdf.MDF(stream)
        made = (_mdf_column(mdf, *place) for place in mdf_names(mdf))
        return [column for column in made if column is not None]

    yield from _blocks(source, raw, rows, damaged_mdf, columns)


def _mdf_column(mdf: Any, name: str, group: int, index: int) -> SlicedColumn | None:
    """A channel; None of one that is no numbers."""

    def part(start: int, stop: int) -> Any:
        return mdf.get(
            group=group,
            index=index,
            record_offset=start,
            record_count=stop - start,
            ignore_invalidation_bits=True,
        )

    def values(start: int, stop: int) -> NDArray[Any]:
        signal = part(start, stop)
        samples, invalid = np.asarray(signal.samples), signal.invalidation_bits
        return samples if invalid is None else np.where(np.asarray(invalid, bool), np.nan, samples)

    def times(start: int, stop: int) -> NDArray[Any]:
        return np.asarray(part(start, stop).timestamps)

    length = int(mdf.groups[group].channel_group.cycles_nr)
    try:
        first = part(0, 1)
    except Exception:  # what asammdf cannot read is no column
        return None
    if np.asarray(first.samples).dtype.kind not in "fiub" or np.ndim(first.samples) != 1:
        return None
    return SlicedColumn(name=name, length=length, read=values, clock=times, unit=first.unit or "")


def _blocks(
    source: str,
    raw: io.RawIOBase,
    rows: int,
    damaged: Callable[[str, str], DataError],
    columns: Callable[[Any], Sequence[SlicedColumn]],
) -> Iterator[Table]:
    """The tables of columns that a library finds in a file."""
    buffered: Any = io.BufferedReader(raw)
    try:
        found = columns(buffered)
        if not found:
            raise DataError(f"{source} holds no numeric channels.")
        yield from sliced_tables(source, found, rows)
    except AxisidError:
        raise
    except Exception as error:
        raise damaged(source, one_line(error)) from error
    finally:
        buffered.detach()  # whoever opened the file has more to ask of it
