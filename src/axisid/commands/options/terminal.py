"""A terminal: documents in colours and within its width, and a line that says what takes long."""

import os
import shutil
import sys
import threading
from typing import TYPE_CHECKING, Any, TextIO

import click

if TYPE_CHECKING:
    from rich.progress import Progress

    from axisid.presentation.documents import Document


def print_document(document: "Document") -> None:
    """Print a document: as it is on a pipe, dressed for a terminal."""
    # Help and what computes need neither of the two ways to draw.
    if not is_terminal(sys.stdout):
        from axisid.presentation.documents import plain_text

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
    delay : float
        Seconds until the line appears.
    """

    def __init__(self, what: str, stream: TextIO | None = None, delay: float = 1.0) -> None:
        self._what = what
        self._stream = sys.stderr if stream is None else stream
        self._delay = delay
        self._progress: Progress | None = None

    def __enter__(self) -> "ProgressLine":
        if is_terminal(self._stream):
            from rich.console import Console
            from rich.progress import Progress, TextColumn, TimeElapsedColumn

            self._progress = Progress(
                TextColumn("{task.description}", markup=False),
                TimeElapsedColumn(),
                console=Console(file=self._stream),
                redirect_stdout=False,
                transient=True,
            )
            self._task = self._progress.add_task(self._what, total=None)
            self._timer = threading.Timer(self._delay, self._progress.start)
            self._timer.daemon = True
            self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._progress is not None:
            self._timer.cancel()
            self._timer.join()
            self._progress.stop()

    def __call__(self, done: int, total: int, what: str) -> None:
        """Say what is done next."""
        if self._progress is not None:
            self._progress.update(self._task, description=f"{what} ({done + 1} of {total})")
