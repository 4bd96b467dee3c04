"""A log of any format as a table."""

import os
import re
import stat
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from axisid.estimation.logs.text import NO_TEXT, is_number, read_text
from axisid.estimation.tables import Column, Repair, Table, label_unit, loaded_column
from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.files import changed, digest_of, read_whole, stamps
from axisid.support.memory import SHORTER_FILES, Room, room_for

from .columnar import read_frame
from .formats import (
    ZIP,
    format_by_content,
    format_endings,
    format_of,
    packing_by_content,
    packing_of,
    unpacked,
)
from .measurement import bag_of, is_bag, read_bag

_NO_TAIL = Repair(
    kind="tail",
    count=0,
    text="nothing left out at the end: that is done in delimited text alone",
)

HEAD = 4096  # bytes that tell the kind
_ASK = "give the file the ending "
_JSON = re.compile(rb'\s*(\{\s*"|\[\s*[\[{])')
#: First bytes of what is no log, what such a file is, and what to do.
_NO_LOGS: tuple[tuple[bytes, str, str], ...] = (
    (b"\x93NUMPY", "a NumPy array", "save the columns with numpy.savez, as .npz"),
    (b"\xd0\xcf\x11\xe0", "an old Excel or Office file", "save its sheet as CSV"),
    (b"%PDF", "a PDF document", "give the log itself"),
    (b"\x89PNG", "a picture", "give the log itself"),
    (b"\xff\xd8\xff", "a picture", "give the log itself"),
    (b"7z\xbc\xaf", "a 7z archive", "unpack it and give the log"),
    (b"Rar!", "a RAR archive", "unpack it and give the log"),
    (b"BZh", "compressed by bzip2", "unpack it first"),
    (b"\xfd7zXZ\0", "compressed by xz", "unpack it first"),
    (b"{\\rtf", "a word processor's document", "save the table as CSV"),
)

# of the rows have the time of the row before; one half with two names, more with more
_MIN_ROWS_AT_ONE_TIME = 0.4

_NAMES = frozenset("name signal channel variable topic key tag symbol measurement field".split())
_VALUES = frozenset(("value", "val", "values", "y", "data", "wert"))
_UNITS = frozenset(("unit", "units", "einheit"))
_MOST_SIGNALS = 1000
_FEWEST_ROWS = 2  # of a signal


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
    _check_regular(file, folder=bag)
    reader = read_bag if bag else format_of(file).read_file
    try:
        _check_kind(file)
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
            f"{file} cannot be read: there is not enough memory for it. {SHORTER_FILES}.",
            code="memory",
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
    except DataError as error:
        if error.code != NO_TEXT:
            raise
        problem = f"{str(error).removesuffix('.')}, or give the file the ending of its format "
        raise DataError(f"{problem}({format_endings()}).", code=NO_TEXT) from error


def _check_regular(file: Path, *, folder: bool) -> None:
    """Refuse what is there but is no file with an end, such as a pipe or a device.

    Parameters
    ----------
    file : Path
    folder : bool
        Whether it may be a folder.

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
    if stat.S_ISDIR(mode) and not folder:
        raise DataError(
            f"{file} cannot be read: it is a folder, and no ROS 2 bag. Give the file of the log.",
            code="log-file",
        )
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise DataError(
            f"{file} is no regular file but a pipe, a device or a socket; save the log to a file.",
            code="log-file",
        )


def _check_kind(file: Path) -> None:
    """Refuse a file whose first bytes are those of another format than its ending says.

    Raises
    ------
    DataError
        It says what the file is, and what to do.
    """
    if not file.is_file():
        return
    with file.open("rb") as stream:
        head = stream.read(HEAD)
    if found := _kind(file, head, file.suffix.lower()):
        kind, advice = found
        raise DataError(f"{file} is {kind} by its content; {advice}.", code="log-file")


def _kind(file: Path, head: bytes, ending: str) -> tuple[str, str] | None:
    """What a file is and what to do, where that is surely not what its ending says."""
    found = format_by_content(head)
    if found is not None:
        log_format, signature = found
        advice = f"{_ASK}{log_format.endings[0]}{signature.provided}"
        return None if ending in log_format.endings else (signature.kind, advice)
    for start, kind, advice in _NO_LOGS:
        if head.startswith(start):
            return kind, advice
    named = format_of(file)
    if head.startswith(ZIP):
        return None if named.start == ZIP else _archive(file)
    packed, packing = packing_by_content(head), packing_of(file)
    if packed is not None:
        advice = f"{_ASK}{packed.ending}, as in .csv{packed.ending}"
        return None if packed is packing else (f"compressed by {packed.name}", advice)
    if packing is not None:
        return f"not compressed by {packing.name}", f"{_ASK}of what it is"
    if b'"axisid.' in head and _JSON.match(head):
        return "a result of axisid in JSON", "give the log that it was found from"
    if named.is_text:
        return _marked_up(head)
    # A table in text is printable and has lines.
    is_text = b"\n" in head and all(byte >= 0x20 or byte in b"\t\n\r\f" for byte in head)
    return ("text", f"{_ASK}.csv") if named.is_binary and is_text else None


def _archive(file: Path) -> tuple[str, str]:
    try:
        with zipfile.ZipFile(file) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, OSError, ValueError):
        names = []
    if any(name.startswith("xl/") for name in names):
        return "an Excel workbook", "save the sheet of the log as CSV"
    if names and all(name.endswith(".npy") for name in names):
        return "a NumPy archive", f"{_ASK}.npz"
    return "a ZIP archive", "unpack it and give the log"


def _marked_up(head: bytes) -> tuple[str, str] | None:
    """Text that is surely no table."""
    begin = head.removeprefix(b"\xef\xbb\xbf").lstrip()[:200].lower()
    if begin.startswith((b"<!doctype html", b"<html")):
        return "a page in HTML", "export the log itself as CSV"
    if begin.startswith(b"<?xml"):
        return "an XML document", "export the log as CSV"
    if _JSON.match(begin):
        return "a JSON document", f"{_ASK}.json, or .jsonl for a record in each line"
    return None


def wide(table: Table) -> Table:
    """A table as it is, or with a column for each signal of a long one.

    Long is a table of one column of text, one of times and one of values, beside one of units,
    whose headings say so (``name`` or ``signal``, ``value``), or whose rows come at the same times.
    Each signal has a clock of its own.
    """
    found = _parts(table)
    if found is None:
        return table
    names, times, values, units = found
    clock, numbers = table.columns[times], table.columns[values].read().values
    factor, _ = (label_unit(clock.unit) if clock.unit else None) or (1.0, None)
    seconds = factor * clock.read().values
    columns: dict[str, Column] = {}
    order = np.unique(np.asarray(names, dtype=str), return_inverse=True)
    clocks: list[Array] = []
    for k, name in enumerate(order[0]):
        places = np.flatnonzero(order[1] == k)
        own = seconds[places]
        shared = next((each for each in clocks if np.array_equal(each, own)), own)
        if shared is own:
            clocks.append(own)
        unit = units[places[0]] if units else ""
        columns[str(name)] = loaded_column(numbers[places], unit=unit, clock=shared)
    told = f"rows of {times}, name and {values}, made {len(columns)} columns by their names"
    notes = (*table.notes, *((clock.note,) if clock.note else ()), told)
    return replace(table, columns=columns, notes=notes, texts={})


def _parts(
    table: Table,
) -> tuple[Sequence[str], str, str, Sequence[str]] | None:
    """Names of the signals, row by row, the columns of times and of values, and units."""
    texts = dict(table.texts)
    units: Sequence[str] = ()
    for label in [*texts]:
        if label.lower() in _UNITS and len(texts) > 1:
            units = texts.pop(label)
    numeric = [name for name, c in table.columns.items() if name not in table.texts]
    if len(texts) != 1 or len(numeric) != 2:
        return None
    ((label, names),) = texts.items()
    signals = {*names}
    enough = 2 <= len(signals) <= _MOST_SIGNALS and len(names) >= _FEWEST_ROWS * len(signals)
    if not enough or "" in signals:
        return None
    values = next((name for name in numeric if name.lower() in _VALUES), numeric[1])
    times = next(name for name in numeric if name != values)
    said = label.lower() in _NAMES and values.lower() in _VALUES
    # A column of numbers with a damaged one is text too, and has no names in it.
    if not (said or (_at_one_time(table, times) and not any(map(is_number, signals)))):
        return None
    return names, times, values, units


def _at_one_time(table: Table, times: str) -> bool:
    """Whether rows share their times."""
    seconds = table.columns[times].read().values
    same = sum(a == b for a, b in pairwise(seconds[:10_000].tolist()))
    return bool(same >= _MIN_ROWS_AT_ONE_TIME * min(len(seconds), 10_000))
