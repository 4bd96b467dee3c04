"""Independent jobs in parallel: a failed job does not affect others, and an interrupt ends all.

Jobs run on any executor of `concurrent.futures`, or by default on threads, each of which has one
worker process. A process pool of the standard library fails with all its remaining jobs when one
process dies. Here each process has one job at a time, so that the job that ended the process is
known, and only this job fails.
"""

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import islice
from multiprocessing import get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from queue import SimpleQueue
from time import monotonic
from typing import Any, Literal, TypeVar

from .errors import UsageError
from .one_thread import started_with_one_thread, without_arithmetic_warnings
from .progress import Progress

Item = TypeVar("Item")
Value = TypeVar("Value")

_PATIENCE = 1.0  # s until a worker whose pipe was closed is killed
_ATTEMPTS = 2  # of a job whose worker is killed, because another process may be the cause
_MOST_FAILED_STARTS = 3  # workers in a row that end before they are ready
_MOST_AHEAD = 1000  # items that are submitted to an executor before the first is done


@dataclass(frozen=True, slots=True)
class Failure:
    """Reason why a job has no value.

    Attributes
    ----------
    kind : {"error", "time", "killed"}
        The function raised an exception, the time limit ended it, or its worker was killed.
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
    """Yield (index, outcome) of each item as soon as its job ends.

    The outcome is the value of the function for the item, or a `Failure`.

    Parameters
    ----------
    function : callable
        Function of an item, defined in a module, so that other processes can import it.
    items : iterable
    total : int
        Number of items.
    jobs : int
        Number of processes; at most `total` are started. 0 for this process itself: the time limit
        does not apply then, and a job may end the program.
    executor : Executor, optional
        Any executor of `concurrent.futures`, used instead of processes, such as a
        `Client.get_executor()` of Dask. It is not shut down.
    limit : float, optional
        Seconds for one item; a process that takes longer is killed. Not applied by an executor.
    progress : callable, optional
        Called with the number of items done, the total, and a text.
    said : str
        Beginning of this text; rate and remaining time follow.

    Raises
    ------
    UsageError
        No process can be started, usually because a script has no ``if __name__ == "__main__":``;
        or the executor is broken, for instance a process pool of which one process died.
    """
    if executor is not None:
        made = _on_executor(partial(_attempt, function), items, executor)
    elif jobs == 0:
        made = ((index, _attempt(function, item)) for index, item in enumerate(items))
    else:
        made = _Processes(function, limit).outcomes(items, min(jobs, max(total, 1)))
    begin = monotonic()
    with contextlib.closing(made):
        for done, outcome in enumerate(made, 1):
            if progress is not None and done < total:
                progress(done, total, f"{said}, {pace(done, total, monotonic() - begin)}")
            yield outcome


def pace(done: int, total: int, seconds: float) -> str:
    """Return rate and remaining time as text: ``4.2 a second, 3 min left``.

    `done` of `total` items took `seconds`.
    """
    rate = done / max(seconds, 1e-9)
    left = (total - done) / rate
    if left > 7200:
        remaining = f"{left / 3600:.1f} h"
    elif left > 120:
        remaining = f"{left / 60:.0f} min"
    else:
        remaining = f"{left:.0f} s"
    return f"{rate:.3g} a second, {remaining} left"


def _attempt(function: Callable[[Item], Value], item: Item) -> Value | Failure:
    """Return the value of a function for an item; an exception becomes a failure."""
    try:
        return function(item)
    except Exception as error:
        return _failure_of(error)


def _failure_of(error: BaseException) -> Failure:
    """Return the failure for an exception of a job.

    ``KilledWorker`` is the exception of Dask for a worker that was killed.
    """
    if type(error).__name__ == "KilledWorker":
        return Failure("killed", "its process was killed at every attempt")
    return Failure("error", " ".join(f"{type(error).__name__}: {error}".removesuffix(": ").split()))


class _Worker:
    """A worker process, spawned and not forked, and the pipe to it.

    Parameters
    ----------
    function : callable
        Function that the worker calls for each item it receives.

    Attributes
    ----------
    pipe : Connection
    process : Process
    """

    def __init__(self, function: Callable[[Any], Any]) -> None:
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, function), daemon=True)
        with started_with_one_thread(), _without_interrupts():
            self.process.start()
        theirs.close()  # so that the pipe ends when the process does

    def end(self, patience: float) -> str:
        """End the worker; return the signal that ended it or its exit code, as text.

        A worker that does not end within `patience` seconds is killed; the text is then empty.
        """
        self.pipe.close()
        self.process.join(patience)
        code = self.process.exitcode
        self.process.kill()
        self.process.join()
        names = {-each: each.name for each in signal.Signals}
        return "" if code is None else names.get(code, f"exit code {code}")


def _serve(pipe: Connection, function: Callable[[Any], Any]) -> None:
    """Run jobs in a worker process until the parent process closes the pipe.

    The first message, None, reports that the worker is ready. Then each item that arrives is
    answered by the value of `function` or a failure.
    """
    threading.Thread(target=_end_with_parent, daemon=True).start()
    without_arithmetic_warnings()
    with contextlib.suppress(EOFError, OSError):
        pipe.send(None)
        while True:
            made = _attempt(function, pipe.recv())
            try:
                pipe.send(made)
            except (EOFError, OSError):
                raise
            except Exception as error:  # the value cannot be pickled
                pipe.send(_failure_of(error))


def _end_with_parent() -> None:
    """End this process when the process that started it has ended, even during a job."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Block Ctrl-C in processes that are started within the context.

    A terminal sends Ctrl-C to all processes; only the parent process handles it.
    """
    if not hasattr(signal, "pthread_sigmask"):  # on Windows
        yield
        return
    resource_tracker.ensure_running()  # before the block, which its start would undo
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Processes:
    """Threads with one worker process each, which end when the outcomes are no longer requested.

    Parameters
    ----------
    function : callable
        Function of an item.
    limit : float or None
        Seconds for one item; None for no limit.
    """

    def __init__(self, function: Callable[[Any], Any], limit: float | None) -> None:
        self._function, self._limit = function, limit
        self._workers: dict[int, _Worker] = {}  # by the identity of the thread
        self._starting = threading.Lock()  # a start changes environment and signals of the process
        self._has_ended = False

    def outcomes(self, items: Iterable[Any], jobs: int) -> Generator[tuple[int, Any], None, None]:
        """Yield (index, outcome) of each item as soon as its job ends, from `jobs` workers."""
        threads = ThreadPoolExecutor(jobs)
        try:
            yield from _on_executor(self._outcome, items, threads)
        except BaseException:
            with self._starting:
                self._has_ended = True
            for worker in [*self._workers.values()]:
                worker.process.kill()  # the pipe breaks, and the thread of the worker ends
            raise
        finally:
            threads.shutdown()
            for worker in self._workers.values():
                worker.end(_PATIENCE)

    def _outcome(self, item: Any) -> Any:
        """Return the value of an item from this thread's worker, or its failure.

        If the worker is killed, the item is tried once more with a new worker. A worker that
        exceeds the time limit is ended.
        """
        how = ""
        for _ in range(_ATTEMPTS):
            worker = self._workers.get(threading.get_ident()) or self._started()
            try:
                worker.pipe.send(item)
                if worker.pipe.poll(self._limit):
                    return worker.pipe.recv()
            except (EOFError, OSError):
                how = self._end_worker(_PATIENCE)
            else:
                self._end_worker(0.0)
                return Failure("time", f"it did not end within the time limit of {self._limit:g} s")
        return Failure("killed", f"its process was killed {_ATTEMPTS} times ({how})")

    def _started(self) -> _Worker:
        """Return a new worker of this thread that is ready to work.

        Raises
        ------
        UsageError
            Three workers in a row end before they are ready.
        """
        how = ""
        for _ in range(_MOST_FAILED_STARTS):
            with self._starting:
                if self._has_ended:
                    raise CancelledError
                worker = self._workers[threading.get_ident()] = _Worker(self._function)
            try:
                worker.pipe.recv()
            except (EOFError, OSError):
                how = self._end_worker(_PATIENCE)
            else:
                return worker
        raise UsageError(
            f"the worker processes end before they begin to work ({how}). Read the reason in their "
            "output on standard error. In a script, call this function under if __name__ == "
            '"__main__":, because each process imports the script again.',
            code="jobs",
        )

    def _end_worker(self, patience: float) -> str:
        """End this thread's worker; return the signal or exit code as `_Worker.end` does."""
        return self._workers.pop(threading.get_ident()).end(patience)


def _on_executor(
    work: Callable[[Any], Any], items: Iterable[Any], executor: Executor
) -> Generator[tuple[int, Any], None, None]:
    """Yield (index, outcome) of each item as soon as its job ends, from an executor.

    At most 1000 jobs are pending at a time, so that `items` may be long.
    """
    numbered = enumerate(items)
    pending: dict[Future[Any], int] = {}
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    try:
        while True:
            for index, item in islice(numbered, _MOST_AHEAD - len(pending)):
                future = executor.submit(work, item)
                pending[future] = index
                future.add_done_callback(done.put)
            if not pending:
                break
            future = done.get()
            index = pending.pop(future)
            try:
                made = future.result()
            except (BrokenExecutor, UsageError):
                raise
            except Exception as error:
                made = _failure_of(error)
            yield index, made
    except BrokenExecutor as error:
        raise UsageError(
            f"the executor is broken: {error}. Give another executor, or omit it to use axisid's "
            "own processes, which fail independently of each other.",
            code="jobs",
        ) from error
    finally:
        for future in pending:
            future.cancel()
