"""Many jobs on many workers: none of them harms another, and an interrupt ends them all.

They run on any executor of `concurrent.futures`; on threads, each of which has a process of its
own, where there is none. A pool of processes of the standard library is broken by one that dies,
with all that it was to do. Here each process has one job at a time, so it is known which one that
was.
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

_PATIENCE = 1.0  # s until a worker that was told to end is killed
_ATTEMPTS = 2  # how often a job is begun whose worker is killed: it may be innocent once
_MOST_STILLBORN = 3  # workers in a row that end before they are ready
_MOST_AHEAD = 1000  # items that an executor is given ahead of those that are done


@dataclass(frozen=True, slots=True)
class Failure:
    """Reason why a job has no value.

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
    """Yield the value or failure of a function for each item, as they end, with the item's index.

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
        Dask. It is not shut down.
    limit : float, optional
        Seconds for one item; a process that takes longer is killed. An executor has none.
    progress : callable, optional
    said : str
        What is said to be going on, before the rate and the time that remains.

    Raises
    ------
    UsageError
        No process can be started, mostly since a script lacks ``if __name__ == "__main__":``; or
        the executor is broken, as one of processes is when one of them dies.
    """
    if executor is not None:
        made = _on_executor(partial(_attempt, function), items, executor)
    elif jobs == 0:
        made = ((place, _attempt(function, item)) for place, item in enumerate(items))
    else:
        made = _Processes(function, limit).outcomes(items, min(jobs, max(total, 1)))
    begin = monotonic()
    with contextlib.closing(made):
        for done, outcome in enumerate(made, 1):
            if progress is not None and done < total:
                progress(done, total, f"{said}, {pace(done, total, monotonic() - begin)}")
            yield outcome


def pace(done: int, total: int, seconds: float) -> str:
    """Return speed and remaining time: ``4.2 a second, 3 min left``."""
    rate = done / max(seconds, 1e-9)
    left = (total - done) / rate
    far = f"{left / 3600:.1f} h" if left > 7200 else f"{left / 60:.0f} min"
    return f"{rate:.3g} a second, {far if left > 120 else f'{left:.0f} s'} left"


def _attempt(function: Callable[[Item], Value], item: Item) -> Value | Failure:
    """Return the value of a function for an item; an exception becomes a failure."""
    try:
        return function(item)
    except Exception as error:
        return _failure_of(error)


def _failure_of(error: BaseException) -> Failure:
    """Return the failure of an exception; Dask has its own one for an item that killed workers."""
    if type(error).__name__ == "KilledWorker":
        return Failure("killed", "its process was killed at every attempt")
    return Failure("error", " ".join(f"{type(error).__name__}: {error}".removesuffix(": ").split()))


class _Worker:
    """A process that was started afresh, not forked, and the pipe to it."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, function), daemon=True)
        with started_with_one_thread(), _without_interrupts():
            self.process.start()
        theirs.close()  # so that the pipe ends when the process does

    def end(self, patience: float) -> str:
        """Let it end by itself, or kill it after so many seconds; how it came to its end."""
        self.pipe.close()
        self.process.join(patience)
        code = self.process.exitcode
        self.process.kill()
        self.process.join()
        names = {-each: each.name for each in signal.Signals}
        return "" if code is None else names.get(code, f"exit code {code}")


def _serve(pipe: Connection, function: Callable[[Any], Any]) -> None:
    """Run jobs in a worker until the other end closes the pipe."""
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
            except Exception as error:  # it cannot be pickled
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
    """A worker for each of several threads; all of them end when nobody asks for outcomes."""

    def __init__(self, function: Callable[[Any], Any], limit: float | None) -> None:
        self._function, self._limit = function, limit
        self._workers: dict[int, _Worker] = {}  # by thread
        self._starting = threading.Lock()  # while the environment and signals are others
        self._has_ended = False

    def outcomes(self, items: Iterable[Any], jobs: int) -> Generator[tuple[int, Any], None, None]:
        """Yield the outcomes of the items, as they end."""
        threads = ThreadPoolExecutor(jobs)
        try:
            yield from _on_executor(self._outcome, items, threads)
        except BaseException:
            with self._starting:
                self._has_ended = True
            for worker in [*self._workers.values()]:
                worker.process.kill()  # its thread hears of it
            raise
        finally:
            threads.shutdown()
            for worker in self._workers.values():
                worker.end(_PATIENCE)

    def _outcome(self, item: Any) -> Any:
        """Return the value of an item from this thread's worker, or its failure."""
        how = ""
        for _ in range(_ATTEMPTS):
            worker = self._workers.get(threading.get_ident()) or self._started()
            try:
                worker.pipe.send(item)
                if worker.pipe.poll(self._limit):
                    return worker.pipe.recv()
            except (EOFError, OSError):
                how = self._leave(_PATIENCE)
            else:
                self._leave(0.0)
                return Failure("time", f"it did not end within the time limit of {self._limit:g} s")
        return Failure("killed", f"its process was killed {_ATTEMPTS} times ({how})")

    def _started(self) -> _Worker:
        """A new worker of this thread, which is ready."""
        how = ""
        for _ in range(_MOST_STILLBORN):
            with self._starting:
                if self._has_ended:
                    raise CancelledError
                worker = self._workers[threading.get_ident()] = _Worker(self._function)
            try:
                worker.pipe.recv()
            except (EOFError, OSError):
                how = self._leave(_PATIENCE)
            else:
                return worker
        raise UsageError(
            f"the processes end before they begin to work ({how}). Their output on standard error "
            'shows the reason. In a script, call this function under if __name__ == "__main__":, '
            "because each process imports the script again.",
            code="jobs",
        )

    def _leave(self, patience: float) -> str:
        """End this thread's worker; how it came to its end."""
        return self._workers.pop(threading.get_ident()).end(patience)


def _on_executor(
    work: Callable[[Any], Any], items: Iterable[Any], executor: Executor
) -> Generator[tuple[int, Any], None, None]:
    places = enumerate(items)
    pending: dict[Future[Any], int] = {}
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    try:
        while True:
            for place, item in islice(places, _MOST_AHEAD - len(pending)):
                future = executor.submit(work, item)
                pending[future] = place
                future.add_done_callback(done.put)
            if not pending:
                break
            future = done.get()
            place = pending.pop(future)
            try:
                made = future.result()
            except (BrokenExecutor, UsageError):
                raise
            except Exception as error:
                made = _failure_of(error)
            yield place, made
    except BrokenExecutor as error:
        raise UsageError(
            f"the executor is broken: {error}. Give another executor, or none: axisid's own "
            "processes fail independently of each other.",
            code="jobs",
        ) from error
    finally:
        for future in pending:
            future.cancel()
