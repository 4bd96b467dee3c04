"""Files whose hash is of the very bytes that were used: hashed while read, changes refused."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from axisid.support.errors import DataError

#: What tells a file from the same file at another time: device, number, size and time of change.
Stamp = tuple[int, int, int, int]


def changed(file: Path) -> DataError:
    """The error of a file that changed while it was read."""
    return DataError(
        f"{file} changed while it was read. Wait until what writes it has closed it, or take a "
        "copy, and read that.",
        code="log-file",
    )


def stamps(path: Path) -> dict[Path, Stamp]:
    """The stamp of a file, or of every file of a folder.

    Raises
    ------
    OSError
        It cannot be read.
    """
    files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
    return {file: _stamp(file.stat()) for file in files}


def _stamp(status: Any) -> Stamp:
    return (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)


def digest_of(files: Iterator[Path] | list[Path]) -> str:
    """SHA-256 of the contents of files, one after the other."""
    digest = hashlib.sha256()
    for file in files:
        with file.open("rb") as stream:
            hashlib.file_digest(stream, lambda: digest)
    return digest.hexdigest()


def read_whole(file: Path) -> tuple[bytes, str]:
    """The content of a file and its SHA-256.

    Raises
    ------
    OSError
        It cannot be read.
    DataError
        It changed meanwhile.
    """
    before = stamps(file)
    content = file.read_bytes()
    if stamps(file) != before:
        raise changed(file)
    return content, hashlib.sha256(content).hexdigest()
