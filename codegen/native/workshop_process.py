"""The process in which a library is compiled and tried: run by `Workshop`, never imported.

It needs the standard library alone, so that it starts at once. What it is asked comes through
standard input: a length, then as much of a pickle, ``(task, argument, ...)``. It answers each with
a length, whether it failed, and as many bytes. When its maker is gone, however that ended, it ends
what it started and removes its folder.
"""

import contextlib
import ctypes
import os
import pickle
import select
import shutil
import signal
import struct
import sys
from _thread import allocate_lock, start_new_thread
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

_LOOKS = 1.0  # s between looks whether the maker is alive: its forks may hold the pipe open
_NUMBER, _REPLY = struct.Struct("<q"), struct.Struct("<q?")


class _Bench:
    """What is done in the process: a compiler runs, a library is loaded and called."""

    def __init__(self) -> None:
        self._library: ctypes.CDLL | None = None
        self._compiler = 0
        self._lock = allocate_lock()

    def run(self, command: Sequence[str], output: str) -> bytes:
        """Run a command in the current folder; its exit code, negative for a signal."""
        into = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        actions = [
            (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
            # Into a file: what the compiler starts may outlive it and hold a pipe open.
            (os.POSIX_SPAWN_OPEN, 1, output, into, 0o600),
            (os.POSIX_SPAWN_DUP2, 1, 2),
        ]
        with self._lock:
            self._compiler = os.posix_spawn(
                command[0], list(command), os.environ, file_actions=actions, setpgroup=0
            )
        _, status = os.waitpid(self._compiler, 0)
        self.end()
        return _NUMBER.pack(os.waitstatus_to_exitcode(status))

    def end(self) -> None:
        """End the compiler and whatever it started."""
        with self._lock:
            if self._compiler:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(self._compiler, signal.SIGKILL)
                self._compiler = 0

    def load(self, path: str) -> bytes:
        """Load a library."""
        self._library = ctypes.CDLL(path)
        return b""

    def call(self, function: str, arguments: Sequence[Any]) -> bytes:
        """Call a function; what it returns, and the content of the arrays after the call."""
        converted = [_as_c(argument) for argument in arguments]
        status = getattr(self._library, function)(*converted)
        arrays = [each.raw for each in converted if isinstance(each, ctypes.Array)]
        return b"".join([_NUMBER.pack(status), *arrays])


def _as_c(argument: Any) -> Any:
    if isinstance(argument, bytes):
        return ctypes.create_string_buffer(argument, len(argument))
    if isinstance(argument, float):
        return ctypes.c_double(argument)
    return None if argument is None else ctypes.c_ssize_t(argument)


def _read(size: int, parent: int) -> bytes | None:
    """So many bytes of standard input; None when the maker is gone."""
    content = b""
    while len(content) < size:
        ready, _, _ = select.select([0], [], [], _LOOKS)
        if ready:
            read = os.read(0, size - len(content))
            if not read:
                return None
            content += read
        elif os.getppid() != parent:
            return None
    return content


def _work(task: Callable[..., bytes], arguments: Sequence[Any], replies: int) -> None:
    failed = False
    try:
        content = task(*arguments)
    except Exception as error:
        said = error.strerror if isinstance(error, OSError) else None
        failed, content = True, (said or str(error)).encode(errors="replace")
    message = _REPLY.pack(len(content), failed) + content
    with contextlib.suppress(OSError):
        while message:
            message = message[os.write(replies, message) :]


def main(folder: str, parent: int) -> NoReturn:
    """Work in a folder until the maker says that it is enough, or is gone."""
    os.chdir(folder)
    os.environ["TMPDIR"] = folder  # what a compiler leaves there when it is killed goes with it
    replies, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)  # what a library prints is no reply
    bench = _Bench()
    while (header := _read(_NUMBER.size, parent)) is not None:
        body = _read(_NUMBER.unpack(header)[0], parent)
        if body is None:
            break
        task, *arguments = pickle.loads(body)  # noqa: S301
        if task == "leave":
            bench.end()
            os._exit(0)
        # In a thread, so that this one sees when the maker goes.
        start_new_thread(_work, (getattr(bench, task), arguments, replies))
    bench.end()
    os.chdir("/")
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
