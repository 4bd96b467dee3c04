"""Jobs on any executor of `concurrent.futures` or on processes, with progress."""

import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import closing
from functools import partial
from itertools import chain
from queue import SimpleQueue
from time import monotonic
from typing import Any

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
from .processes import on_processes

#: Items that an executor is given ahead of those that are done.
MOST_AHEAD = 1000


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
    run = _Submitted(partial(within, function, limit=limit), iter(items), executor)
    try:
        yield from run.outcomes()
    finally:
        run.cancel()
    if run.left:
        rest = chain(sorted(run.left.items()), run.items)
        jobs = getattr(executor, "_max_workers", 1)
        yield from on_processes(function, rest, jobs=jobs, limit=limit)


class _Submitted:
    """What an executor was given, and what it was not."""

    def __init__(
        self,
        function: Callable[[Any], Any],
        items: Iterator[tuple[int, Any]],
        executor: Executor,
    ) -> None:
        self.items = items
        self.left: dict[int, Any] = {}  # what a broken executor did not do
        self._function, self._executor = function, executor
        self._pending: dict[Future[Any], tuple[int, Any]] = {}
        self._done: SimpleQueue[Future[Any]] = SimpleQueue()

    def outcomes(self) -> Iterator[Outcome[Any]]:
        """Outcomes as they come, until all is done or the executor is broken."""
        while True:
            while len(self._pending) < MOST_AHEAD and not self.left and self._submit():
                pass
            if not self._pending:
                return
            future = self._done.get()
            place, item = self._pending.pop(future)
            error = None if future.cancelled() else future.exception()
            if isinstance(error, BrokenExecutor):
                self.left[place] = item
            elif future.cancelled():
                yield Outcome(place=place, failure=Failure("error", "it was cancelled"))
            elif error is not None:
                yield Outcome(place=place, failure=_of_executor(error))
            else:
                yield outcome_of(place, future.result())

    def _submit(self) -> bool:
        """Submit the next item, if there is one and the executor takes it."""
        entry = next(self.items, None)
        if entry is None:
            return False
        try:
            future = self._executor.submit(self._function, entry[1])
        except BrokenExecutor:
            self.left[entry[0]] = entry[1]
            return False
        self._pending[future] = entry
        future.add_done_callback(self._done.put)
        return True

    def cancel(self) -> None:
        """Take back what has not begun."""
        for future in list(self._pending):
            future.cancel()


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
