"""Limit of memory for reading a log: a small compressed file can unpack to any size.

What is read is counted before it is held, so that a log that does not fit is refused with a
sentence instead of ending the program, or slowing the whole machine down.
"""

import contextlib
import math
import os
from dataclasses import dataclass
from pathlib import Path

from .checks import is_real
from .errors import DataError, UsageError
from .settings import setting
from .wording import quoted

GIGABYTE = 1e9
#: What to do about a file that memory cannot hold, the beginning of a sentence.
SHORTER_FILES = "Split the log into shorter files, and identify them together as several records"
_SHARE = 0.5  # of the machine's memory, which reads no log alone
_UNKNOWN = 8 * GIGABYTE  # taken for a machine that does not tell
_LIMITS = (  # of a container
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)
_IDENTIFIED = 1200  # bytes for each sample of a record while it is identified
_TEXT_BYTE, _TEXT_LINE = 2, 200  # bytes held for each byte and each line of a text, beside itself


@dataclass(slots=True)
class Room:
    """The memory that reading one log may take.

    Attributes
    ----------
    source : str
        The log, for messages.
    limit : float
        Bytes.
    given : bool
        Whether the user set it.
    taken : float
        Bytes, as counted so far; what was let go again is not subtracted.
    """

    source: str
    limit: float
    given: bool = False
    taken: float = 0.0

    @property
    def left(self) -> float:
        """Bytes that may yet be taken."""
        return self.limit - self.taken

    def take(self, amount: float) -> None:
        """Count bytes that are about to be held.

        Raises
        ------
        DataError
            They are more than there is room for.
        """
        self.check(amount)
        self.taken += amount

    def check(self, amount: float) -> None:
        """Refuse bytes that there is no room for, without counting them.

        Raises
        ------
        DataError
            As `take` does.
        """
        if amount > self.left:
            raise self._too_much(f"reading {self.source}", SHORTER_FILES)

    def check_samples(self, count: int) -> None:
        """Refuse more samples than can be identified; reading alone takes far less of them.

        Raises
        ------
        DataError
            As `take` does, unless the user set the limit.
        """
        if not self.given and _IDENTIFIED * count > self.limit:
            raise self._too_much(f"identifying the {count} samples of {self.source}", _windows())

    def _too_much(self, what: str, less: str) -> DataError:
        whose = "the given limit" if self.given else "half of the machine's memory"
        return DataError(
            f"{what} would need more than {self.limit / GIGABYTE:.3g} GB of memory, {whose}. "
            f"{less}, or raise the limit (max_memory = BYTES in run.toml).",
            code="memory",
        )

    def take_text(self, content: bytes) -> None:
        """The same of a text in bytes that is about to be read as a table."""
        self.take(_TEXT_BYTE * len(content) + _TEXT_LINE * max(map(content.count, (b"\n", b"\r"))))


def room_for(source: str | Path, max_memory: float | None) -> Room:
    """The room for a log: what is given, in bytes, or half of the machine's memory.

    Raises
    ------
    UsageError
        It is no positive number.
    """
    if max_memory is None:
        return Room(str(source), _SHARE * machine_memory())
    if not (is_real(max_memory) and max_memory > 0):
        raise UsageError(
            f"max_memory is {quoted(max_memory)}. Give a positive number of bytes, such as 4e9.",
            code="memory",
        )
    return Room(str(source), float(max_memory), given=True)


def machine_memory() -> float:
    """Bytes of memory that this process can have: the machine's, or its container's."""
    found = [math.inf]
    with contextlib.suppress(AttributeError, ValueError, OSError):  # not every system tells
        found.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
    for file in _LIMITS:
        with contextlib.suppress(OSError, ValueError):  # "max" where there is no limit
            found.append(float(file.read_text(encoding="ascii")))
    least = min(found)
    return least if 0 < least < math.inf else _UNKNOWN


def _windows() -> str:
    """Return the advice about more samples than memory can hold, the beginning of a sentence."""
    return (
        "Take only windows of the log, which form one regression with one verdict "
        f"({setting('windows', ('FROM..TO',))})"
    )
