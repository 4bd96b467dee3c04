"""The formats of logs: a row for each. A new one is a reader in a file of its own and a row."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from axisid.estimation.logs.text import text_blocks
from axisid.estimation.tables import Table
from axisid.support.files.memory import Room

from .columnar import parquet_blocks, read_npz, read_parquet
from .json_log import json_lines_blocks, read_json, read_json_lines
from .matlab import matlab_blocks, read_matlab
from .measurement import read_mdf, read_tdms
from .measurement_blocks import mdf_blocks, tdms_blocks
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
    blocks : callable or None
        The table so many rows at a time, from the file's name, the opened file and the rows; of
        text also from the encoding. None for what is read whole only.
    whole : str
        Why it is read whole only, in words.
    extra : str
        Of `pyproject.toml`, for what it needs beyond the core.
    """

    name: str
    endings: tuple[str, ...]
    signatures: tuple[Signature, ...] = ()
    start: bytes = b""
    read: Callable[[Path, bytes, Room], Table] | None = None
    read_file: Callable[[Path, Room], Table] | None = None
    blocks: Callable[..., Iterator[Table]] | None = None
    in_order: bool = False
    whole: str = ""
    extra: str = ""

    @property
    def is_text(self) -> bool:
        """Whether it is read as delimited text."""
        return self.read is None and self.read_file is None

    @property
    def in_blocks(self) -> str:
        """What of it is read in blocks, for a sentence."""
        return f"{self.name} v7.3" if self.blocks is matlab_blocks else self.name

    @property
    def is_binary(self) -> bool:
        """Whether its files are known not to be text."""
        return bool(self.signatures or self.start)


_MESSAGES = "its messages come one by one, each topic at its own times"
#: In the order of messages.
FORMATS = (
    Format(
        name="delimited text",
        endings=(".csv", ".tsv", ".txt"),
        blocks=text_blocks,
        in_order=True,
    ),
    Format(
        name="LabVIEW measurement",
        endings=(".lvm",),
        whole="its head is repeated for each of its tables",
    ),
    Format(
        name="MATLAB",
        endings=(".mat",),
        signatures=(
            Signature(b"MATLAB 5.0 MAT-file", "a MATLAB file"),
            Signature(b"MATLAB 7.3 MAT-file", "a MATLAB v7.3 file"),
            Signature(b"\x89HDF\r\n\x1a\n", "an HDF5 file"),
        ),
        read=read_matlab,
        blocks=matlab_blocks,
        extra="h5py",
    ),
    Format(
        name="Parquet",
        endings=(".parquet", ".pq"),
        signatures=(Signature(b"PAR1", "a Parquet file"),),
        read=read_parquet,
        blocks=parquet_blocks,
        extra="parquet",
    ),
    Format(name="JSON", endings=(".json",), read=read_json, whole="it is one value"),
    Format(
        name="JSON lines",
        endings=(".jsonl", ".ndjson"),
        read=read_json_lines,
        blocks=json_lines_blocks,
        in_order=True,
    ),
    # An archive is known by what is in it.
    Format(
        name="NumPy",
        endings=(".npz",),
        start=ZIP,
        read=read_npz,
        whole="its arrays lie one after the other, each packed",
    ),
    Format(
        name="MDF",
        endings=(".mf4", ".mdf"),
        signatures=(
            Signature(b"MDF     ", "an MDF file"),
            Signature(b"UnFinMF ", "an MDF file that was not closed"),
        ),
        read_file=read_mdf,
        blocks=mdf_blocks,
        extra="mdf",
    ),
    Format(
        name="TDMS",
        endings=(".tdms",),
        signatures=(Signature(b"TDSm", "a TDMS file"),),
        read_file=read_tdms,
        blocks=tdms_blocks,
        extra="tdms",
    ),
    Format(
        name="ROS 1 bag",
        endings=(".bag",),
        signatures=(Signature(b"#ROSBAG", "a ROS 1 bag"),),
        read_file=read_bag,
        whole=_MESSAGES,
        extra="rosbags",
    ),
    Format(
        name="ROS 2 bag",
        endings=(".db3",),
        signatures=(
            Signature(b"SQLite format 3\0", "an SQLite database", " if it is a ROS 2 bag"),
        ),
        read_file=read_bag,
        whole=_MESSAGES,
        extra="rosbags",
    ),
    Format(
        name="MCAP",
        endings=(".mcap",),
        signatures=(Signature(b"\x89MCAP0\r\n", "an MCAP file"),),
        read_file=read_bag,
        whole=_MESSAGES,
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


def streamed_formats() -> str:
    """Return what can be read in blocks, for a sentence."""
    *first, last = (
        f"{each.name} ({', '.join(each.endings)})" if each.is_text else each.in_blocks
        for each in FORMATS
        if each.blocks is not None
    )
    return f"{', '.join(first)} or {last}"
