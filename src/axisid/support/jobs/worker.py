"""A process that takes jobs one by one, and how it is started."""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import monotonic
from typing import Any

from .arithmetic import without_arithmetic_warnings
from .one_thread import started_with_one_thread
from .outcome import attempt, failure_of

#: What a worker says once it has the function.
READY = "ready"
_PATIENCE = 1.0  # s until a worker that was told to end is killed


class Worker:
    """A process that was started afresh, not forked, and the pipe to it.

    Parameters
    ----------
    function : callable
        Takes an item and gives its value; a name of a module, which the process imports.
    """

    def __init__(self, function: Callable[[Any], Any]) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, function), daemon=True)
        with started_with_one_thread(), _without_interrupts():
            process.start()
        theirs.close()  # so that the pipe ends when the process does
        self.process: BaseProcess = process
        self.place: int | None = None
        self.is_ready = False
        self._deadline: float | None = None

    def give(self, place: int, item: Any, limit: float | None) -> None:
        """Begin a job; one that cannot be sent is the sender's error."""
        self.pipe.send(item)
        self.place = place
        self._deadline = None if limit is None else monotonic() + limit

    def take(self) -> Any:
        """What it says: that it is ready, or what became of its job.

        Raises
        ------
        EOFError, OSError
            The process is dead.
        """
        said = self.pipe.recv()
        self._deadline = None
        return said

    @property
    def left(self) -> float | None:
        """Seconds that its job may still take; None for any."""
        return None if self._deadline is None else self._deadline - monotonic()

    def end(self) -> None:
        """Let it end by itself; one that does not is killed."""
        with contextlib.suppress(OSError):
            self.pipe.send(None)
        self.process.join(_PATIENCE)
        self.kill()

    def kill(self) -> None:
        """End it at once, whatever it does."""
        self.process.kill()
        self.process.join()
        self.pipe.close()

    @property
    def ended_by(self) -> str:
        """How a dead process came to its end."""
        self.process.join(_PATIENCE)
        code = self.process.exitcode
        if code is None or code >= 0:
            return f"exit code {code}"
        with contextlib.suppress(ValueError):
            return signal.Signals(-code).name
        return f"signal {-code}"


def _serve(pipe: Connection, function: Callable[[Any], Any]) -> None:
    """What a worker does: jobs, until the other end of the pipe closes or says that it is all."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    without_arithmetic_warnings()
    pipe.send(READY)
    with contextlib.suppress(EOFError, OSError):
        while (item := pipe.recv()) is not None:
            made = attempt(function, item[0])
            try:
                pipe.send(made)
            except (TypeError, ValueError, AttributeError) as error:  # it cannot be pickled
                pipe.send(failure_of(error))


def _end_with_parent() -> None:
    """End this process when the one that started it is gone, whatever a job does meanwhile."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Keep Ctrl-C, which a terminal sends to all, from what is started now; ours is only late."""
    mask = getattr(signal, "pthread_sigmask", None)  # not on Windows
    if mask is None:
        yield
        return
    before = mask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        mask(signal.SIG_SETMASK, before)
