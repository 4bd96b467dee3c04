"""Files that are read: regular ones, since a pipe or a device may never end."""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path


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
