"""The one door for logs of every format: read a table, find the roles' columns, make a record."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from axisid.codegen import GeneratedAxis
from axisid.modeling import Axis

from .arrays import Array, runs
from .clocks import jitter_told, timed, together
from .errors import DataError
from .file_kinds import GZIP, check_kind, check_regular, unpacked
from .jumps import left_jumps
from .memory import Room, room_for
from .provenance import LogClock, Provenance, Repair
from .read_bag import bag_of, is_bag, read_bag
from .read_columnar import read_frame, read_npz, read_parquet
from .read_matlab import read_matlab
from .read_measurement import read_mdf, read_tdms
from .read_text import read_text
from .record import Record, check_sample_period
from .repairs import Mask, Repairs, Span, clipped, split_at_gaps
from .resampling import Laid, resample
from .roles import Chosen
from .spikes import spikes_told
from .table import Samples, Table
from .time_steps import LARGEST_GAP, UNEVEN_GAP, counted_by, counted_on, open_end
from .unchanged import changed, digest_of, read_whole, stamps
from .unwrapping import unwrapped

_IN_MEMORY = {".mat": read_matlab, ".npz": read_npz, ".parquet": read_parquet, ".pq": read_parquet}
_FROM_DISK = {
    ".mf4": read_mdf,
    ".mdf": read_mdf,
    ".tdms": read_tdms,
    ".bag": read_bag,
    ".db3": read_bag,
    ".mcap": read_bag,
}
_NO_TAIL = Repair(
    kind="tail",
    count=0,
    text="nothing left out at the end: that is done in delimited text alone",
)


def read_record(
    log: str | Path | object,
    axis: Axis | GeneratedAxis | None = None,
    *,
    columns: Mapping[str, str] | None = None,
    sample_period: float | None = None,
    repairs: Repairs | None = None,
    max_memory: float | None = None,
) -> Record:
    """Read a record, its columns found by the roles' names.

    Parameters
    ----------
    log : str, Path, dataframe or mapping
        A file: ``.mat``, ``.parquet``, ``.npz``, ``.mf4``, ``.tdms``, ``.bag`` (or the folder of a
        ROS 2 bag), and delimited text by any other ending, also compressed (``.csv.gz``).
        Or a dataframe, or a mapping of column names to arrays.
    axis : Axis or GeneratedAxis, optional
        Its `columns` name the columns of its logs; its coordinate and drive say what they measure.
    columns : mapping of str to str, optional
        Column names by role, over those of the axis, each with a unit if it is not SI
        (``"pos:mm"``). A role that neither names is looked for under its own name (``time``,
        ``position``, ``reference``, ``control``, ``force``).
    sample_period : float, optional
        s; takes the place of the time column's mean step, and of the column if there is none.
    repairs : Repairs, optional
        What may be done to the data; nothing by default.
    max_memory : float, optional
        Bytes that reading a file may take, as far as they can be told beforehand; half of the
        machine's memory by default.

    Returns
    -------
    Record
        In SI; `Provenance.assumed` and `Provenance.repairs` tell how it came to be.

    Raises
    ------
    DataError
        The file is missing, malformed or too large, changes while it is read, lacks a column, or
        needs a repair that is not asked for.
    UsageError
        A role does not exist, a unit is not the role's, or a sampling period is given for columns
        that are resampled by times of their own.
    """
    check_sample_period(sample_period)
    declared = axis.axis if isinstance(axis, GeneratedAxis) else axis
    repairs = repairs or Repairs()
    table = read_table(log, drop_tail=repairs.tail is not None, max_memory=max_memory)
    found = Chosen(table, declared, dict(columns or {}), has_period=sample_period is not None)
    return _record(table, found, declared, sample_period, repairs)


def read_table(
    log: str | Path | object, *, drop_tail: bool = False, max_memory: float | None = None
) -> Table:
    """Read all columns of a log, whatever its format; see `read_record` and `Repairs.tail`."""
    if isinstance(log, (str, Path)):
        table = _read_file(Path(log), room_for(log, max_memory), drop_tail=drop_tail)
        table = replace(table, source=str(log))
    else:
        table = read_frame(log)
    if drop_tail and not any(repair.kind == "tail" for repair in table.repairs):
        table = replace(table, repairs=(*table.repairs, _NO_TAIL))
    return table


def _read_file(file: Path, room: Room, *, drop_tail: bool) -> Table:
    """The table of a file or of a bag's folder."""
    bag = is_bag(file)
    check_regular(file, folder=bag)
    reader = read_bag if bag else _FROM_DISK.get(file.suffix.lower())
    try:
        check_kind(file)
        if reader is not None:
            table, sha256 = _from_disk(reader, file, room)
        else:
            room.take(file.stat().st_size)
            content, sha256 = read_whole(file)
            table = _parsed(file, content, room, drop_tail=drop_tail)
    except OSError as error:
        raise DataError(f"{file} cannot be read: {error.strerror}. Check the path.") from error
    except MemoryError as error:
        raise DataError(
            f"{file} cannot be read: there is not enough memory for it. Read a piece of it, or "
            "delimited text or Parquet in blocks (--stream)."
        ) from error
    return replace(table, sha256=sha256, path=os.path.abspath(file))


def _from_disk(reader: Callable[[Path, Room], Table], file: Path, room: Room) -> tuple[Table, str]:
    """The table of a file that its library opens by itself, and the hash of what it then was."""
    whole = bag_of(file) if reader is read_bag else file
    before = stamps(whole)
    table = reader(file, room)
    sha256 = digest_of(list(before))
    if stamps(whole) != before:
        raise changed(file)
    return table, sha256


def _parsed(file: Path, content: bytes, room: Room, *, drop_tail: bool) -> Table:
    """The table of a file's content, unpacked where it is compressed."""
    packed = file.suffix.lower() == GZIP
    ending = Path(file.stem if packed else file).suffix.lower()
    parser = _IN_MEMORY.get(ending)
    if packed:
        if ending in _FROM_DISK:
            raise DataError(f"{file} is read from a file of its own; unpack it first.")
        content = unpacked(file, content, room, text=parser is None)
    elif parser is None:
        room.take_text(content)
    if parser is None:
        table = read_text(str(file), content, drop_tail=drop_tail)
    else:
        table = parser(file, content, room)
    notes = ("unpacked by gzip",) if packed else ()
    return replace(table, notes=(*notes, *table.notes))


def _record(
    table: Table,
    found: Chosen,
    axis: Axis | None,
    sample_period: float | None,
    repairs: Repairs,
) -> Record:
    """A record of the chosen columns, repaired as it was asked for."""
    counted = "time" not in found.samples and all(s.clock is None for s in found.samples.values())
    read, retimed = _retimed(found.samples, sample_period, repairs)
    samples = timed(table, read, sample_period, uneven=repairs.resample is not None)
    empty = _left_empty(read, samples)
    samples, masks, made, jumps = _mended(table.source, samples, axis, repairs)
    spiky = spikes_told(samples, axis, numbered=not empty)
    laid = (
        _as_sampled(samples, masks, sample_period, repairs)
        if repairs.resample is None
        else resample(
            table.source,
            samples,
            masks,
            repairs.resample,
            split=repairs.gaps is not None,
            stated=sample_period,
        )
    )
    return Record(
        time=laid.time,
        **laid.columns,
        sample_period=laid.period,
        segments=laid.segments,
        masked=runs(laid.masked),
        provenance=Provenance(
            source=Path(table.source).name,
            sha256=table.sha256,
            given=table.source if table.path else "",
            path=table.path,
            columns=found.names,
            assumed=(*found.notes, *jumps, *spiky, *jitter_told(laid.time, laid.segments)),
            repairs=(*table.repairs, *retimed, *made, *empty, *laid.repairs),
            clock=replace(laid.clock, counted=counted),
        ),
    )


def _as_sampled(
    samples: dict[str, Samples], masks: dict[str, Mask], period: float | None, repairs: Repairs
) -> Laid:
    """Columns at the times that they have, cut at gaps if that was asked for."""
    time, values, masked = together(samples, masks)
    segments: tuple[Span, ...] = ()
    made: tuple[Repair, ...] = ()
    if repairs.gaps is not None:
        kept, segments, repair = split_at_gaps(time)
        time, masked, made = time[kept], masked[kept], (repair,)
        values = {role: v[kept] for role, v in values.items()}
    pieces = [time[start:stop] for start, stop in segments or ((0, len(time)),)]
    return Laid(
        time=time,
        columns=values,
        masked=masked,
        segments=segments,
        period=period,
        repairs=made,
        clock=LogClock(
            uncertainty=open_end(pieces) if period is None else 0.0, stated=period is not None
        ),
    )


def _retimed(
    samples: dict[str, Samples], period: float | None, repairs: Repairs
) -> tuple[dict[str, Samples], list[Repair]]:
    """Samples whose clock counts a given period, or goes on where it was set back, and which.

    Columns with clocks of their own need not have been set back at one time, and stay.
    """
    own = samples["time"].values if "time" in samples else samples["position"].clock
    if own is None or not ("time" in samples or _share(samples, own)):
        return samples, []
    clock, made = own, []
    if period is not None:
        clock, text = counted_by(own, period)
        made += [Repair(kind="clock", count=len(clock), text=text)] if text else []
    if repairs.gaps is not None:
        clock, count, text = counted_on(clock, uneven=repairs.resample is not None)
        made += [Repair(kind="clock", count=count, text=text)] if text else []
    moved = {
        role: replace(s, values=clock) if role == "time" else replace(s, clock=clock)
        for role, s in samples.items()
    }
    return moved if made else samples, made


def _share(samples: dict[str, Samples], clock: Array) -> bool:
    """Whether every column has this clock."""
    clocks = [s.clock for s in samples.values()]
    return all(c is not None and np.array_equal(c, clock, equal_nan=True) for c in clocks)


def _left_empty(read: dict[str, Samples], kept: dict[str, Samples]) -> list[Repair]:
    """Rows that a resampled column lacks, for want of a number or of a time."""
    lost = {role: len(read[role].values) - len(s.values) for role, s in kept.items()}
    listed = ", ".join(f"{role} {count}" for role, count in lost.items() if count)
    if not listed:
        return []
    text = f"rows without a number or a time left out before resampling: {listed}"
    return [Repair(kind="empty", count=sum(lost.values()), text=text)]


def _mended(
    source: str, samples: dict[str, Samples], axis: Axis | None, repairs: Repairs
) -> tuple[dict[str, Samples], dict[str, Mask], list[Repair], list[str]]:
    """Samples unwrapped, and masks of what is clipped: the repairs that need no even time.

    With them goes what is said of jumps that are left.
    """
    made: list[Repair] = []
    masks: dict[str, Mask] = {}
    gap = LARGEST_GAP if repairs.resample is None else UNEVEN_GAP
    modulus = repairs.modulus(axis)
    if modulus is not None:
        samples, repair = unwrapped(source, samples, modulus, gap)
        made.append(repair)
    jumps = left_jumps(source, samples["position"], axis, gap, modulus)
    if repairs.mask is not None:
        clocks = {role: s.clock for role, s in samples.items() if s.clock is not None}
        masks, repair = clipped({role: s.values for role, s in samples.items()}, axis, clocks)
        made.append(repair)
    return samples, masks, made, [jumps] if jumps else []
