"""Long native calls: cut in parts or told to stop, so that Ctrl-C is answered at once."""

import math
import time
from _thread import allocate_lock, start_new_thread
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

_SECONDS = 0.1  # that a part may take
_FIRST = 32_768  # samples of the first part, whose time sets the others
_GROWTH = 8
_WAIT = 0.05  # s
#: Steps of a loop that end within `_SECONDS` on any machine.
_FEW_STEPS = 50_000
_SHORT = 0.05  # s that a loop may be expected to take where it is run at once


def slices(samples: int) -> Iterator[slice]:
    """Cut samples into parts, each so long that what is done with it takes a tenth of a second.

    The signals of the operating system are looked at between the parts.
    """
    if 0 < samples <= _FIRST:
        yield slice(0, samples)
        return
    begin, length = 0, _FIRST
    while begin < samples:
        end = min(begin + length, samples)
        before = time.perf_counter()
        yield slice(begin, end)
        taken = max(time.perf_counter() - before, 1e-9)
        wanted = (end - begin) * min(_SECONDS / taken, _GROWTH)
        begin, length = end, max(int(wanted), 1)


class StoppableRuns:
    """Runs loops so that Ctrl-C ends them: in threads, or here and now where they are short.

    How long they take is judged by the pace of those before: where another core has to be woken
    first, a thread may cost as much as what it does.
    """

    def __init__(self) -> None:
        self._pace = math.inf  # s a step, of the last that were not few

    def run(self, runs: Sequence[Callable[[NDArray[np.int32]], int]], steps: int) -> list[int]:
        """Run loops side by side.

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
        begin = time.perf_counter()
        if len(runs) == 1 and (steps <= _FEW_STEPS or steps * self._pace < _SHORT):
            results = [runs[0](stop)]
        else:
            results = _in_threads(runs, stop)
        if steps > _FEW_STEPS:
            self._pace = (time.perf_counter() - begin) * len(runs) / steps
        return results


def _in_threads(
    runs: Sequence[Callable[[NDArray[np.int32]], int]], stop: NDArray[np.int32]
) -> list[int]:
    """Each loop in a thread of its own; this one waits where Ctrl-C reaches it.

    An interrupt may come between any two steps of Python. Were a lock both threads take held then,
    as in a pool's futures, the other would wait for it for ever: here only one ever takes it.
    """
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
