"""Jobs on any executor of `concurrent.futures` or on processes, with progress."""

import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import closing
from functools import partial
from itertools import chain
from queue import SimpleQueue
from time import monotonic
from typing import Any, NoReturn

from axisid.support.progress import Progress

from .outcome import (
    Failure,
    Item,
    Outcome,
    Value,
    attempt,
    failure_of,
    outcome_of,
    timed_out,
)
from .processes import Processes, without_interrupts

#: Items that an executor is given ahead of those that are done.
MOST_AHEAD = 1000


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
    with (
        ThreadPoolExecutor(jobs, initializer=without_interrupts) as threads,
        Processes(function, limit) as processes,
    ):
        run = _Submitted(lambda item: threads.submit(processes.make, item), iter(items), _raised)
        yield from run.outcomes()


def on_executor(
    function: Callable[[Item], Value],
    items: Iterable[tuple[int, Item]],
    executor: Executor,
    *,
    limit: float | None = None,
) -> Generator[Outcome[Value], None, None]:
    """Outcomes of items, as they end.

    What an executor of processes did not do when one of them died goes on processes of our own, as
    many as it had, which tell the item that did it.

    Parameters
    ----------
    function, items
        As `on_processes` takes them.
    executor : Executor
        It is left as it is, and not shut down.
    limit : float, optional
        Seconds for one item. A thread that takes longer is left behind and may go on.
    """
    work = partial(within, function, limit=limit)
    run = _Submitted(lambda item: executor.submit(work, item), iter(items), _of_executor)
    yield from run.outcomes()
    if run.left:
        rest = chain(sorted(run.left.items()), run.items)
        jobs = getattr(executor, "_max_workers", 1)
        yield from on_processes(function, rest, jobs=jobs, limit=limit)


class _Submitted:
    """What an executor was given, and what it was not."""

    def __init__(
        self,
        submit: Callable[[Any], Future[Any]],
        items: Iterator[tuple[int, Any]],
        failure: Callable[[BaseException], Failure],
    ) -> None:
        self.items = items
        self._failure = failure
        self.left: dict[int, Any] = {}  # what a broken executor did not do
        self._submit = submit
        self._pending: dict[Future[Any], tuple[int, Any]] = {}
        self._done: SimpleQueue[Future[Any]] = SimpleQueue()

    def outcomes(self) -> Iterator[Outcome[Any]]:
        """Outcomes as they come, until all is done or the executor is broken."""
        try:
            while self._submit_ahead():
                future = self._done.get()
                place, item = self._pending.pop(future)
                error = None if future.cancelled() else future.exception()
                if isinstance(error, BrokenExecutor):
                    self.left[place] = item
                elif future.cancelled():
                    yield Outcome(place=place, failure=Failure("error", "it was cancelled"))
                elif error is not None:
                    yield Outcome(place=place, failure=self._failure(error))
                else:
                    yield outcome_of(place, future.result())
        finally:
            for future in self._pending:
                future.cancel()

    def _submit_ahead(self) -> bool:
        """Submit items as far as the executor takes them; whether any is under way."""
        while len(self._pending) < MOST_AHEAD and not self.left:
            if (entry := next(self.items, None)) is None:
                break
            try:
                future = self._submit(entry[1])
            except BrokenExecutor:
                self.left[entry[0]] = entry[1]
            else:
                self._pending[future] = entry
                future.add_done_callback(self._done.put)
        return bool(self._pending)


def _raised(error: BaseException) -> NoReturn:
    """What is no job's fault ends all of them: no process begins, or an item cannot be sent."""
    raise error


def _of_executor(error: BaseException) -> Failure:
    """Of an exception that is not the function's: Dask gives up an item that killed workers."""
    if type(error).__name__ == "KilledWorker":
        return Failure("killed", "its worker was killed each time that it was begun")
    return failure_of(error)


def within(
    function: Callable[[Item], Value], item: Item, *, limit: float | None
) -> Value | Failure:
    """What a function makes of an item, within a time limit in s; by whoever works."""
    if limit is None:
        return attempt(function, item)
    made: list[Value | Failure] = []
    # A daemon: it cannot be stopped, and the process must be able to end without it.
    thread = threading.Thread(target=lambda: made.append(attempt(function, item)), daemon=True)
    thread.start()
    thread.join(limit)
    return made[0] if made else timed_out(limit)


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
) -> Iterator[Outcome[Value]]:
    """Outcomes of items, as they end, each with the place of its item.

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
        Dask.
    limit : float, optional
        Seconds for one item.
    progress : callable, optional
    said : str
        What is said to be going on, before the rate and the time that remains.
    """
    places = enumerate(items)
    made: Generator[Outcome[Value], None, None]
    if executor is not None:
        made = on_executor(function, places, executor, limit=limit)
    elif jobs == 0:
        made = (outcome_of(place, attempt(function, item)) for place, item in places)
    else:
        made = on_processes(function, places, jobs=min(jobs, max(total, 1)), limit=limit)
    begin = monotonic()
    with closing(made):
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
