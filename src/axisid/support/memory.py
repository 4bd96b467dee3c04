"""Memory limit for reading a log, because a small compressed file can unpack to any size.

Memory is counted before it is used, so that a log that does not fit is refused with a message.
Otherwise it would end the program or slow down the whole machine.
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
#: Instruction for a log that does not fit into memory, as the beginning of a sentence.
SHORTER_FILES = "Split the log into shorter files, and identify them together as several records"
_SHARE = 0.5  # of the machine's memory, which other programs use too
_UNKNOWN = 8 * GIGABYTE  # assumed for a machine whose memory is not known
_LIMITS = (  # files with the memory limit of a container
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)
_IDENTIFIED = 1200  # bytes for each sample of a record during the identification
_TEXT_BYTE, _TEXT_LINE = 2, 200  # bytes for each byte and each line of a text, in addition to it


@dataclass(slots=True)
class Room:
    """The memory that reading one log may use.

    Attributes
    ----------
    source : str
        The log, for messages.
    limit : float
        Largest number of bytes that may be used.
    given : bool
        True if the user set the limit.
    taken : float
        Bytes counted so far; memory that was released is not subtracted.
    """

    source: str
    limit: float
    given: bool = False
    taken: float = 0.0

    @property
    def left(self) -> float:
        """Number of bytes that may still be used."""
        return self.limit - self.taken

    def take(self, amount: float) -> None:
        """Count bytes that are about to be used.

        Raises
        ------
        DataError
            The bytes exceed the limit.
        """
        self.check(amount)
        self.taken += amount

    def check(self, amount: float) -> None:
        """Refuse a number of bytes that exceeds the limit, without counting them.

        Raises
        ------
        DataError
            The bytes exceed the limit.
        """
        if amount > self.left:
            raise self._too_much(f"reading {self.source}", SHORTER_FILES)

    def check_samples(self, count: int) -> None:
        """Refuse a number of samples that is too large to be identified.

        An identification needs far more memory than reading. If the user set the limit, nothing is
        refused here.

        Raises
        ------
        DataError
            The identification would need more memory than the limit.
        """
        if not self.given and _IDENTIFIED * count > self.limit:
            raise self._too_much(f"identifying the {count} samples of {self.source}", _windows())

    def _too_much(self, what: str, less: str) -> DataError:
        """Return the error that `what` needs too much memory; `less` is the instruction."""
        limit = "the given limit" if self.given else "half of the machine's memory"
        return DataError(
            f"{what} would need more than {self.limit / GIGABYTE:.3g} GB of memory, {limit}. "
            f"{less}, or raise the limit (max_memory = BYTES in run.toml).",
            code="memory",
        )

    def take_text(self, content: bytes) -> None:
        """Count the memory for reading a text as a table.

        Raises
        ------
        DataError
            The memory exceeds the limit.
        """
        self.take(_TEXT_BYTE * len(content) + _TEXT_LINE * max(map(content.count, (b"\n", b"\r"))))


def room_for(source: str | Path, max_memory: float | None) -> Room:
    """Return the memory for reading a log: `max_memory` in bytes, or half of the machine's.

    Raises
    ------
    UsageError
        `max_memory` is not a positive number.
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
    """Return the bytes of memory of the machine, or of its container if these are fewer."""
    found = [math.inf]
    with contextlib.suppress(AttributeError, ValueError, OSError):  # not known on every system
        found.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
    for file in _LIMITS:
        with contextlib.suppress(OSError, ValueError):  # the file has "max" if there is no limit
            found.append(float(file.read_text(encoding="ascii")))
    least = min(found)
    return least if 0 < least < math.inf else _UNKNOWN


def _windows() -> str:
    """Return the instruction for a record with too many samples, the beginning of a sentence."""
    return (
        "Use only windows of the log, which form one regression with one verdict "
        f"({setting('windows', ('FROM..TO',))})"
    )
