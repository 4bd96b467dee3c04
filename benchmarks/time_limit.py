"""A limit on the time that a piece of work takes."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

#: The clocks that there are, and what each of them signals.
WALL = (signal.ITIMER_REAL, signal.SIGALRM)
WORK = (signal.ITIMER_PROF, signal.SIGPROF)


class Hung(BaseException):
    """Something takes too long; no `except Exception` may catch it."""


@contextmanager
def in_time(seconds: float, clock: tuple[int, int] = WALL) -> Iterator[None]:
    """Raise `Hung` after so many seconds of a clock."""
    timer, number = clock

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise Hung(f"more than {seconds:.3g} s")

    before = signal.signal(number, stop)
    signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        signal.setitimer(timer, 0)
        signal.signal(number, before)
