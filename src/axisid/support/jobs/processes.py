"""Jobs on processes of their own: a job that hangs or kills its process takes nothing with it.

A pool of the standard library is broken by one process that dies, with all that it was to do. Here
each process has one job at a time, so it is known which one that was.
"""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Self

from axisid.support.errors import UsageError

from .one_thread import started_with_one_thread, without_arithmetic_warnings
from .outcome import Failure, attempt, failure_of, timed_out

_PATIENCE = 1.0  # s until a worker that was told to end is killed
#: How often a job is begun whose worker is killed: it may be innocent once.
ATTEMPTS = 2
_MOST_STILLBORN = 3  # workers in a row that end before they are ready


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
        self.process: BaseProcess = context.Process(
            target=_serve, args=(theirs, function), daemon=True
        )
        with started_with_one_thread():
            self.process.start()
        theirs.close()  # so that the pipe ends when the process does

    def end(self, patience: float = 0.0) -> None:
        """Let it end by itself; one that has not after so many seconds is killed."""
        self.pipe.close()
        self.process.join(patience)
        self.process.kill()
        self.process.join()

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
    """What a worker does: say that it is ready, then jobs, until the other end closes the pipe."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    without_arithmetic_warnings()
    with contextlib.suppress(EOFError, OSError):
        pipe.send(None)
        while True:
            made = attempt(function, pipe.recv())
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


def without_interrupts() -> None:
    """Keep Ctrl-C, which a terminal sends to all, from this thread and what it starts."""
    if hasattr(signal, "pthread_sigmask"):  # not on Windows
        resource_tracker.ensure_running()  # which lets them through again as it starts
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


class Processes:
    """Workers, one for each thread that has something to do; all of them end with the context.

    Parameters
    ----------
    function : callable
        As of a `Worker`.
    limit : float or None
        Seconds for one item; a process that takes longer is killed.
    """

    def __init__(self, function: Callable[[Any], Any], limit: float | None) -> None:
        self._function, self._limit = function, limit
        self._workers: list[Worker] = []
        self._idle: list[Worker] = []
        self._starting = threading.Lock()
        self._stillborn = 0
        self._is_over = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._starting:
            self._is_over = True
        for worker in self._workers:
            if worker not in self._idle:
                worker.process.kill()  # its thread does the rest
        for worker in self._idle:
            worker.end(_PATIENCE)

    def make(self, item: Any) -> Any:
        """What the function makes of an item, or why it makes nothing of it.

        Raises
        ------
        UsageError
            No process can be started, mostly since a script lacks ``if __name__ == "__main__":``.
        """
        how = ""
        for _ in range(ATTEMPTS):
            worker = self._waiting()
            try:
                worker.pipe.send(item)
                if not worker.pipe.poll(self._limit):
                    self._leave(worker)
                    return timed_out(self._limit)
                made = worker.pipe.recv()
            except (EOFError, OSError):
                how = worker.ended_by
                self._leave(worker)
                continue
            self._idle.append(worker)
            return made
        return Failure("killed", f"its worker was killed ({how}), {ATTEMPTS} times")

    def _waiting(self) -> Worker:
        """A worker that waits for a job."""
        while True:
            with self._starting:
                if self._is_over:
                    raise BrokenExecutor
                if self._idle:
                    return self._idle.pop()
                worker = Worker(self._function)
                self._workers.append(worker)
            try:
                worker.pipe.recv()
            except (EOFError, OSError):
                how = worker.ended_by
                self._leave(worker)
                self._stillborn += 1
                if self._stillborn < _MOST_STILLBORN:
                    continue
                raise UsageError(
                    f"processes end before they begin to work ({how}); what they say on standard "
                    "error tells why. A script has to call it under if __name__ == "
                    '"__main__":, since each process reads the script again.',
                    code="jobs",
                ) from None
            self._stillborn = 0
            return worker

    def _leave(self, worker: Worker) -> None:
        worker.end()
        self._workers.remove(worker)
