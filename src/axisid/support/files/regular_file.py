"""Files that are read, regular ones, since a pipe may never end; and what is written whole."""

import errno
import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path

from axisid.support.errors import UsageError


@contextmanager
def opened_regular(path: Path) -> Iterator[BufferedReader]:
    """Open a regular file for reading; a link is followed.

    Raises
    ------
    OSError
        It cannot be read, or is a pipe, a socket, a device or a folder.
    """
    # Without O_NONBLOCK the opening of a pipe waits for who writes to it.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "no regular file")
        with open(descriptor, "rb", closefd=False) as file:
            yield file
    finally:
        os.close(descriptor)


def read_regular(path: Path) -> bytes:
    """Return the content of a regular file; a link is followed.

    Raises
    ------
    OSError
        It cannot be read, or is a pipe, a socket, a device or a folder.
    """
    with opened_regular(path) as file:
        return file.read()


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file, text as UTF-8, whole or not at all, through a temporary file beside it.

    A link is followed. What is no regular file (a device, a pipe) is written to, not replaced. An
    existing file keeps its mode; a new one gets the user's default.

    Raises
    ------
    OSError
        The file system refuses; the file is as it was.
    """
    # Names of files may hold bytes that are no text.
    data = content.encode(errors="replace") if isinstance(content, str) else content
    if path.exists() and not path.is_file():
        path.write_bytes(data)  # by this name: that of an open pipe leads nowhere
        return
    try:
        path = path.resolve()
    except RuntimeError as error:  # before Python 3.13
        raise OSError(errno.ELOOP, "the link leads to itself") from error
    if path.exists() and not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, "the file is read-only")
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with temporary.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            shutil.copymode(path, temporary)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def write_file(path: Path, content: str | bytes) -> Path:
    """Write a file as `replace_file` does, and return its path.

    Raises
    ------
    UsageError
        The file system refuses; the file is as it was.
    """
    try:
        replace_file(path, content)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}.", code="file") from error
    return path


@contextmanager
def kept_if_filled(place: Path) -> Iterator[None]:
    """A folder, which is not left behind empty where it is new and what is done ends early.

    Raises
    ------
    OSError
        It cannot be made.
    """
    fresh = not place.exists()
    place.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        if fresh:
            with suppress(OSError):
                place.rmdir()
        raise
