"""Many jobs on many workers: none of them harms another, and an interrupt ends them all.

They run on processes of their own or on any executor of `concurrent.futures`. A pool of the
standard library is broken by one process that dies, with all that it was to do. Here each process
has one job at a time, so it is known which one that was.
"""

import contextlib
import math
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from queue import SimpleQueue
from time import monotonic
from typing import Any, Literal, TypeAlias, TypeVar

from .errors import UsageError
from .one_thread import started_with_one_thread, without_arithmetic_warnings
from .progress import Progress

Item = TypeVar("Item")
Value = TypeVar("Value")
#: The place of an item, the item, and which attempt this is.
_Job: TypeAlias = tuple[int, Any, int]

_START: _Job = (-1, None, 1)  # the first job of a worker: to be ready
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
) -> Generator[tuple[int, Value | Failure], None, None]:
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
        made = _Processes(function, places, min(jobs, max(total, 1)), limit).outcomes()
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
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, function), daemon=True)
        with started_with_one_thread(), _without_interrupts():
            self.process.start()
        theirs.close()  # so that the pipe ends when the process does
        self.job: _Job | None = _START
        self.until = math.inf  # when its job is given up

    def begin(self, job: _Job, limit: float | None) -> None:
        """Give it a job; that it is dead, if it is, is heard when it should answer."""
        self.job, self.until = job, monotonic() + (limit or math.inf)
        with contextlib.suppress(BrokenPipeError):
            self.pipe.send(job[1])

    def end(self, patience: float = 0.0) -> str:
        """Let it end by itself, or kill it after so many seconds; how it came to its end."""
        self.pipe.close()
        self.process.join(patience)
        code = self.process.exitcode
        self.process.kill()
        self.process.join()
        names = {-each: each.name for each in signal.Signals}
        return "" if code is None else names.get(code, f"exit code {code}")


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
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Keep Ctrl-C, which a terminal sends to all, from the processes that are started now."""
    if not hasattr(signal, "pthread_sigmask"):  # on Windows
        yield
        return
    resource_tracker.ensure_running()  # which lets them through again as it starts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Processes:
    """Workers, each with one job at a time; all of them end when nobody asks for outcomes."""

    def __init__(
        self,
        function: Callable[[Any], Any],
        items: Iterable[tuple[int, Any]],
        jobs: int,
        limit: float | None,
    ) -> None:
        self._function, self._jobs, self._limit = function, jobs, limit
        self._queue: Iterator[_Job] = ((place, item, 1) for place, item in items)
        self._workers: list[_Worker] = []
        self._stillborn = 0

    def outcomes(self) -> Generator[tuple[int, Any], None, None]:
        """What becomes of the items, as they end."""
        try:
            while busy := self._busy():
                first = min(worker.until for worker in busy) - monotonic()
                told = wait([w.pipe for w in busy], None if first == math.inf else max(first, 0.0))
                for worker in busy:
                    if worker.pipe in told:
                        yield from self._heard(worker)
                    elif worker.job is not None and worker.until < monotonic():
                        self._leave(worker)
                        yield worker.job[0], _timed_out(self._limit)
        finally:
            for worker in self._workers:
                worker.end(_PATIENCE if worker.job is None else 0.0)

    def _busy(self) -> list[_Worker]:
        """Workers that are to say something, after those that wait were given jobs."""
        idle = [worker for worker in self._workers if worker.job is None]
        while (idle or len(self._workers) < self._jobs) and (job := next(self._queue, None)):
            if idle:
                idle.pop().begin(job, self._limit)
            else:
                self._workers.append(_Worker(self._function))
                self._queue = chain([job], self._queue)
        return [worker for worker in self._workers if worker.job is not None]

    def _heard(self, worker: _Worker) -> Iterator[tuple[int, Any]]:
        """What a worker says: that it is ready, what it made of its job, or that it is dead."""
        place, item, attempts = job = worker.job or _START
        try:
            made = worker.pipe.recv()
        except (EOFError, OSError):
            how = self._leave(worker, _PATIENCE)
            if job is _START:
                self._stillborn += 1
            elif attempts < _ATTEMPTS:
                self._queue = chain([(place, item, attempts + 1)], self._queue)
            else:
                yield place, Failure("killed", f"its worker was killed ({how}), {attempts} times")
            if self._stillborn == _MOST_STILLBORN:
                raise UsageError(
                    f"processes end before they begin to work ({how}); what they say on standard "
                    "error tells why. A script has to call it under if __name__ == "
                    '"__main__":, since each process reads the script again.',
                    code="jobs",
                ) from None
            return
        worker.job, worker.until, self._stillborn = None, math.inf, 0
        if job is not _START:
            yield place, made

    def _leave(self, worker: _Worker, patience: float = 0.0) -> str:
        self._workers.remove(worker)
        return worker.end(patience)


def _on_executor(
    function: Callable[[Any], Any],
    items: Iterator[tuple[int, Any]],
    executor: Executor,
    limit: float | None,
) -> Generator[tuple[int, Any], None, None]:
    work = partial(_within, function, limit)
    left: dict[int, Any] = {}  # what a broken executor did not do
    pending: dict[Future[Any], tuple[int, Any]] = {}
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    try:
        while True:
            with contextlib.suppress(BrokenExecutor):  # who is pending tells it
                for place, item in islice(items, 0 if left else _MOST_AHEAD - len(pending)):
                    left[place] = item  # unless it is submitted
                    future = executor.submit(work, item)
                    pending[future] = (place, left.pop(place))
                    future.add_done_callback(done.put)
            if not pending:
                break
            future = done.get()
            place, item = pending.pop(future)
            error = None if future.cancelled() else future.exception()
            if isinstance(error, BrokenExecutor):
                left[place] = item
            elif future.cancelled():
                yield place, Failure("error", "it was cancelled")
            else:
                yield place, future.result() if error is None else _failure_of(error)
    finally:
        for future in pending:
            future.cancel()
    if left:
        rest = chain(sorted(left.items()), items)
        jobs = getattr(executor, "_max_workers", 1)
        yield from _Processes(function, rest, jobs, limit).outcomes()


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
