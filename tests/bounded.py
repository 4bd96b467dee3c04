"""Bounds on work, in seconds of an idle machine: what takes longer there would hang for a user.

On a shared machine even CPU seconds stretch, by ten and more, where it computes or where it takes
new memory; fixed work of both kinds tells by how much.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_STEPS, _STEPPED = 400_000, 0.025  # and the seconds that they take on an idle machine
_BYTES, _TAKEN = 2**25, 0.015
_SPREAD = 2.0  # how much slower work may be than what is tried beside it
_LEAST, _MOST = 6.0, 20.0  # what is tried may run in a short time for which the machine is idle


def slowness() -> float:
    """By how much the machine may be slower than an idle one just now."""
    slower = max(_seconds(_steps) / _STEPPED, _seconds(_memory) / _TAKEN)
    return min(max(_SPREAD * slower, _LEAST), _MOST)


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Fail if the work takes longer than so many seconds of an idle machine."""
    slower = slowness()
    begin = time.process_time()
    yield
    spent = time.process_time() - begin
    assert spent < seconds * max(slower, slowness())


def _steps() -> int:
    total = 0
    for step in range(_STEPS):
        total += step
    return total


def _memory() -> bytearray:
    return bytearray(_BYTES)


def _seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin
