"""A log of any format as a table: the formats, and what packs them, a row for each.

A new format is a reader in a file of its own and a row.
"""

import gzip
import hashlib
import io
import os
import re
import stat
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from axisid.estimation.logs.text import read_text
from axisid.estimation.raw_tables import Repair, Table
from axisid.support.errors import DataError
from axisid.support.files import digest_of, unchanged
from axisid.support.libraries import library, refusing
from axisid.support.memory import SHORTER_FILES, Room, room_for

from .dataframe import read_frame
from .json_log import read_json
from .matlab import read_matlab
from .mdf import read_mdf
from .npz import read_npz
from .parquet import read_parquet
from .rosbag import bag_of, is_bag, read_bag
from .tdms import read_tdms


def _zstd(file: Path, content: Any) -> Any:
    """By Python itself from 3.14 on, else by pyarrow."""
    with suppress(DataError):
        return library("compression.zstd", "zstd", file).open(content)
    arrow = library("pyarrow", "zstd", file)
    return arrow.CompressedInputStream(arrow.PythonFile(content, "r"), "zstd")


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A format of logs, or of packed files. One without a reader is delimited text.

    Attributes
    ----------
    name : str
        What it is called in a sentence.
    endings : tuple of str
        In lower case, first the one that advice gives.
    signatures : mapping of bytes to str
        First bytes by which a file is known that has another ending, and what one that begins so
        is. A format without any may be text.
    provided : str
        What else must be true of a file that begins so for it to be a log.
    read : callable or None
        The table of a file's content, from its path, content and the memory that there is.
    read_file : callable or None
        The table of a file that its library opens by itself, from its path and the memory.
    opened : callable or None
        Of what packs a file of another format: a stream of what is unpacked, from its path and a
        stream of its content.
    extra : str
        Of `pyproject.toml`, for what it needs beyond the core.
    """

    name: str
    endings: tuple[str, ...]
    signatures: Mapping[bytes, str] = field(default_factory=dict)
    provided: str = ""
    read: Callable[[Path, bytes, Room], Table] | None = None
    read_file: Callable[[Path, Room], Table] | None = None
    opened: Callable[[Path, Any], Any] | None = None
    extra: str = ""

    @property
    def is_text(self) -> bool:
        """Return whether it is read as delimited text."""
        return self.read is None and self.read_file is None and self.opened is None


#: In the order of messages.
FORMATS = (
    Format(name="delimited text", endings=(".csv", ".tsv", ".txt")),
    Format(name="LabVIEW measurement", endings=(".lvm",)),
    Format(
        name="MATLAB",
        endings=(".mat",),
        signatures={
            b"MATLAB 5.0 MAT-file": "a MATLAB file",
            b"MATLAB 7.3 MAT-file": "a MATLAB v7.3 file",
            b"\x89HDF\r\n\x1a\n": "an HDF5 file",
        },
        read=read_matlab,
        extra="h5py",
    ),
    Format(
        name="Parquet",
        endings=(".parquet", ".pq"),
        signatures={b"PAR1": "a Parquet file"},
        read=read_parquet,
        extra="parquet",
    ),
    Format(name="JSON", endings=(".json",), read=read_json),
    Format(name="JSON lines", endings=(".jsonl", ".ndjson"), read=partial(read_json, lines=True)),
    Format(
        name="NumPy",
        endings=(".npz",),
        signatures={b"PK\x03\x04": "a ZIP archive"},
        provided=" if it is NumPy's, else unpack it",
        read=read_npz,
    ),
    Format(
        name="MDF",
        endings=(".mf4", ".mdf"),
        signatures={b"MDF     ": "an MDF file", b"UnFinMF ": "an MDF file that was not closed"},
        read_file=read_mdf,
        extra="mdf",
    ),
    Format(
        name="TDMS",
        endings=(".tdms",),
        signatures={b"TDSm": "a TDMS file"},
        read_file=read_tdms,
        extra="tdms",
    ),
    Format(
        name="ROS 1 bag",
        endings=(".bag",),
        signatures={b"#ROSBAG": "a ROS 1 bag"},
        read_file=read_bag,
        extra="rosbags",
    ),
    Format(
        name="ROS 2 bag",
        endings=(".db3",),
        signatures={b"SQLite format 3\0": "an SQLite database"},
        provided=" if it is a ROS 2 bag",
        read_file=read_bag,
        extra="rosbags",
    ),
    Format(
        name="MCAP",
        endings=(".mcap",),
        signatures={b"\x89MCAP0\r\n": "an MCAP file"},
        read_file=read_bag,
        extra="rosbags",
    ),
    Format(
        name="gzip",
        endings=(".gz",),
        signatures={b"\x1f\x8b": "compressed by gzip"},
        provided=", as in .csv.gz",
        opened=lambda _, content: gzip.GzipFile(fileobj=content),
    ),
    Format(
        name="zstd",
        endings=(".zst",),
        signatures={b"\x28\xb5\x2f\xfd": "compressed by zstd"},
        provided=", as in .csv.zst",
        opened=_zstd,
        extra="zstd",
    ),
)


def format_of(file: Path) -> Format:
    """Return the format that a file has by its ending; any that no other has is text's."""
    return next((each for each in FORMATS if file.suffix.lower() in each.endings), FORMATS[0])


def log_endings() -> tuple[str, ...]:
    """Return the endings by which a file is known to be a log."""
    return tuple(ending for each in FORMATS for ending in each.endings)


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
    (_JSON + rb'.*"axisid\.', "a result of axisid in JSON", "give the log that was identified"),
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
    if not drop_tail or table.repairs:
        return table
    text = "no rows left out at the end: this repair applies to delimited text only"
    return replace(table, repairs=(Repair(kind="tail", count=0, text=text),))


def _read_file(file: Path, room: Room, *, drop_tail: bool) -> Table:
    bag = is_bag(file)
    _check_regular(file, folder=bag)
    reader = read_bag if bag else format_of(file).read_file
    try:
        if file.is_file() and (wrong := _wrong_kind(file)):
            what, action = wrong
            raise DataError(
                f"{file} is {what} by its content. {action[0].upper()}{action[1:]}.",
                code="log-file",
            )
        with unchanged(bag_of(file) if bag else file) as files:
            if reader is None:
                room.take(file.stat().st_size)
                content = file.read_bytes()
                sha256 = hashlib.sha256(content).hexdigest()
            else:
                table = reader(file, room)
                sha256 = digest_of(files)
        if reader is None:
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
    packing = log_format = format_of(file)
    notes: tuple[str, ...] = ()
    if packing.opened is not None:
        log_format = format_of(Path(file.stem))
        if log_format.read_file is not None or log_format.opened is not None:
            raise DataError(
                f"{file} is compressed twice, or its format cannot be read compressed. Unpack it "
                "first."
            )
        content = _unpacked(packing.opened, file, content, room, text=log_format.is_text)
        notes = (f"unpacked by {packing.name}",)
    elif log_format.is_text:
        room.take_text(content)
    if log_format.read is None:
        others = ", ".join(each.endings[0] for each in FORMATS if not each.is_text)
        table = read_text(str(file), content, drop_tail=drop_tail, endings=others)
    else:
        table = log_format.read(file, content, room)
    return replace(table, notes=(*notes, *table.notes))


def _unpacked(
    opened: Callable[[Path, Any], Any], file: Path, content: bytes, room: Room, *, text: bool
) -> bytes:
    """The content of a packed file.

    Parameters
    ----------
    opened : callable
        Of the format that packs it.
    file : Path
        For messages.
    content : bytes
    room : Room
        The memory that there is for it.
    text : bool
        Whether it is read as text, which is counted at once: text takes the most.

    Raises
    ------
    DataError
        It is damaged, or unfolds to more than there is room for.
    """
    pieces = []
    with (
        refusing(f"{file} cannot be unpacked (unpack it, or compress it again)"),
        opened(file, io.BytesIO(content)) as stream,
    ):
        while piece := stream.read(1 << 20):
            room.take(2 * len(piece))  # by itself and joined
            if text:
                room.take_text(piece)
            pieces.append(piece)
    return b"".join(pieces)


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
        what = "a folder without a ROS 2 bag" if is_folder else "a pipe, a device or a socket"
        raise DataError(
            f"{file} is {what}, not a regular file. Give the file of the log.", code="log-file"
        )


def _wrong_kind(file: Path) -> tuple[str, str] | None:
    """What a file is by its first bytes and what to do, where its ending surely says another."""
    with file.open("rb") as stream:
        head = stream.read(4096)
    named = format_of(file)
    for pattern, kind, advice in _NO_LOGS:
        if re.match(pattern, head, re.DOTALL | re.IGNORECASE):
            return kind, advice
    for each in FORMATS:
        for start, kind in each.signatures.items():
            if head.startswith(start):
                advice = f"{_ASK}{each.endings[0]}{each.provided}"
                return None if each is named else (kind, advice)
    if named.opened is not None:
        return f"not compressed by {named.name}", f"{_ASK}of its format"
    if named.is_text and re.match(_JSON, head):
        return "a JSON document", f"{_ASK}.json, or .jsonl for a record in each line"
    # A table in text is printable and has lines.
    is_text = b"\n" in head and all(byte >= 0x20 or byte in b"\t\n\r\f" for byte in head)
    return ("text", f"{_ASK}.csv") if named.signatures and is_text else None
