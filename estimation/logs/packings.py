"""What packs a log of any format: how such a file is known, and unpacked piece by piece."""

import gzip
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from axisid.estimation.tables import library, refusing
from axisid.support.errors import DataError
from axisid.support.files.memory import Room

_PIECE = 1 << 20  # bytes that are unpacked before they are counted


@dataclass(frozen=True, slots=True, kw_only=True)
class Packing:
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
    ways: tuple[tuple[str, Callable[[Any], Any]], ...] = (
        ("compression.zstd", lambda m: m.open(content)),
        ("zstandard", lambda m: m.ZstdDecompressor().stream_reader(content, **_EVERY_FRAME)),
        ("pyarrow", lambda m: m.CompressedInputStream(m.PythonFile(content, "r"), "zstd")),
    )
    for name, opened in ways:
        try:
            return opened(library(name, "zstd", file))
        except DataError:
            continue
    raise DataError(
        f"{file} is compressed by zstd, which needs the library zstandard or pyarrow; run: pip "
        "install zstandard (or axisid with the extra zstd), or unpack it first.",
        code="no-zstd",
    )


_EVERY_FRAME = {"read_across_frames": True}

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
    ending = file.suffix.lower()
    return next((packing for packing in PACKINGS if packing.ending == ending), None)


def packing_by_content(head: bytes) -> Packing | None:
    """Return the packing that first bytes are those of."""
    return next((packing for packing in PACKINGS if head.startswith(packing.start)), None)


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
    damaged = DataError(
        f"{file} cannot be unpacked (unpack or compress it anew)", code="damaged-packing"
    )
    with refusing(damaged), packing.opened(file, io.BytesIO(content)) as stream:
        while piece := stream.read(_PIECE):
            room.take(2 * len(piece))  # by itself and joined
            if text:
                room.take_text(piece)
            pieces.append(piece)
    return b"".join(pieces)
