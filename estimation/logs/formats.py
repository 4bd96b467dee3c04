"""The formats of logs: a row for each. A new one is a reader in a file of its own and a row."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from axisid.estimation.tables import Table
from axisid.support.files.memory import Room

from .columnar import read_npz, read_parquet
from .json_log import read_json, read_json_lines
from .matlab import read_matlab
from .measurement import read_mdf, read_tdms
from .packings import PACKINGS
from .rosbag import read_bag

#: First bytes of an archive, whatever is in it.
ZIP = b"PK\x03\x04"


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
        By which a file is known that has another ending.
    start : bytes
        First bytes that its files share with other kinds. A format with neither is known by its
        ending alone, and its files may be text.
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
    start: bytes = b""
    read: Callable[[Path, bytes, Room], Table] | None = None
    read_file: Callable[[Path, Room], Table] | None = None
    extra: str = ""

    @property
    def is_text(self) -> bool:
        """Whether it is read as delimited text."""
        return self.read is None and self.read_file is None

    @property
    def is_binary(self) -> bool:
        """Whether its files are known not to be text."""
        return bool(self.signatures or self.start)


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
    # An archive is known by what is in it.
    Format(name="NumPy", endings=(".npz",), start=ZIP, read=read_npz),
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
_TEXT = FORMATS[0]


def format_of(file: Path) -> Format:
    """Return the format that a file has by its ending; any that no other has is text's."""
    ending = file.suffix.lower()
    return next((each for each in FORMATS if ending in each.endings), _TEXT)


def format_by_content(head: bytes) -> tuple[Format, Signature] | None:
    """Return the format that first bytes are those of, and the signature that says so."""
    for each in FORMATS:
        for signature in each.signatures:
            if head.startswith(signature.start):
                return each, signature
    return None


def log_endings() -> tuple[str, ...]:
    """Return the endings by which a file is known to be a log."""
    packed = (packing.ending for packing in PACKINGS)
    return (*(ending for each in FORMATS for ending in each.endings), *packed)


def format_endings() -> str:
    """Return the endings of what is no text, one of each format, for a sentence."""
    return ", ".join(each.endings[0] for each in FORMATS if not each.is_text)
