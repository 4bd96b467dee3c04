"""Jobs on processes of their own: a job that hangs or kills its process takes nothing with it.

A pool of the standard library is broken by one process that dies, with all that it was to do. Here
each process has one job at a time, so it is known which one that was.
"""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import monotonic
from typing import Any

from axisid.support.errors import UsageError

from .one_thread import started_with_one_thread, without_arithmetic_warnings
from .outcome import Failure, Item, Outcome, Value, attempt, failure_of, outcome_of, timed_out

#: What a worker says once it has the function.
READY = "ready"
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


def on_processes(
    function: Callable[[Item], Value],
    items: Iterable[tuple[int, Item]],
    *,
    jobs: int,
    limit: float | None = None,
) -> Generator[Outcome[Value], None, None]:
    """Outcomes of items, as they end.

    Parameters
    ----------
    function : callable
        Of a module, so that another process finds it.
    items : iterable of (place, item)
    jobs : int
        Processes at once.
    limit : float, optional
        Seconds for one item; a process that takes longer is killed.

    Raises
    ------
    UsageError
        No process can be started, mostly since a script lacks ``if __name__ == "__main__":``.
    """
    pool = _Processes(function, items, limit)
    try:
        for _ in range(jobs):
            pool.start()
        while pool.workers:
            yield from pool.step()
    except BaseException:  # an interrupt too, and the end of whoever takes the outcomes
        for worker in pool.workers:
            worker.kill()
        raise


class _Processes:
    """Workers, what they do, and what is to be done."""

    def __init__(
        self,
        function: Callable[[Any], Any],
        items: Iterable[tuple[int, Any]],
        limit: float | None,
    ) -> None:
        self.workers: list[Worker] = []
        self._function, self._limit = function, limit
        self._items = iter(items)
        self._again: deque[tuple[int, Any]] = deque()
        self._begun: dict[int, tuple[Any, int]] = {}  # item and attempts, by place
        self._stillborn = 0
        self._ahead: deque[tuple[int, Any]] = deque()

    def start(self) -> None:
        """Start a worker, if there is something for it to do."""
        if self._has_more():
            self.workers.append(Worker(self._function))

    def step(self) -> Iterator[Outcome[Any]]:
        """Wait until a worker says something, dies or is late; outcomes of what ended."""
        late = [w.left for w in self.workers if w.left is not None]
        spoke = {id(pipe) for pipe in wait([w.pipe for w in self.workers], min(late, default=None))}
        for worker in list(self.workers):
            if id(worker.pipe) in spoke:
                yield from self._heard(worker)
            elif worker.left is not None and worker.left <= 0:
                yield self._late(worker)

    def _has_more(self) -> bool:
        if not self._ahead and not self._again:
            self._ahead.extend(entry for entry in [next(self._items, None)] if entry is not None)
        return bool(self._ahead or self._again)

    def _heard(self, worker: Worker) -> Iterator[Outcome[Any]]:
        try:
            said = worker.take()
        except (EOFError, OSError):
            yield from self._died(worker)
            return
        if said == READY and not worker.is_ready:
            worker.is_ready, self._stillborn = True, 0
        elif worker.place is not None:
            self._begun.pop(worker.place)
            yield outcome_of(worker.place, said)
        self._next(worker)

    def _next(self, worker: Worker) -> None:
        """Give a worker its next job, or let it end."""
        if not self._has_more():
            worker.end()
            self.workers.remove(worker)
            return
        place, item = self._ahead.popleft() if self._ahead else self._again.popleft()
        _, before = self._begun.get(place, (item, 0))
        self._begun[place] = item, before + 1
        with contextlib.suppress(OSError):  # it is dead, which the pipe says next
            worker.give(place, (item,), self._limit)
        worker.place = place

    def _died(self, worker: Worker) -> Iterator[Outcome[Any]]:
        """Begin the job of a dead worker again, or tell what it does to workers."""
        how = worker.ended_by
        self._leave(worker)
        if worker.place is None:
            self._stillborn += 1
            if self._stillborn >= _MOST_STILLBORN:
                raise UsageError(
                    f"processes end before they begin to work ({how}); what they say on standard "
                    "error tells why. A script has to call it under if __name__ == "
                    '"__main__":, since each process reads the script again.',
                    code="no-workers",
                )
        else:
            item, attempts = self._begun.pop(worker.place)
            if attempts < ATTEMPTS:
                self._begun[worker.place] = item, attempts
                self._again.append((worker.place, item))
            else:
                said = f"its worker was killed ({how}), {attempts} times"
                yield Outcome(place=worker.place, failure=Failure("killed", said))
        self.start()

    def _late(self, worker: Worker) -> Outcome[Any]:
        place = worker.place
        assert place is not None  # noqa: S101 - only a job has a time limit
        self._begun.pop(place)
        self._leave(worker)
        self.start()
        return Outcome(place=place, failure=timed_out(self._limit))

    def _leave(self, worker: Worker) -> None:
        worker.kill()  # before it is removed: an interrupt between the two leaves none behind
        self.workers.remove(worker)
