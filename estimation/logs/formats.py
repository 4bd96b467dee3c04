"""Reading of a log of any format as a table, and the list of all formats and compressions.

A new format needs a reader, in a new module, and an entry in `FORMATS`.
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
    """Return a stream of the content, decompressed by Python from 3.14 on, otherwise by pyarrow.

    `file` is the path, for messages; `content` is a stream of the compressed content.
    """
    with suppress(DataError):
        return library("compression.zstd", "zstd", file).open(content)
    arrow = library("pyarrow", "zstd", file)
    return arrow.CompressedInputStream(arrow.PythonFile(content, "r"), "zstd")


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A format of logs, or of compressed files. A format without a reader is delimited text.

    Attributes
    ----------
    name : str
        Name of the format in messages.
    endings : tuple of str
        Endings of its files in lower case; messages advise the first one.
    signatures : mapping of bytes to str
        First bytes that identify a file of this format, also with another ending, and a description
        of such a file. A format without signatures may be text.
    provided : str
        Text after the advised ending in messages, such as a condition under which a file with these
        first bytes is a log.
    read : callable or None
        Reader of a format whose content is read first: it returns the table from the path, the
        content and the available memory. None for other formats.
    read_file : callable or None
        Reader of a format whose library opens the file itself: it returns the table from the path
        and the available memory. None for other formats.
    opened : callable or None
        Decompression: it returns a stream of the decompressed content from the path and a stream
        of the compressed content. None for a format of logs.
    extra : str
        Optional dependency in `pyproject.toml` that the format needs; empty for none.
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
        """True if files of this format are read as delimited text."""
        return self.read is None and self.read_file is None and self.opened is None


#: All formats, in the order in which messages list them.
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
        provided=" if it is a NumPy archive. Otherwise unpack it",
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
    """Return the format of a file by its ending; delimited text for an unknown ending."""
    return next((each for each in FORMATS if file.suffix.lower() in each.endings), FORMATS[0])


def log_endings() -> tuple[str, ...]:
    """Return the endings of all formats of logs and of compressed files."""
    return tuple(ending for each in FORMATS for ending in each.endings)


_ASK = "give the file the ending "
#: Pattern of the first bytes of a JSON document.
_JSON = rb'(\xef\xbb\xbf)?\s*(\{\s*"|\[\s*[\[{])'
#: Pattern of the first bytes of a file that is not a log, its description, and the remedy.
_NO_LOGS: tuple[tuple[bytes, str, str], ...] = (
    (rb"PK\x03\x04.*\bxl/", "an Excel workbook", "save the sheet of the log as CSV"),
    (rb"\x93NUMPY", "a NumPy array", "save the columns with numpy.savez, as .npz"),
    (rb"\xd0\xcf\x11\xe0", "an old Excel or Office file", "save its sheet as CSV"),
    (rb"%PDF", "a PDF document", "give the log itself"),
    (rb"\x89PNG|\xff\xd8\xff", "a picture", "give the log itself"),
    (rb"7z\xbc\xaf|Rar!", "an archive", "unpack the archive and give the log"),
    (rb"BZh|\xfd7zXZ\0", "compressed by bzip2 or xz", "unpack the file first"),
    (rb"\{\\rtf", "a word processor's document", "save the table as CSV"),
    (rb"(\xef\xbb\xbf)?\s*<(!doctype )?html", "a page in HTML", "export the log itself as CSV"),
    (rb"(\xef\xbb\xbf)?\s*<\?xml", "an XML document", "export the log as CSV"),
    (_JSON + rb'.*"axisid\.', "a result of axisid in JSON", "give the log that was identified"),
)


def read_table(
    log: str | Path | object, *, drop_tail: bool = False, max_memory: float | None = None
) -> Table:
    """Return all columns of a log of any format.

    Parameters
    ----------
    log : str, Path, dataframe or mapping
        As in `read_record`.
    drop_tail : bool
        True if incomplete lines at the end of a text may be left out, see `Repairs.tail`.
    max_memory : float, optional
        Largest memory for reading a file, bytes; half of the machine's memory by default.

    Raises
    ------
    DataError, UsageError
        The log cannot be read, see the readers of the formats.
    """
    if isinstance(log, (str, Path)):
        table = _read_file(Path(log), room_for(log, max_memory), drop_tail=drop_tail)
        table = replace(table, source=str(log))
    else:
        table = read_frame(log)
    if not drop_tail or table.repairs:
        return table
    text = "no rows are left out at the end, as this repair applies to delimited text only"
    return replace(table, repairs=(Repair(kind="tail", count=0, text=text),))


def _read_file(file: Path, room: Room, *, drop_tail: bool) -> Table:
    """Return the columns of a file, or of the folder of a ROS 2 bag, with its SHA-256 and path.

    Raises
    ------
    DataError
        The file is missing, has another format than its ending indicates, changes while it is
        read, or needs more memory than is available (`room`).
    """
    bag = is_bag(file)
    _check_regular(file, folder=bag)
    reader = read_bag if bag else format_of(file).read_file
    try:
        if file.is_file() and (wrong := _wrong_kind(file)):
            what, action = wrong
            raise DataError(
                f"{file} is {what}, according to its content. {action[0].upper()}{action[1:]}.",
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
    """Return the table of a file's content, which is decompressed first if it is compressed.

    Raises
    ------
    DataError
        The content cannot be unpacked or parsed, or needs more memory than is available (`room`).
    """
    # The format of a compressed file is that of its name without the last ending.
    packing = log_format = format_of(file)
    notes: tuple[str, ...] = ()
    if packing.opened is not None:
        log_format = format_of(Path(file.stem))
        if log_format.read_file is not None or log_format.opened is not None:
            raise DataError(
                f"{file} is compressed twice, or its format cannot be read compressed. Unpack the "
                "file first."
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
    """Return the decompressed content of a file.

    Parameters
    ----------
    opened : callable
        Function that opens a stream of the decompressed content, see `Format.opened`.
    file : Path
        Path of the file, for messages.
    content : bytes
        Compressed content.
    room : Room
        Available memory.
    text : bool
        True if the content is text: the memory for its columns is then also counted here, as a
        text needs more memory than other formats.

    Raises
    ------
    DataError
        The file is damaged, or its content needs more memory than is available.
    """
    pieces = []
    with (
        refusing(
            f"{file} cannot be unpacked. Unpack it with another program, or compress it again. The "
            "error is"
        ),
        opened(file, io.BytesIO(content)) as stream,
    ):
        while piece := stream.read(1 << 20):
            room.take(2 * len(piece))  # memory of the piece, and of the joined pieces
            if text:
                room.take_text(piece)
            pieces.append(piece)
    return b"".join(pieces)


def _check_regular(file: Path, *, folder: bool) -> None:
    """Refuse a path that is not a regular file, such as a pipe; a folder is allowed if `folder`.

    Raises
    ------
    DataError
        The path is neither a regular file nor an allowed folder, or does not exist.
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
    """Return the kind of a file by its first bytes, and the remedy, if its ending is wrong.

    None if the ending may be correct. The kind follows "is" in the message.
    """
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
