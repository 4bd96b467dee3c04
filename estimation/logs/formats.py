"""Which reader opens which file: a log of any format as a table."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from axisid.estimation.logs.text import read_text
from axisid.estimation.tables import Repair, Table
from axisid.support.errors import DataError
from axisid.support.memory import Room, room_for
from axisid.support.unchanged import changed, digest_of, read_whole, stamps

from .columnar import read_frame, read_npz, read_parquet
from .file_kinds import GZIP, check_kind, check_regular, unpacked
from .matlab import read_matlab
from .measurement import read_mdf, read_tdms
from .rosbag import bag_of, is_bag, read_bag

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
