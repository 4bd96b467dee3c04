"""Files whose hash is of the very bytes that were used: hashed while read, changes refused."""

import hashlib
import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from axisid.support.errors import DataError

_BLOCK = 1 << 20  # bytes

#: What tells a file from the same file at another time: device, number, size and time of change.
Stamp = tuple[int, int, int, int]


def changed(file: Path) -> DataError:
    """The error of a file that changed while it was read."""
    return DataError(
        f"{file} changed while it was read. Wait until what writes it has closed it, or take a "
        "copy, and read that.",
        code="changed-file",
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
            _feed(digest, stream)
    return digest.hexdigest()


def _feed(digest: Any, stream: io.BufferedReader) -> None:
    while block := stream.read(_BLOCK):
        digest.update(block)


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


@dataclass(slots=True)
class WatchedFile:
    """A file that is read several times and has to stay what it was the first time.

    Attributes
    ----------
    file : Path
    sha256 : str
        Of every pass so far; empty before the first was complete.
    """

    file: Path
    sha256: str = ""
    _stamp: Stamp | None = field(default=None, repr=False)

    @contextmanager
    def opened(self) -> Iterator["HashingStream"]:
        """Open the file for a pass; call `finish` once all of it was used.

        Raises
        ------
        DataError
            It changed since the last pass, or did during this one.
        """
        with HashingStream(self.file) as raw:
            self._hold(raw)
            yield raw

    def finish(self, raw: "HashingStream") -> None:
        """Hold a pass that came to its end against those before it.

        Raises
        ------
        DataError
            The bytes were others.
        """
        sha256 = raw.digest()
        self._hold(raw)
        if self.sha256 and sha256 != self.sha256:
            raise changed(self.file)
        self.sha256 = sha256

    def complete(self) -> str:
        """SHA-256 of the file, by a pass of its own where there was none."""
        if not self.sha256:
            with self.opened() as raw:
                self.finish(raw)
        return self.sha256

    def _hold(self, raw: "HashingStream") -> None:
        stamp = raw.stamp()
        if self._stamp is not None and stamp != self._stamp:
            raise changed(self.file)
        self._stamp = stamp


class HashingStream(io.RawIOBase):
    """An open file that hashes what is read of it in order.

    What is read out of order, as Parquet is, is hashed at the end by a pass of its own.
    """

    def __init__(self, file: Path) -> None:
        self._file = file.open("rb", buffering=0)
        self._digest, self._hashed, self._place = hashlib.sha256(), 0, 0

    def readable(self) -> bool:
        """Say that it can be read."""
        return True

    def seekable(self) -> bool:
        """Say that it can be read in any order."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read into a buffer, and hash what comes next to what was hashed."""
        count = self._file.readinto(buffer) or 0
        if self._place == self._hashed:
            self._digest.update(memoryview(buffer)[:count])
            self._hashed += count
        self._place += count
        return count

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Go to a place."""
        self._place = self._file.seek(offset, whence)
        return self._place

    def tell(self) -> int:
        """Say where the next byte is read."""
        return self._place

    def stamp(self) -> Stamp:
        """The stamp of the file as it is now, by its path: another may have taken its place."""
        return _stamp(Path(self._file.name).stat())

    def digest(self) -> str:
        """SHA-256 of the whole file, what was not read in order yet included."""
        self.seek(self._hashed)
        buffer = bytearray(_BLOCK)
        while self.readinto(buffer):
            pass
        return self._digest.hexdigest()

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()
