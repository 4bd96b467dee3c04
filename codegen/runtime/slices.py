"""Long native calls: cut in parts or told to stop, so that Ctrl-C is answered at once."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

import numpy as np
from numpy.typing import NDArray

_SECONDS = 0.1  # that a part may take
_FIRST = 32_768  # samples of the first part, whose time sets the others
_GROWTH = 8
_WAIT = 0.05  # s
#: Steps of a loop that end within `_SECONDS` on any machine; a thread costs nothing beside more.
_FEW_STEPS = 50_000


def slices(samples: int) -> Iterator[slice]:
    """Cut samples into parts, each so long that what is done with it takes a tenth of a second.

    The signals of the operating system are looked at between the parts.
    """
    begin, length = 0, _FIRST
    while begin < samples:
        end = min(begin + length, samples)
        before = time.perf_counter()
        yield slice(begin, end)
        taken = max(time.perf_counter() - before, 1e-9)
        wanted = (end - begin) * min(_SECONDS / taken, _GROWTH)
        begin, length = end, max(int(wanted), 1)


def run_stoppable(runs: Sequence[Callable[[NDArray[np.int32]], int]], steps: int) -> list[int]:
    """Run loops side by side, each in a thread; one of few steps here and now.

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
    # The main thread waits where Ctrl-C reaches it.
    with ThreadPoolExecutor(len(runs)) as pool:
        try:
            futures = [pool.submit(run, stop) for run in runs]
            # Short waits: a signal that another thread gets does not wake this one.
            pending = set(futures)
            while pending:
                done, pending = wait(pending, timeout=_WAIT, return_when=FIRST_COMPLETED)
                for future in done:
                    future.result()
            return [future.result() for future in futures]
        except BaseException:
            stop[0] = 1
            raise
