"""A terminal: documents in colours and within its width, and a line that says what takes long."""

import os
import shutil
import sys
import threading
import time
import warnings
from types import TracebackType
from typing import TYPE_CHECKING, Any, TextIO

import click

if TYPE_CHECKING:
    from axisid.presentation.blocks import Document

_ERASE = "\r\x1b[K"


def print_document(document: "Document") -> None:
    """Print a document: as it is on a pipe, dressed for a terminal."""
    # Help and what computes need neither of the two ways to draw.
    if not is_terminal(sys.stdout):
        from axisid.presentation.blocks import plain_text

        click.echo(plain_text(document), nl=False)
        return
    from .dressed import print_dressed

    coloured = not os.environ.get("NO_COLOR")
    print_dressed(document, sys.stdout, shutil.get_terminal_size().columns, coloured=coloured)


def is_terminal(stream: Any) -> bool:
    """Whether a stream is a terminal that knows colours and can erase a line."""
    dumb = os.environ.get("TERM", "dumb") == "dumb"
    return stream is not None and not dumb and bool(stream.isatty())


class ProgressLine:
    """Says on standard error what is going on, once that takes longer than a moment.

    It is drawn by a thread, so that what blocks (a compiler, a solver) is shown too, and erased at
    the end. It can be called as the `progress` of `sweep` and `compare`.

    Parameters
    ----------
    what : str
        What is going on, until something else is said.
    stream : file, optional
        Standard error by default; nothing is drawn where it is no terminal.
    delay, interval : float
        Seconds until the line appears, and between its changes.
    """

    def __init__(
        self, what: str, stream: TextIO | None = None, delay: float = 1.0, interval: float = 0.2
    ) -> None:
        self._what = what
        self._stream = sys.stderr if stream is None else stream
        self._delay, self._interval = delay, interval
        self._ended = threading.Event()
        self._drawing = threading.Lock()
        self._thread: threading.Thread | None = None
        self._begin = 0.0
        self._show_warning: Any = None

    def __enter__(self) -> "ProgressLine":
        if is_terminal(self._stream):
            self._begin = time.monotonic()
            self._show_warning, warnings.showwarning = warnings.showwarning, self._warn
            self._thread = threading.Thread(target=self._draw, daemon=True)
            self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._thread is not None:
            self._ended.set()
            self._thread.join()
            warnings.showwarning = self._show_warning

    def __call__(self, done: int, total: int, what: str) -> None:
        """Say what is done next."""
        self._what = f"{what} ({done + 1} of {total})"

    def _draw(self) -> None:
        wait, drawn = self._delay, False
        while not self._ended.wait(wait):
            wait, drawn = self._interval, True
            seconds = time.monotonic() - self._begin
            line = f"{self._what}, {seconds:.0f} s"
            with self._drawing:
                self._put(f"{_ERASE}{line[: shutil.get_terminal_size().columns - 1]}")
        if drawn:
            self._put(_ERASE)

    def _warn(self, *about: Any, **more: Any) -> None:
        """A warning in place of the line, which comes back under it."""
        with self._drawing:
            self._put(_ERASE)
            self._show_warning(*about, **more)

    def _put(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()
