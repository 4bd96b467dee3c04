"""Jobs on an executor or on processes, with progress."""

from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Executor
from contextlib import closing
from time import monotonic

from axisid.support.progress import Progress

from .executors import on_executor
from .outcome import Item, Outcome, Value, attempt, outcome_of
from .processes import on_processes


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
