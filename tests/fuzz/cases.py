"""What every fuzz is made of: seeded cases, a time limit, and the smallest input that fails.

A case is drawn from the seed, the kind of the fuzz and its number, so that it comes again alone:

    make fuzz SEED=7 TIMES=100
"""

import os
import signal
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Generic, TypeVar

import numpy as np

from axisid import AxisidError

SEED = int(os.environ.get("AXISID_FUZZ_SEED", "1"))
TIMES = float(os.environ.get("AXISID_FUZZ_TIMES", "1"))
SECONDS = 10  # of work, the most that any input may take

_WAITING = 60.0  # seconds, on a machine that is busy with other things
_SHRINKING = 20.0  # seconds for making a failing input smaller
_SHOWN = 6  # classes of failures

Case = TypeVar("Case")


class Hung(BaseException):
    """An input takes too long; no `except Exception` may catch it."""


class WrongError(AssertionError):
    """A result that is not right, by its class."""


@contextmanager
def in_time() -> Iterator[None]:
    """Raise `Hung` after some seconds of work, or many of waiting."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise Hung

    timers = ((signal.ITIMER_PROF, signal.SIGPROF), (signal.ITIMER_REAL, signal.SIGALRM))
    before = [signal.signal(ended, stop) for _, ended in timers]
    for (timer, _), seconds in zip(timers, (SECONDS, _WAITING), strict=True):
        signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        for (timer, ended), handler in zip(timers, before, strict=True):
            signal.setitimer(timer, 0)
            signal.signal(ended, handler)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fuzz(Generic[Case]):
    """A kind of input and what must come of it.

    Attributes
    ----------
    name : str
    count : int
        Cases in the usual run.
    draw : callable
        A case from a generator of random numbers.
    check : callable
        Raises `WrongError` where the result is wrong. An `AxisidError` is right if it says why.
    smaller : callable
        Cases that are a little smaller, the smallest first.
    shown : callable
        A case as what reproduces it.
    """

    name: str
    count: int
    draw: Callable[[np.random.Generator], Case]
    check: Callable[[Case], None]
    smaller: Callable[[Case], Iterable[Case]]
    shown: Callable[[Case], str]

    def run(self) -> None:
        """Try all cases; fail with the smallest input of each class of failures."""
        found: dict[str, str] = {}
        for number in range(max(round(self.count * TIMES), 1)):
            case = self.draw(self._generator(number))
            failure = self._failure(case)
            if failure is not None and failure[0] not in found:
                found[failure[0]] = self._told(number, case, failure[0])
            if len(found) == _SHOWN:
                break
        assert not found, "\n\n".join([f"seed {SEED}", *found.values()])

    def _generator(self, number: int) -> np.random.Generator:
        return np.random.default_rng([SEED, *self.name.encode(), number])

    def _failure(self, case: Case) -> tuple[str, str] | None:
        """The class of a failure and what is said of it; None where all is as it should be."""
        try:
            with in_time():
                self.check(case)
        except AxisidError as error:
            return None if _is_sentence(str(error)) else ("no sentence", str(error))
        except WrongError as error:
            kind, _, said = str(error).partition(": ")
            return kind, said
        except Hung:
            return "hung", f"more than {SECONDS} s"
        except Exception as error:
            return f"{type(error).__name__} in {_place(error)}", str(error)
        return None

    def _told(self, number: int, case: Case, kind: str) -> str:
        smallest = self._shrunk(case, kind)
        failure = self._failure(smallest)
        said = failure[1] if failure is not None else "only at times"
        return f"{self.name}, case {number}: {kind}: {said[:600]}\n{self.shown(smallest)}"

    def _shrunk(self, case: Case, kind: str) -> Case:
        """A case that fails alike and that no smaller one of its kind does, if time allows."""
        until = time.monotonic() + _SHRINKING
        going = True
        while going:
            going = False
            for smaller in self.smaller(case):
                if time.monotonic() > until:
                    return case
                failure = self._failure(smaller)
                if failure is not None and failure[0] == kind:
                    case, going = smaller, True
                    break
        return case


def _is_sentence(said: str) -> bool:
    """Whether an error says something to its user: words, no traceback, no bare repr."""
    return len(said.split()) > 3 and "Traceback" not in said


def _place(error: Exception) -> str:
    """The last line of the program that an error came through."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if "axisid" in f.filename or "/tests/" not in f.filename]
    last = own[-1] if own else frames[-1]
    return f"{Path(last.filename).name}:{last.name}"


def pieces_left_out(text: str) -> Iterator[str]:
    """A text without some of its lines, then without some of its letters; large pieces first."""
    lines = text.splitlines(keepends=True)
    yield from ("".join(kept) for kept in _without(lines))
    if len(text) <= 3000:
        yield from ("".join(kept) for kept in _without(list(text)))


def _without(items: list[str]) -> Iterator[list[str]]:
    size = len(items) // 2
    while size:
        for start in range(0, len(items), size):
            yield items[:start] + items[start + size :]
        size //= 2


def one_of(rng: np.random.Generator, items: "list[Case] | tuple[Case, ...]") -> Case:
    """One of some things, which need not be numbers."""
    return items[int(rng.integers(len(items)))]
