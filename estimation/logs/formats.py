"""The formats of logs, and what packs them: a row for each.

A new format is a reader in a file of its own and a row.
"""

import gzip
import io
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from axisid.estimation.tables import Table, library, refusing
from axisid.support.errors import DataError
from axisid.support.memory import Room

from .columnar import read_json, read_json_lines, read_npz, read_parquet
from .matlab import read_matlab
from .measurement import read_bag, read_mdf, read_tdms


class Packing(NamedTuple):
    """A way to pack a file.

    Attributes
    ----------
    name, ending : str
    start : bytes
        First bytes of such a file.
    opened : callable
        A stream of what is unpacked, of a file (for messages) and a stream of its content.
    """

    name: str
    ending: str
    start: bytes
    opened: Callable[[Path, Any], Any]


def _zstd(file: Path, content: Any) -> Any:
    """By Python itself from 3.14 on, else by one of two libraries."""
    every_frame = {"read_across_frames": True}
    ways: tuple[tuple[str, Callable[[Any], Any]], ...] = (
        ("compression.zstd", lambda m: m.open(content)),
        ("zstandard", lambda m: m.ZstdDecompressor().stream_reader(content, **every_frame)),
        ("pyarrow", lambda m: m.CompressedInputStream(m.PythonFile(content, "r"), "zstd")),
    )
    for name, opened in ways:
        with suppress(DataError):
            return opened(library(name, "zstd", file))
    raise DataError(
        f"{file} is compressed by zstd, which needs the library zstandard or pyarrow; run: pip "
        "install zstandard (or axisid with the extra zstd), or unpack it first.",
        code="missing-library",
    )


PACKINGS = (
    Packing(
        name="gzip",
        ending=".gz",
        start=b"\x1f\x8b",
        opened=lambda _, content: gzip.GzipFile(fileobj=content),
    ),
    Packing(name="zstd", ending=".zst", start=b"\x28\xb5\x2f\xfd", opened=_zstd),
)


def packing_of(file: Path) -> Packing | None:
    """Return the packing that a file has by its ending."""
    return next((packing for packing in PACKINGS if packing.ending == file.suffix.lower()), None)


def unpacked(packing: Packing, file: Path, content: bytes, room: Room, *, text: bool) -> bytes:
    """The content of a packed file.

    Parameters
    ----------
    packing : Packing
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
    damaged = DataError(f"{file} cannot be unpacked (unpack or compress it anew)", code="log-file")
    with refusing(damaged), packing.opened(file, io.BytesIO(content)) as stream:
        while piece := stream.read(1 << 20):
            room.take(2 * len(piece))  # by itself and joined
            if text:
                room.take_text(piece)
            pieces.append(piece)
    return b"".join(pieces)


class Signature(NamedTuple):
    """First bytes of a file, what a file that begins so is, and what else must be true of a log."""

    start: bytes
    kind: str
    provided: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A format of logs. One without a reader is delimited text.

    Attributes
    ----------
    name : str
        What it is called in a sentence.
    endings : tuple of str
        In lower case, first the one that advice gives.
    signatures : tuple of Signature
        By which a file is known that has another ending. A format without any may be text.
    read : callable or None
        The table of a file's content, from its path, content and the memory that there is.
    read_file : callable or None
        The table of a file that its library opens by itself, from its path and the memory.
    extra : str
        Of `pyproject.toml`, for what it needs beyond the core.
    """

    name: str
    endings: tuple[str, ...]
    signatures: tuple[Signature, ...] = ()
    read: Callable[[Path, bytes, Room], Table] | None = None
    read_file: Callable[[Path, Room], Table] | None = None
    extra: str = ""

    @property
    def is_text(self) -> bool:
        """Whether it is read as delimited text."""
        return self.read is None and self.read_file is None


#: In the order of messages.
FORMATS = (
    Format(name="delimited text", endings=(".csv", ".tsv", ".txt")),
    Format(name="LabVIEW measurement", endings=(".lvm",)),
    Format(
        name="MATLAB",
        endings=(".mat",),
        signatures=(
            Signature(b"MATLAB 5.0 MAT-file", "a MATLAB file"),
            Signature(b"MATLAB 7.3 MAT-file", "a MATLAB v7.3 file"),
            Signature(b"\x89HDF\r\n\x1a\n", "an HDF5 file"),
        ),
        read=read_matlab,
        extra="h5py",
    ),
    Format(
        name="Parquet",
        endings=(".parquet", ".pq"),
        signatures=(Signature(b"PAR1", "a Parquet file"),),
        read=read_parquet,
        extra="parquet",
    ),
    Format(name="JSON", endings=(".json",), read=read_json),
    Format(name="JSON lines", endings=(".jsonl", ".ndjson"), read=read_json_lines),
    Format(
        name="NumPy",
        endings=(".npz",),
        signatures=(
            Signature(b"PK\x03\x04", "a ZIP archive", " if it is NumPy's, else unpack it"),
        ),
        read=read_npz,
    ),
    Format(
        name="MDF",
        endings=(".mf4", ".mdf"),
        signatures=(
            Signature(b"MDF     ", "an MDF file"),
            Signature(b"UnFinMF ", "an MDF file that was not closed"),
        ),
        read_file=read_mdf,
        extra="mdf",
    ),
    Format(
        name="TDMS",
        endings=(".tdms",),
        signatures=(Signature(b"TDSm", "a TDMS file"),),
        read_file=read_tdms,
        extra="tdms",
    ),
    Format(
        name="ROS 1 bag",
        endings=(".bag",),
        signatures=(Signature(b"#ROSBAG", "a ROS 1 bag"),),
        read_file=read_bag,
        extra="rosbags",
    ),
    Format(
        name="ROS 2 bag",
        endings=(".db3",),
        signatures=(
            Signature(b"SQLite format 3\0", "an SQLite database", " if it is a ROS 2 bag"),
        ),
        read_file=read_bag,
        extra="rosbags",
    ),
    Format(
        name="MCAP",
        endings=(".mcap",),
        signatures=(Signature(b"\x89MCAP0\r\n", "an MCAP file"),),
        read_file=read_bag,
        extra="rosbags",
    ),
)


def format_of(file: Path) -> Format:
    """Return the format that a file has by its ending; any that no other has is text's."""
    return next((each for each in FORMATS if file.suffix.lower() in each.endings), FORMATS[0])


def log_endings() -> tuple[str, ...]:
    """Return the endings by which a file is known to be a log."""
    own = (ending for each in FORMATS for ending in each.endings)
    return (*own, *(packing.ending for packing in PACKINGS))


def format_endings() -> str:
    """Return the endings of what is no text, one of each format, for a sentence."""
    return ", ".join(each.endings[0] for each in FORMATS if not each.is_text)
