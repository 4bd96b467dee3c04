"""What every fuzz is made of: seeded cases, a time limit, and the smallest input that fails.

A case is drawn from the seed, the kind of the fuzz and its number, so that it comes again alone:

    make fuzz SEED=7 TIMES=100
"""

import os
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from time_limit import Hung, in_time

from axisid import AxisidError, DataError
from axisid.estimation.logs import read_table
from tests.command_line import Run

SEED = int(os.environ.get("AXISID_FUZZ_SEED", "1"))
TIMES = float(os.environ.get("AXISID_FUZZ_TIMES", "1"))

_SECONDS = 60.0  # the most that any input may take, on a machine that is busy with other things
_SHRINKING = 20.0  # seconds for making a failing input smaller
_SHOWN = 6  # classes of failures

Case = TypeVar("Case")


class WrongError(AssertionError):
    """A result that is not right, by its class."""


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
    shown : callable
        A case as what reproduces it.
    """

    name: str
    count: int
    draw: Callable[[np.random.Generator], Case]
    check: Callable[[Case], None]
    shown: Callable[[Case], str] = repr

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
            with in_time(_SECONDS):
                self.check(case)
        except AxisidError as error:
            return None if _is_sentence(str(error)) else ("no sentence", str(error))
        except WrongError as error:
            kind, _, said = str(error).partition(": ")
            return kind, said
        except Hung as hung:
            return "hung", str(hung)
        except Exception as error:
            return f"{type(error).__name__} in {_place(error)}", str(error)
        return None

    def _told(self, number: int, case: Case, kind: str) -> str:
        smallest = self._shrunk(case, kind)
        failure = self._failure(smallest)
        said = failure[1] if failure is not None else "only at times"
        return f"{self.name}, case {number}: {kind}: {said[:600]}\n{self.shown(smallest)}"

    def _shrunk(self, case: Case, kind: str) -> Case:
        """A text that fails alike and of which no piece can be left out, if time allows."""
        until, smaller = time.monotonic() + _SHRINKING, _pieces_left_out(case)
        while time.monotonic() < until and (fewer := next(smaller, None)) is not None:
            failure = self._failure(fewer)
            if failure is not None and failure[0] == kind:
                case, smaller = fewer, _pieces_left_out(fewer)
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


def _pieces_left_out(case: Any) -> Iterator[Any]:
    """A text without some of its lines, then without some of its letters; large pieces first."""
    letters = list(case) if isinstance(case, str) and len(case) <= 3000 else []
    for items in (case.splitlines(keepends=True) if isinstance(case, str) else [], letters):
        size = len(items) // 2
        while size:
            for start in range(0, len(items), size):
                yield "".join(items[:start] + items[start + size :])
            size //= 2


def places(value: Any, level: int = 1) -> Iterator[tuple[int, Any, Any]]:
    """Every place of a tree that holds something: how deep, in what, and under which key."""
    for key in list(value) if isinstance(value, dict) else range(len(value)):
        yield level, value, key
        if isinstance(value[key], (dict, list)):
            yield from places(value[key], level + 1)


def spoilt(text: str, rng: np.random.Generator, junk: "Sequence[str]", most: int = 4) -> str:
    """A text with letters lost, doubled or put in, in so many places at most."""
    for _ in range(int(rng.integers(1, most))):
        at, kind, length = int(rng.integers(len(text) + 1)), rng.integers(3), rng.integers(1, 40)
        if kind == 0:
            text = text[:at] + text[at + int(length) :]
        elif kind == 1:
            text = text[:at] + one_of(rng, junk) + text[at:]
        else:
            text = text[:at] + text[at : at + int(length)] + text[at:]
    return text


def one_of(rng: np.random.Generator, items: "Sequence[Case]") -> Case:
    """One of some things, which need not be numbers."""
    return items[int(rng.integers(len(items)))]


def kept_to(run: Run, *arguments: object, output: Path) -> tuple[int, str]:
    """Run a command that writes a file; exit code and what it wrote.

    It ends with a documented exit code and one sentence, and writes the file whole or not at all.

    Raises
    ------
    WrongError
        It does not.
    """
    output.unlink(missing_ok=True)
    before = set(output.parent.iterdir())
    code, _, err = run(*arguments)
    if code not in (0, 2, 3, 4, 6) or "internal fault" in err or "Traceback" in err:
        raise WrongError(f"exit code {code}: {err}")
    if code and not err.startswith("axisid: "):
        raise WrongError(f"no sentence: {err}")
    if left := set(output.parent.iterdir()) - before - ({output} if code == 0 else set()):
        raise WrongError(f"left behind: {sorted(map(str, left))}")
    return code, output.read_text(encoding="utf-8") if code == 0 else ""


def readable_columns(file: Path) -> dict[str, np.ndarray]:
    """Columns of a log that can be read, of those that have a name of their own."""
    found = {}
    for name, column in read_table(file).columns.items():
        with suppress(DataError):
            found[name] = column.read().values
    return found
