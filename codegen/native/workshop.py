"""A process of its own for what may crash or hang: a compiler, and a library nobody has tried."""

import contextlib
import os
import pickle
import selectors
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from .errors import NativeUnavailableError, WrongLibraryError

_PROCESS = Path(__file__).with_name("workshop_process.py")
_NUMBER, _REPLY = struct.Struct("<q"), struct.Struct("<q?")
_LEAVE_SECONDS = 5.0


class Workshop:
    """A process that runs a compiler, and loads and calls what came of it.

    A library that ends its process ends that one, not this. When this process is gone, even killed,
    the other ends the compiler and removes the folder.

    Parameters
    ----------
    folder : Path
        Where it works.
    seconds : float
        Time limit of each thing it is asked.

    Raises
    ------
    NativeUnavailableError
        No such process can be started.
    """

    def __init__(self, folder: Path, seconds: float) -> None:
        if not sys.executable or getattr(sys, "frozen", False):
            raise NativeUnavailableError("there is no Python interpreter to try a library in")
        self.seconds = seconds
        try:
            self._process = subprocess.Popen(  # noqa: S603
                [sys.executable, "-I", "-S", str(_PROCESS), str(folder), str(os.getpid())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                bufsize=0,
                start_new_session=True,  # Ctrl-C is for this process to answer
            )
        except OSError as error:
            raise NativeUnavailableError(
                f"{sys.executable} does not run: {error.strerror}"
            ) from error

    def __enter__(self) -> "Workshop":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with contextlib.suppress(OSError):
            self._send("leave")
        try:
            self._process.wait(timeout=_LEAVE_SECONDS)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()

    def run(self, command: Sequence[str], output: str) -> int:
        """Run a command in the folder, what it says into a file there; its exit code.

        Raises
        ------
        TimeoutError
            It does not finish in time.
        OSError
            It does not start.
        """
        return int(_NUMBER.unpack(self._ask("run", list(command), output))[0])

    def load(self, library: Path) -> None:
        """Load a library.

        Raises
        ------
        NativeUnavailableError
            It ends the process, or does not load in time.
        OSError
            It is no library.
        """
        with self._blamed(NativeUnavailableError, "does not load"):
            self._ask("load", str(library))

    def call(self, function: str, *arguments: Any) -> int:
        """Call a function of the library with whole numbers, floats, arrays and None.

        The arrays are then as the function left them, those that may be written to.

        Raises
        ------
        WrongLibraryError
            It ends the process, or does not return in time.
        OSError
            The library has no such function.
        """
        sent = [a.tobytes() if isinstance(a, np.ndarray) else a for a in arguments]
        with self._blamed(WrongLibraryError, "does not run"):
            reply = self._ask("call", function, sent)
        at = _NUMBER.size
        for array in arguments:
            if isinstance(array, np.ndarray):
                if array.flags.writeable:
                    values = np.frombuffer(reply, array.dtype, array.size, at)
                    array[...] = values.reshape(array.shape)
                at += array.nbytes
        return int(_NUMBER.unpack_from(reply)[0])

    @contextlib.contextmanager
    def _blamed(self, kind: type[NativeUnavailableError], what: str) -> Iterator[None]:
        """Say of the library what becomes of the process."""
        try:
            yield
        except TimeoutError as error:
            reason = f"it does not return within {self.seconds:g} s"
            raise kind(f"the compiled library {what}: {reason}") from error
        except EOFError as error:
            reason = f"it ends its process ({self._end()})"
            raise kind(f"the compiled library {what}: {reason}") from error

    def _end(self) -> str:
        """How the process ended, in words."""
        try:
            code = self._process.wait(timeout=_LEAVE_SECONDS)
        except subprocess.TimeoutExpired:
            return "it answers no more"
        if code < 0:
            with contextlib.suppress(ValueError):
                return signal.Signals(-code).name
        return f"exit code {code}"

    def _ask(self, task: str, *arguments: Any) -> bytes:
        deadline = time.monotonic() + self.seconds
        try:
            self._send(task, *arguments)
        except BrokenPipeError:
            raise EOFError from None
        length, failed = _REPLY.unpack(self._read(_REPLY.size, deadline))
        content = self._read(length, deadline)
        if failed:
            raise OSError(content.decode(errors="replace"))
        return content

    def _send(self, task: str, *arguments: Any) -> None:
        body = pickle.dumps((task, *arguments))
        message = _NUMBER.pack(len(body)) + body
        assert self._process.stdin is not None  # noqa: S101
        while message:
            message = message[self._process.stdin.write(message) or 0 :]

    def _read(self, size: int, deadline: float) -> bytes:
        pipe = self._process.stdout
        assert pipe is not None  # noqa: S101
        content = b""
        with selectors.DefaultSelector() as selector:
            selector.register(pipe, selectors.EVENT_READ)
            while len(content) < size:
                left = deadline - time.monotonic()
                if left <= 0 or not selector.select(left):
                    raise TimeoutError
                read = pipe.read(size - len(content))
                if not read:
                    raise EOFError
                content += read
        return content
