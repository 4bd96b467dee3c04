"""A log of any format as a table."""

import os
import re
import stat
from dataclasses import replace
from pathlib import Path

from axisid.estimation.logs.text import read_text
from axisid.estimation.tables import Repair, Table
from axisid.support.errors import DataError
from axisid.support.files import changed, digest_of, read_whole, stamps
from axisid.support.memory import SHORTER_FILES, Room, room_for

from .columnar import read_frame
from .formats import FORMATS, PACKINGS, format_endings, format_of, packing_of, unpacked
from .measurement import bag_of, is_bag, read_bag

_ASK = "give the file the ending "
_JSON = rb'(\xef\xbb\xbf)?\s*(\{\s*"|\[\s*[\[{])'
#: What first bytes are like of what is no log, what such a file is, and what to do.
_NO_LOGS: tuple[tuple[bytes, str, str], ...] = (
    (rb"PK\x03\x04.*\bxl/", "an Excel workbook", "save the sheet of the log as CSV"),
    (rb"\x93NUMPY", "a NumPy array", "save the columns with numpy.savez, as .npz"),
    (rb"\xd0\xcf\x11\xe0", "an old Excel or Office file", "save its sheet as CSV"),
    (rb"%PDF", "a PDF document", "give the log itself"),
    (rb"\x89PNG|\xff\xd8\xff", "a picture", "give the log itself"),
    (rb"7z\xbc\xaf|Rar!", "an archive", "unpack it and give the log"),
    (rb"BZh|\xfd7zXZ\0", "compressed by bzip2 or xz", "unpack it first"),
    (rb"\{\\rtf", "a word processor's document", "save the table as CSV"),
    (rb"(\xef\xbb\xbf)?\s*<(!doctype )?html", "a page in HTML", "export the log itself as CSV"),
    (rb"(\xef\xbb\xbf)?\s*<\?xml", "an XML document", "export the log as CSV"),
    (_JSON + rb'.*"axisid\.', "a result of axisid in JSON", "give the log that it was found from"),
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
    if drop_tail and not table.repairs:
        said = "nothing left out at the end: that is done in delimited text alone"
        table = replace(table, repairs=(Repair(kind="tail", count=0, text=said),))
    return table


def _read_file(file: Path, room: Room, *, drop_tail: bool) -> Table:
    bag = is_bag(file)
    _check_regular(file, folder=bag)
    reader = read_bag if bag else format_of(file).read_file
    try:
        _check_kind(file)
        if reader is not None:
            whole = bag_of(file) if reader is read_bag else file
            before = stamps(whole)
            table = reader(file, room)
            sha256 = digest_of(list(before))
            if stamps(whole) != before:
                raise changed(file)
        else:
            room.take(file.stat().st_size)
            content, sha256 = read_whole(file)
            table = _parsed(file, content, room, drop_tail=drop_tail)
    except OSError as error:
        raise DataError(f"{file} cannot be read: {error.strerror}. Check the path.") from error
    except MemoryError as error:
        raise DataError(
            f"{file} cannot be read: there is not enough memory for it. {SHORTER_FILES}.",
            code="memory",
        ) from error
    return replace(table, sha256=sha256, path=os.path.abspath(file))


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
        table = read_text(str(file), content, drop_tail=drop_tail, endings=format_endings())
    else:
        table = log_format.read(file, content, room)
    notes = (f"unpacked by {packing.name}",) if packing else ()
    return replace(table, notes=(*notes, *table.notes))


def _check_regular(file: Path, *, folder: bool) -> None:
    """Refuse what is there but is no file with an end, such as a pipe, and no folder that may be.

    Raises
    ------
    DataError
        It is not a regular file or a folder, or there is none.
    """
    try:
        mode = file.stat().st_mode
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else str(error)
        where = "" if file.is_absolute() else f" ({Path.cwd() / file})"
        raise DataError(
            f"{file} cannot be read: {why}{where}. Check the path.", code="log-file"
        ) from error
    is_folder = stat.S_ISDIR(mode)
    if not (stat.S_ISREG(mode) or (folder and is_folder)):
        what = "a folder, and no ROS 2 bag" if is_folder else "a pipe, a device or a socket"
        raise DataError(
            f"{file} is no regular file but {what}; give the file of the log.", code="log-file"
        )


def _check_kind(file: Path) -> None:
    """Refuse a file whose first bytes are those of another format than its ending says.

    Raises
    ------
    DataError
        It says what the file is, and what to do.
    """
    if file.is_file():
        with file.open("rb") as stream:
            found = _kind(file, stream.read(4096))
        if found is not None:
            kind, advice = found
            raise DataError(f"{file} is {kind} by its content; {advice}.", code="log-file")


def _kind(file: Path, head: bytes) -> tuple[str, str] | None:
    """What a file is and what to do, where that is surely not what its ending says."""
    named, packing = format_of(file), packing_of(file)
    for pattern, kind, advice in _NO_LOGS:
        if re.match(pattern, head, re.DOTALL | re.IGNORECASE):
            return kind, advice
    for log_format in FORMATS:
        for signature in log_format.signatures:
            if head.startswith(signature.start):
                advice = f"{_ASK}{log_format.endings[0]}{signature.provided}"
                return None if log_format is named else (signature.kind, advice)
    packed = next((each for each in PACKINGS if head.startswith(each.start)), None)
    if packed is not None and packed is not packing:
        return f"compressed by {packed.name}", f"{_ASK}{packed.ending}, as in .csv{packed.ending}"
    if packing is not None:
        return None if packed else (f"not compressed by {packing.name}", f"{_ASK}of what it is")
    if named.is_text and re.match(_JSON, head):
        return "a JSON document", f"{_ASK}.json, or .jsonl for a record in each line"
    # A table in text is printable and has lines.
    is_text = b"\n" in head and all(byte >= 0x20 or byte in b"\t\n\r\f" for byte in head)
    return ("text", f"{_ASK}.csv") if named.signatures and is_text else None
