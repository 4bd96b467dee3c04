"""Logs larger than memory: the roles' columns block by block, as often as they are asked for."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from axisid.modeling import Axis, UsageError

from .arrays import Array
from .clocks import steps_told
from .errors import DataError
from .file_kinds import check_kind, check_regular
from .provenance import Provenance
from .read_columnar import parquet_blocks
from .read_text import text_blocks
from .readers import file_digest
from .record import LARGEST_GAP, PERIOD_TOLERANCE
from .roles import Chosen
from .table import Samples
from .unwrapping import left_jumps

ROWS = 100_000
_TEXT = (".csv", ".tsv", ".txt")
_PARQUET = (".parquet", ".pq")


@dataclass(frozen=True, slots=True, kw_only=True)
class LogBlocks:
    """A log file in blocks: delimited text or Parquet. Iterating reads it anew.

    Attributes
    ----------
    file : Path
    axis : Axis or None
    columns : mapping of str to str
        As in `read_record`.
    rows : int
        Of a block.
    """

    file: Path
    axis: Axis | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    rows: int = ROWS

    def __iter__(self) -> Iterator[dict[str, Array]]:
        """Columns by role, in SI."""
        for chosen in self._chosen():
            yield {role: samples.values for role, samples in chosen.samples.items()}

    def _chosen(self) -> Iterator[Chosen]:
        ending = self.file.suffix.lower()
        if ending not in (*_TEXT, *_PARQUET):
            raise UsageError(
                f"{self.file} cannot be read in blocks; give delimited text "
                f"({', '.join(_TEXT)}) or Parquet, or leave --stream out."
            )
        check_regular(self.file, folder=False)
        check_kind(self.file)
        reader = text_blocks if ending in _TEXT else parquet_blocks
        for table in reader(self.file, self.rows):
            yield Chosen(table, self.axis, dict(self.columns))

    def provenance(self) -> Provenance:
        """Where the log comes from and what is assumed of it."""
        first = next(self._chosen(), None)
        if first is None:
            raise DataError(f"{self.file} has no rows.")
        return Provenance(
            source=self.file.name,
            sha256=file_digest(self.file),
            columns=first.names,
            assumed=first.notes,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Extent:
    """What a first pass over a log finds.

    Attributes
    ----------
    samples : int
    period : float
        s
    notes : tuple of str
        What is assumed of its times.
    """

    samples: int
    period: float
    notes: tuple[str, ...] = ()


def extent(
    source: str,
    blocks: Iterable[Mapping[str, Array]],
    period: float | None,
    axis: Axis | None = None,
) -> Extent:
    """Count the samples of a log, and check that its time is even and its values are numbers.

    Parameters
    ----------
    source : str
        For messages.
    blocks : iterable of columns by role
    period : float, optional
        s; in place of the time column's mean step.
    axis : Axis, optional
        Its coordinate says whether the position turns.

    Raises
    ------
    DataError
        Time has gaps or is uneven, a value is not finite, there is no time, or the position jumps
        by whole turns.
    """
    check = _Even(source, axis)
    for block in blocks:
        check.add(block)
    return check.found(period)


class _Even:
    """A check that the record's own makes at once, made block by block."""

    def __init__(self, source: str, axis: Axis | None) -> None:
        self.source, self.axis, self.samples, self.timed = source, axis, 0, True
        self.first = self.last = self.typical = 0.0
        self.least, self.most = math.inf, 0.0

    def add(self, block: Mapping[str, Array]) -> None:
        """Take the next block."""
        for role, values in block.items():
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                raise DataError(
                    f"{self.source}: the {role} is {values[bad[0]]} in data row "
                    f"{self.samples + bad[0] + 1}. Remove such rows or repair the log."
                )
        position = Samples(values=block["position"])
        left_jumps(self.source, position, self.axis, LARGEST_GAP, before=self.samples)
        rows = len(block["position"])
        if "time" not in block:
            self.timed = False
        elif rows:
            self._add_times(block["time"])
        self.samples += rows

    def _add_times(self, time: Array) -> None:
        if not self.samples:
            self.first = float(time[0])
            self.typical = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        before = self.last if self.samples else self.first - self.typical
        steps = np.diff(time, prepend=before)
        even = (steps <= LARGEST_GAP * self.typical) & (steps * LARGEST_GAP >= self.typical)
        wrong = np.flatnonzero(~(even & (steps > 0)))
        if wrong.size:
            raise DataError(
                f"{self.source}: the time step before data row {self.samples + wrong[0] + 1} is "
                f"{steps[wrong[0]]:.6g} s, {self.typical:.6g} s in the first rows. A log that is "
                "to be repaired is read whole: leave --stream out."
            )
        self.last = float(time[-1])
        steps = steps[1:] if not self.samples else steps
        self.least = min(self.least, float(steps.min(initial=math.inf)))
        self.most = max(self.most, float(steps.max(initial=0.0)))

    def found(self, period: float | None) -> Extent:
        """The extent, once all blocks were taken."""
        if self.samples < 3:
            raise DataError(f"{self.source}: a record needs 3 rows or more, not {self.samples}.")
        if period is None and not self.timed:
            raise DataError(
                f"{self.source}: there is no time column; name it with --columns time=NAME, or "
                "give --sample-period."
            )
        mean = (self.last - self.first) / (self.samples - 1)
        if self.timed and period is not None and not abs(period / mean - 1) < PERIOD_TOLERANCE:
            raise DataError(
                f"{self.source}: the sampling period is given as {period:g} s, but the time column "
                f"steps by {mean:g} s. Correct one of them (time is in seconds)."
            )
        notes = steps_told(self.least, self.most, mean) if self.timed else ()
        return Extent(samples=self.samples, period=mean if period is None else period, notes=notes)
