"""A log of any format as a table."""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from axisid.estimation.logs.text import NoTextError, read_text
from axisid.estimation.tables import Repair, Table, wide
from axisid.support.errors import DataError
from axisid.support.files.memory import MEMORY, SHORTER_FILES, Room, room_for
from axisid.support.files.unchanged import changed, digest_of, read_whole, stamps
from axisid.support.remedy import Remedy

from .columnar import read_frame
from .file_kinds import check_kind, check_regular
from .formats import format_endings, format_of
from .packings import packing_of, unpacked
from .rosbag import bag_of, is_bag, read_bag

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
    table = wide(table)
    if drop_tail and not any(repair.kind == "tail" for repair in table.repairs):
        table = replace(table, repairs=(*table.repairs, _NO_TAIL))
    return table


def _read_file(file: Path, room: Room, *, drop_tail: bool) -> Table:
    """The table of a file or of a bag's folder."""
    bag = is_bag(file)
    check_regular(file, folder=bag)
    reader = read_bag if bag else format_of(file).read_file
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
            f"{file} cannot be read: there is not enough memory for it. ",
            Remedy.of(f"{SHORTER_FILES}."),
            code=MEMORY,
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
    packing = packing_of(file)
    log_format = format_of(Path(file.stem) if packing else file)
    if packing is not None:
        if log_format.read_file is not None:
            raise DataError(f"{file} is read from a file of its own; unpack it first.")
        content = unpacked(packing, file, content, room, text=log_format.is_text)
    elif log_format.is_text:
        room.take_text(content)
    if log_format.read is None:
        table = _as_text(file, content, drop_tail=drop_tail)
    else:
        table = log_format.read(file, content, room)
    notes = (f"unpacked by {packing.name}",) if packing else ()
    return replace(table, notes=(*notes, *table.notes))


def _as_text(file: Path, content: bytes, *, drop_tail: bool) -> Table:
    """The table of a text; what is none may be of a format that its ending does not say."""
    try:
        return read_text(str(file), content, drop_tail=drop_tail)
    except NoTextError as error:
        raise DataError(
            f"{error.problem.removesuffix('.')}, or give the file the ending of its format "
            f"({format_endings()})."
        ) from error
