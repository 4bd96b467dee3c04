"""Logs larger than memory: the roles' columns block by block, as often as they are asked for."""

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, as_declared
from axisid.estimation.logs import (
    check_kind,
    check_regular,
    format_of,
    packing_of,
    streamed_formats,
    unpacking,
)
from axisid.estimation.logs.text import cut_end_notes, encoding_of
from axisid.estimation.records.columns import RoleColumns, motion_role
from axisid.estimation.records.faults import Jumps, jump_note
from axisid.estimation.records.times import UNEVEN, Drift, step_notes
from axisid.estimation.tables import LogClock, Provenance, Samples, Table, says_long
from axisid.estimation.thresholds.records import MAX_EVEN_STEP, MIN_RECORD_SAMPLES
from axisid.modeling.declaration import Axis, Column, column_texts
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError
from axisid.support.files.unchanged import WatchedFile
from axisid.support.real_numbers import real_array
from axisid.support.remedy import Note, Remedy, Setting

from .clocks import EMPTY_CELLS, NO_TIME, no_time
from .period_checks import check_even, check_sample_period
from .record_checks import check_varies

ROWS = 100_000
_PIECE = 1 << 20  # bytes
_AT_ONCE = Setting("stream", given=False)
_WHOLE = Remedy.of("A log that is to be repaired is read whole: ", _AT_ONCE, ".")
_AT_ONCE_RESAMPLED = Remedy.of(_AT_ONCE, ", or write columns of one clock.")
_BINS = 20_000  # of time steps, from the least that is even to the largest


@dataclass(frozen=True, slots=True, kw_only=True)
class LogBlocks:
    """A log file in blocks, of a format that gives rows in order. Iterating reads it anew.

    Every pass is hashed as it is read; a file that is not what it was in the first pass is refused.

    Attributes
    ----------
    file : Path
    axis : Axis, GeneratedAxis or None
    columns : mapping of str to str or Column
        As in `read_record`.
    rows : int
        Of a block.
    injected_at : str, optional
        As in `read_record`.
    """

    file: Path
    axis: Axis | GeneratedAxis | None = None
    columns: Mapping[str, str | Column] = field(default_factory=dict)
    rows: int = ROWS
    injected_at: str | None = None
    _passes: "_Passes" = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.file, (str, Path)):
            raise UsageError(f"the log is {self.file!r}; give the path of a file.")
        object.__setattr__(self, "file", Path(self.file))
        object.__setattr__(self, "axis", as_declared(self.axis))
        object.__setattr__(self, "_passes", _Passes(self.file))

    def __iter__(self) -> Iterator[dict[str, Array]]:
        """Columns by role, in SI."""
        for chosen in self._chosen():
            yield _columns(str(self.file), chosen.samples)

    def _chosen(self) -> Iterator[RoleColumns]:
        packing, inner = packing_of(self.file), _unpacked_name(self.file)
        log_format = format_of(inner)
        known = log_format.blocks is not None and inner.suffix.lower() in log_format.endings
        if log_format.blocks is None or not known or (packing and not log_format.in_order):
            whole = "it is packed, unpack it first" if known else log_format.whole
            why = f": {whole}" if whole else ""
            raise UsageError(
                f"{self.file} cannot be read in blocks{why}; ",
                Remedy.of(f"give {streamed_formats()}, or ", _AT_ONCE, "."),
                code="not-in-blocks",
            )
        check_regular(self.file, folder=False)
        try:
            check_kind(self.file)
            for table in self._passes.tables(self.rows, log_format.blocks, text=log_format.is_text):
                if says_long(table.columns):
                    raise _long(table)
                yield RoleColumns(
                    table,
                    as_declared(self.axis),
                    column_texts(self.columns),
                    injected_at=self.injected_at,
                )
        except OSError as error:
            raise DataError(
                f"{self.file} cannot be read: {error.strerror}. Check the path."
            ) from error

    def provenance(self) -> Provenance:
        """Where the log comes from and what is assumed of it."""
        first = next(self._chosen(), None)
        if first is None:
            raise DataError(f"{self.file} has no rows.")
        return Provenance(
            source=self.file.name,
            sha256=self._passes.watched.complete(),
            given=str(self.file),
            path=os.path.abspath(self.file),
            columns=first.names,
            assumed=first.notes,
            doubts=self._cut_end(),
        )

    def _cut_end(self) -> tuple[Note, ...]:
        plain = packing_of(self.file) is None and format_of(self.file).is_text
        return cut_end_notes(self.file) if plain else ()


def _unpacked_name(file: Path) -> Path:
    """A file's name without the ending of what packs it."""
    return Path(file.stem) if packing_of(file) else file


def _columns(source: str, samples: Mapping[str, Samples]) -> dict[str, Array]:
    """Columns by role, whose times are those of their common clock if they have one.

    Raises
    ------
    DataError
        They differ in length, or have clocks of their own.
    """
    columns = {role: each.values for role, each in samples.items()}
    lengths = {role: len(values) for role, values in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
        raise DataError(
            f"{source}: the columns of a block differ in length: {listed}. ",
            _WHOLE,
            code="lengths-in-blocks",
        )
    clocks = [each.clock for role, each in samples.items() if role != "time"]
    told = [clock for clock in clocks if clock is not None]
    if any(not np.array_equal(clock, told[0]) for clock in told):
        raise DataError(
            f"{source}: its signals were sampled at times of their own, and a log in blocks is not "
            "resampled; ",
            _AT_ONCE_RESAMPLED,
            code="clocks-in-blocks",
        )
    return {"time": told[0]} | columns if told else columns


def _long(table: Table) -> DataError:
    return DataError(
        f"{table.source}: a row is the value of one signal ({', '.join(table.columns)}), and such "
        "a table is made wide as a whole; ",
        Remedy.of(_AT_ONCE, ", or write a column for each signal."),
        code="long-in-blocks",
    )


class _Passes:
    """The passes over a file, each held against those before it once it comes to its end."""

    def __init__(self, file: Path) -> None:
        self.watched = WatchedFile(file)
        self._encoding = ""

    def tables(
        self, rows: int, blocks: Callable[..., Iterator[Table]], *, text: bool
    ) -> Iterator[Table]:
        """The file's table, so many rows at a time."""
        source = str(self.watched.file)
        encoding = (self._found(source),) if text else ()
        with self.watched.opened() as raw:
            with self._unpacked(raw) as stream:
                for table in blocks(source, stream, rows, *encoding):
                    yield replace(table, notes=(*self._packed, *table.notes))
            self.watched.finish(raw)

    def _unpacked(self, raw: Any) -> AbstractContextManager[Any]:
        """What is packed in a pass, or the pass itself."""
        packing = packing_of(self.watched.file)
        return nullcontext(raw) if packing is None else unpacking(packing, self.watched.file, raw)

    @property
    def _packed(self) -> tuple[str, ...]:
        packing = packing_of(self.watched.file)
        return () if packing is None else (f"unpacked by {packing.name}",)

    def _found(self, source: str) -> str:
        """The encoding, which takes a pass of its own, once."""
        if not self._encoding:
            with self.watched.opened() as raw:
                with self._unpacked(raw) as stream:
                    self._encoding = encoding_of(source, iter(partial(stream.read, _PIECE), b""))
                self.watched.finish(raw)
        return self._encoding


@dataclass(frozen=True, slots=True, kw_only=True)
class Extent:
    """What a first pass over a log finds.

    Attributes
    ----------
    samples : int
    period : float
        s
    notes : tuple of Note
        What is assumed of its times, and of jumps in its position.
    clock : LogClock
        Whose word the period is.
    """

    samples: int
    period: float
    notes: tuple[Note, ...] = ()
    clock: LogClock = field(default_factory=LogClock)


def extent(
    source: str,
    blocks: Iterable[Mapping[str, Array]],
    period: float | None,
    axis: Axis | None = None,
) -> Extent:
    """Count the samples of a log, and make the checks of a `Record`.

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
        Time has gaps or is uneven, a value is not finite, a column is constant, there is no time,
        or the position jumps by whole turns.
    """
    check_sample_period(period)
    check = _BlockChecks(source, axis)
    for block in blocks:
        check.add(block)
    return check.found(period)


class _BlockChecks:
    """The checks that the record's own makes at once, made block by block."""

    def __init__(self, source: str, axis: Axis | None) -> None:
        self.source, self.axis, self.samples, self.timed = source, axis, 0, True
        self.first = self.last = self.typical = 0.0
        self.least, self.most = math.inf, 0.0
        self.jumps = Jumps()
        self.reached: dict[str, tuple[float, float]] = {}  # least and largest value, by role
        self.drift = Drift()
        self.counts, self.sums = np.zeros(_BINS, dtype=np.int64), np.zeros(_BINS)  # of time steps

    def add(self, block: Mapping[str, Array]) -> None:
        """Take the next block."""
        block = {
            role: real_array(values, f"{self.source}: the {role}", DataError)
            for role, values in block.items()
        }
        for role, values in block.items():
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                raise DataError(
                    f"{self.source}: the {role} is {values[bad[0]]} in data row "
                    f"{self.samples + bad[0] + 1}. ",
                    _WHOLE,
                    code=EMPTY_CELLS,
                )
            least, most = self.reached.get(role, (math.inf, -math.inf))
            least = min(least, float(values.min(initial=math.inf)))
            self.reached[role] = least, max(most, float(values.max(initial=-math.inf)))
        if "position" in block:
            self.jumps.add(block["position"])
        rows = len(block[motion_role(block)])
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
        longest = MAX_EVEN_STEP.value
        even = (steps <= longest * self.typical) & (steps * longest >= self.typical)
        wrong = np.flatnonzero(~(even & (steps > 0)))
        if wrong.size:
            raise DataError(
                f"{self.source}: the time step before data row {self.samples + wrong[0] + 1} is "
                f"{steps[wrong[0]]:.6g} s, {self.typical:.6g} s in the first rows. ",
                _WHOLE,
                code=UNEVEN,
            )
        self.last = float(time[-1])
        self.drift.add(time)
        steps = steps[1:] if not self.samples else steps
        self.least = min(self.least, float(steps.min(initial=math.inf)))
        self.most = max(self.most, float(steps.max(initial=0.0)))
        share = (steps / self.typical - 1 / longest) / (longest - 1 / longest)
        bins = np.clip((_BINS * share).astype(np.int64), 0, _BINS - 1)
        self.counts += np.bincount(bins, minlength=_BINS)
        self.sums += np.bincount(bins, weights=steps, minlength=_BINS)

    def _middle(self) -> float:
        """The median step, to the width of a bin: the mean of those in its bin."""
        so_far = np.cumsum(self.counts)
        middle = int(np.searchsorted(so_far, so_far[-1] / 2))
        return float(self.sums[middle] / self.counts[middle])

    def _check_times(self, mean: float, period: float | None) -> None:
        """Hold the steps against the median of all, which the first rows need not have."""
        middle = self._middle()
        if self.most > MAX_EVEN_STEP.value * middle or self.least * MAX_EVEN_STEP.value < middle:
            raise DataError(
                f"{self.source}: the time steps are {self.least:.6g} to {self.most:.6g} s, "
                f"{middle:.6g} s in the middle. ",
                _WHOLE,
                code=UNEVEN,
            )
        check_even(self.source, middle, mean, period, _WHOLE)
        self.drift.check(self.source, mean, _WHOLE)

    def _still(self) -> set[str]:
        """Roles that may be constant, as in a `Record`."""
        signals = {s.name for s in self.axis.signals} if self.axis is not None else set()
        still = {"time", "injected"} | signals
        return still | ({"reference"} if "injected" in self.reached else set())

    def found(self, period: float | None) -> Extent:
        """The extent, once all blocks were taken."""
        if self.samples < MIN_RECORD_SAMPLES.value:
            raise DataError(f"{self.source}: a record needs 3 rows or more, not {self.samples}.")
        if period is None and not self.timed:
            raise DataError(f"{self.source}: there is no time column; ", no_time(), code=NO_TIME)
        jumps = jump_note(self.source, self.jumps, self.axis)
        mean = (self.last - self.first) / (self.samples - 1)
        if self.timed:
            self._check_times(mean, period)
        for role, (least, most) in self.reached.items():
            if role not in self._still():
                check_varies(self.source, role, least, most)
        notes = step_notes(self.least, self.most, mean, self.drift) if self.timed else ()
        spread = (self.most - self.least) / (self.last - self.first) if period is None else 0.0
        return Extent(
            samples=self.samples,
            period=mean if period is None else period,
            notes=(notes if jumps is None else (jumps, *notes)),
            clock=LogClock(uncertainty=spread, counted=not self.timed, stated=period is not None),
        )
