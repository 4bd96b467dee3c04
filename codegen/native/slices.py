"""Long native calls: cut in parts or told to stop, so that Ctrl-C is answered at once."""

from _thread import allocate_lock, start_new_thread
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

_PART = 65_536  # samples, at which any function is evaluated within a tenth of a second
_WAIT = 0.05  # s
#: Steps of a loop that end as soon on any machine: no thread is worth while.
_FEW_STEPS = 50_000


def slices(samples: int) -> Iterator[slice]:
    """Cut samples into parts, between which the signals of the operating system are looked at."""
    for begin in range(0, samples, _PART):
        yield slice(begin, min(begin + _PART, samples))


def stoppable(runs: Sequence[Callable[[NDArray[np.int32]], int]], steps: int) -> list[int]:
    """Run loops side by side so that Ctrl-C ends them: in threads, or at once where they are short.

    Parameters
    ----------
    runs : sequence of callable
        Each takes a flag, (1,), and ends soon after that is not 0 any more.
    steps : int
        That all take together.

    Returns
    -------
    list of int
        What they return.
    """
    stop = np.zeros(1, dtype=np.int32)
    if len(runs) == 1 and steps <= _FEW_STEPS:
        return [runs[0](stop)]
    # Each loop in a thread of its own; this one waits where Ctrl-C reaches it. An interrupt may
    # come between any two steps of Python. Were a lock both threads take held then, as in a pool's
    # futures, the other would wait for it for ever: here only one ever takes it.
    results, errors = [0] * len(runs), list[BaseException]()
    ended = [allocate_lock() for _ in runs]

    def work(i: int) -> None:
        try:
            results[i] = runs[i](stop)
        except BaseException as error:  # it is raised below
            errors.append(error)
            stop[0] = 1
        finally:
            ended[i].release()

    try:
        for i, lock in enumerate(ended):
            lock.acquire()
            start_new_thread(work, (i,))
        for lock in ended:
            # Short waits: a signal that another thread gets does not wake this one.
            while not lock.acquire(timeout=_WAIT):
                pass
    except BaseException:
        stop[0] = 1  # what still runs holds all that it writes to, and ends soon
        raise
    if errors:
        raise errors[0]
    return results
