"""Many jobs on many workers: none of them harms another, and an interrupt ends them all.

They run on processes of their own or on any executor of `concurrent.futures`. A pool of the
standard library is broken by one process that dies, with all that it was to do. Here each process
has one job at a time, so it is known which one that was.
"""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import chain
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from time import monotonic
from typing import Any, Literal, Self, TypeVar

from .errors import UsageError
from .one_thread import started_with_one_thread, without_arithmetic_warnings
from .progress import Progress

Item = TypeVar("Item")
Value = TypeVar("Value")

_PATIENCE = 1.0  # s until a worker that was told to end is killed
_ATTEMPTS = 2  # how often a job is begun whose worker is killed: it may be innocent once
_MOST_STILLBORN = 3  # workers in a row that end before they are ready
_MOST_AHEAD = 1000  # items that an executor is given ahead of those that are done


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a job has no value.

    Attributes
    ----------
    kind : {"error", "time", "killed"}
        The function raised, the time limit ended it, or its worker was killed.
    reason : str
        A sentence without its full stop.
    """

    kind: Literal["error", "time", "killed"]
    reason: str


def run_jobs(
    function: Callable[[Item], Value],
    items: Iterable[Item],
    *,
    total: int,
    jobs: int = 1,
    executor: Executor | None = None,
    limit: float | None = None,
    progress: Progress | None = None,
    said: str = "at work",
) -> Iterator[tuple[int, Value | Failure]]:
    """What a function makes of items, or why nothing, as they end, each with its item's place.

    Parameters
    ----------
    function : callable
        Takes an item; of a module, so that other processes find it.
    items : iterable
    total : int
        How many there are.
    jobs : int
        Processes, no more than items; 0 for this process itself, which no time limit ends and
        nothing shields.
    executor : Executor, optional
        Any of `concurrent.futures` in place of processes, such as a `Client.get_executor()` of
        Dask. It is not shut down. What an executor of processes did not do when one of them died
        goes on processes of our own, as many as it had, which tell the item that did it.
    limit : float, optional
        Seconds for one item. A process that takes longer is killed; a thread is left behind.
    progress : callable, optional
    said : str
        What is said to be going on, before the rate and the time that remains.

    Raises
    ------
    UsageError
        No process can be started, mostly since a script lacks ``if __name__ == "__main__":``.
    """
    places = enumerate(items)
    made: Generator[tuple[int, Value | Failure], None, None]
    if executor is not None:
        made = _on_executor(function, places, executor, limit)
    elif jobs == 0:
        made = ((place, _attempt(function, item)) for place, item in places)
    else:
        made = _on_processes(function, places, min(jobs, max(total, 1)), limit)
    begin = monotonic()
    with contextlib.closing(made):
        for done, outcome in enumerate(made, 1):
            if progress is not None and done < total:
                progress(done, total, f"{said}, {pace(done, total, monotonic() - begin)}")
            yield outcome


def pace(done: int, total: int, seconds: float) -> str:
    """How fast it goes and how long it takes: ``4.2 a second, 3 min left``."""
    rate = done / max(seconds, 1e-9)
    left = (total - done) / rate
    far = f"{left / 3600:.1f} h" if left > 7200 else f"{left / 60:.0f} min"
    return f"{rate:.3g} a second, {far if left > 120 else f'{left:.0f} s'} left"


def _attempt(function: Callable[[Item], Value], item: Item) -> Value | Failure:
    """What a function makes of an item; what it raises as a failure."""
    try:
        return function(item)
    except Exception as error:
        return _failure_of(error)


def _failure_of(error: BaseException) -> Failure:
    """What is said of an exception; Dask gives up an item that killed workers by one of its own."""
    if type(error).__name__ == "KilledWorker":
        return Failure("killed", "its worker was killed each time that it was begun")
    return Failure("error", " ".join(f"{type(error).__name__}: {error}".removesuffix(": ").split()))


def _timed_out(limit: float | None) -> Failure:
    return Failure("time", f"it did not end within the time limit of {limit:g} s")


class _Worker:
    """A process that was started afresh, not forked, and the pipe to it."""

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
            made = _attempt(function, pipe.recv())
            try:
                pipe.send(made)
            except (TypeError, ValueError, AttributeError) as error:  # it cannot be pickled
                pipe.send(_failure_of(error))


def _end_with_parent() -> None:
    """End this process when the one that started it is gone, whatever a job does meanwhile."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


def _without_interrupts() -> None:
    """Keep Ctrl-C, which a terminal sends to all, from this thread and what it starts."""
    if hasattr(signal, "pthread_sigmask"):  # not on Windows
        resource_tracker.ensure_running()  # which lets them through again as it starts
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


class _Processes:
    """Workers, one for each thread that has something to do; all of them end with the context."""

    def __init__(self, function: Callable[[Any], Any], limit: float | None) -> None:
        self._function, self._limit = function, limit
        self._workers: list[_Worker] = []
        self._idle: list[_Worker] = []
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
        """What the function makes of an item, or why it makes nothing of it."""
        how = ""
        for _ in range(_ATTEMPTS):
            worker = self._waiting()
            try:
                worker.pipe.send(item)
                if not worker.pipe.poll(self._limit):
                    self._leave(worker)
                    return _timed_out(self._limit)
                made = worker.pipe.recv()
            except (EOFError, OSError):
                how = worker.ended_by
                self._leave(worker)
                continue
            self._idle.append(worker)
            return made
        return Failure("killed", f"its worker was killed ({how}), {_ATTEMPTS} times")

    def _waiting(self) -> _Worker:
        """A worker that waits for a job."""
        while True:
            with self._starting:
                if self._is_over:
                    raise BrokenExecutor
                if self._idle:
                    return self._idle.pop()
                worker = _Worker(self._function)
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

    def _leave(self, worker: _Worker) -> None:
        worker.end()
        self._workers.remove(worker)


def _on_processes(
    function: Callable[[Any], Any],
    items: Iterable[tuple[int, Any]],
    jobs: int,
    limit: float | None,
) -> Generator[tuple[int, Any], None, None]:
    with (
        ThreadPoolExecutor(jobs, initializer=_without_interrupts) as threads,
        _Processes(function, limit) as processes,
    ):
        for place, _, future in _ended(
            lambda item: threads.submit(processes.make, item), iter(items)
        ):
            # What is no job's fault ends all: no process begins, or an item cannot be sent.
            yield place, future.result()


def _on_executor(
    function: Callable[[Any], Any],
    items: Iterator[tuple[int, Any]],
    executor: Executor,
    limit: float | None,
) -> Generator[tuple[int, Any], None, None]:
    left: dict[int, Any] = {}  # what a broken executor did not do
    work = partial(_within, function, limit)
    for place, item, future in _ended(lambda item: executor.submit(work, item), items):
        error = None if future.cancelled() else future.exception()
        if isinstance(error, BrokenExecutor):
            left[place] = item
        elif future.cancelled():
            yield place, Failure("error", "it was cancelled")
        else:
            yield place, future.result() if error is None else _failure_of(error)
    if left:
        rest = chain(sorted(left.items()), items)
        yield from _on_processes(function, rest, getattr(executor, "_max_workers", 1), limit)


def _ended(
    submit: Callable[[Any], Future[Any]], items: Iterator[tuple[int, Any]]
) -> Iterator[tuple[int, Any, Future[Any]]]:
    """Items with their futures, as these end; none is submitted once an executor is broken."""
    pending: dict[Future[Any], tuple[int, Any]] = {}
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    is_broken = False
    try:
        while True:
            while len(pending) < _MOST_AHEAD and not is_broken:
                if (entry := next(items, None)) is None:
                    break
                try:
                    future = submit(entry[1])
                except BrokenExecutor as error:
                    future = Future()
                    future.set_exception(error)
                    is_broken = True
                pending[future] = entry
                future.add_done_callback(done.put)
            if not pending:
                return
            future = done.get()
            is_broken |= not future.cancelled() and isinstance(future.exception(), BrokenExecutor)
            yield *pending.pop(future), future
    finally:
        for future in pending:
            future.cancel()


def _within(function: Callable[[Item], Value], limit: float | None, item: Item) -> Value | Failure:
    """What a function makes of an item, within a time limit in s; by whoever works."""
    if limit is None:
        return _attempt(function, item)
    made: list[Value | Failure] = []
    # A daemon: it cannot be stopped, and the process must be able to end without it.
    thread = threading.Thread(target=lambda: made.append(_attempt(function, item)), daemon=True)
    thread.start()
    thread.join(limit)
    return made[0] if made else _timed_out(limit)
