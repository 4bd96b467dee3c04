"""The record: what was measured, checked once, then read-only."""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import accumulate, pairwise
from operator import index
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.estimation.records.times import (
    BACKWARD,
    RESAMPLE_EVENLY,
    UNEVEN,
    advice_on_backward,
    advice_on_uneven,
    drift_of,
    odd_steps,
    open_end,
)
from axisid.estimation.tables import Provenance, Repair, Samples
from axisid.estimation.thresholds.records import (
    MAX_MEAN_STEP_DEVIATION,
    MAX_STATED_PERIOD_DEVIATION,
    MIN_RECORD_ROWS,
)
from axisid.modeling.declaration import INJECTION_POINTS, ROLES
from axisid.support.arrays import Array, Exact, covered, frozen, runs
from axisid.support.errors import DataError, UsageError
from axisid.support.frozen_mapping import FrozenMapping
from axisid.support.given import given
from axisid.support.presentable import Presentable
from axisid.support.real_numbers import is_real, real_array
from axisid.support.remedy import Remedy, Setting

from .repairs import Span
from .shifts import checked_shifts, shifted
from .windows import Window, checked_windows, rows_within, window_repair, windows_text

_ROWS = "row"  # beside the columns, while some are moved


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False, weakref_slot=True)
class Record(Presentable, Exact):
    """A closed-loop record at one sampling period, in SI units.

    Attributes
    ----------
    time : (N,) array
        s, strictly increasing, without gaps inside a segment.
    position : (N,) array
        Measured, m or rad.
    reference : (N,) array or None
        Commanded position; instrumental variables need it.
    control : (N,) array or None
        Control signal in the drive's unit.
    force : (N,) array or None
        Drive force, N or N m; taken instead of the control where both are given.
    injected : (N,) array or None
        A test signal that was added in the loop, in the unit of what it was added to.
    injected_at : str or None
        What it was added to: ``control``, between the law and the drive's limit, or ``reference``.
    signals : mapping of str to (N,) array
        The recorded signals that an axis declares, by name.
    sample_period : float or None
        s. None takes the mean of the time column's steps. Given beside them, it confirms that the
        log is not sampled as a control law runs, which is then simulated at its own period.
    segments : tuple of (int, int)
        First row and the one after the last of each piece without gaps; empty for one piece.
    masked : tuple of (int, int)
        Rows that are no measurements (clipped), likewise.
    windows : tuple of (float, float)
        First and last time, s, of each part of a log that the record is; empty for the whole.
    around : mapping of str to Samples
        Of such a record the columns of the whole log, for figures; else empty.
    provenance : Provenance
        Where the record comes from.

    Raises
    ------
    DataError
        Columns of different lengths, not finite, constant; time that does not increase evenly.
    """

    time: Array
    position: Array
    reference: Array | None = None
    control: Array | None = None
    force: Array | None = None
    injected: Array | None = None
    injected_at: str | None = None
    signals: Mapping[str, Array] = field(default_factory=dict)
    sample_period: float | None = None
    segments: tuple[tuple[int, int], ...] = ()
    masked: tuple[tuple[int, int], ...] = ()
    windows: tuple[Window, ...] = ()
    around: Mapping[str, Samples] = field(default_factory=dict)
    provenance: Provenance = field(default_factory=Provenance)

    def __post_init__(self) -> None:
        if not isinstance(self.provenance, Provenance):
            raise UsageError(
                f"the provenance of the record is {given(self.provenance)}; give a Provenance, or "
                "leave it out.",
                code="provenance-type",
            )
        for role in ("time", "position"):
            if getattr(self, role) is None:
                raise DataError(f"{self._name()}: there is no {role}; a record needs one.")
        self._check_signals()
        for role, values in self._of_roles().items():
            object.__setattr__(self, role, self._column(role, values))
        columns = {name: self._column(name, values) for name, values in self.signals.items()}
        object.__setattr__(self, "signals", FrozenMapping(columns))
        self._check_injected()
        if not (self.sample_period is None or is_real(self.sample_period)):
            check_sample_period(self.sample_period)
        for name in ("segments", "masked"):
            object.__setattr__(self, name, self._spans(name))
        object.__setattr__(self, "around", _frozen_samples(self.around))
        self._check_lengths()
        self._check_spans()
        self._check_time()
        for role, values in self.channels().items():
            if role in self._varying:
                check_varies(self._name(), role, float(values.min()), float(values.max()))

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        """Made again from its parts, since arrays forget on the way that they are read-only."""
        parts = {each.name: getattr(self, each.name) for each in fields(self)}
        return _made, (type(self), parts)

    def __repr__(self) -> str:
        columns = ", ".join(role for role in self.channels() if role != "time")
        return f"record {self._name()}: {self.size}; {columns}"

    @property
    def size(self) -> str:
        """Samples and sampling period, in words."""
        pieces = f" in {len(self.segments)} segments" if self.segments else ""
        return f"{len(self)} samples of {1e3 * self.period:.6g} ms{pieces}"

    @property
    def period(self) -> float:
        """Sampling period, s."""
        if self.sample_period is not None:
            return self.sample_period
        steps = sum(stop - start - 1 for start, stop in self.spans)
        return float(sum(self.time[b - 1] - self.time[a] for a, b in self.spans) / steps)

    @property
    def period_uncertainty(self) -> float:
        """What jitter of the time column leaves open of its mean step, relative."""
        return open_end([self.time[a:b] for a, b in self.spans])

    @property
    def windows_told(self) -> str:
        """The parts of the log that it is, in words; empty for the whole."""
        return windows_text(self.windows)

    @property
    def spans(self) -> tuple[tuple[int, int], ...]:
        """First row and the one after the last of each segment; of a whole record, its own."""
        return self.segments or ((0, len(self)),)

    def longest(self) -> "Record":
        """The longest segment as a record of its own; a record of one piece itself."""
        if not self.segments:
            return self
        return self._of([max(self.segments, key=lambda span: span[1] - span[0])])

    def windowed(self, *windows: tuple[float | None, float | None]) -> "Record":
        """The record within windows of time alone, each of them a segment.

        Parameters
        ----------
        *windows : (float or None, float or None)
            First and last time of each, s, as `time` counts; None for the record's own end.

        Returns
        -------
        Record
            As if what lies outside had never been recorded.

        Raises
        ------
        UsageError
            A window is no pair of times, or two overlap.
        DataError
            A window is outside the record, or holds less than three samples.
        """
        wanted = checked_windows(windows)
        if not wanted:
            return self
        spans = rows_within(self._name(), self.time, wanted, MIN_RECORD_ROWS.value)
        pieces = [
            (max(a, start), min(b, stop))
            for start, stop in spans
            for a, b in self.spans
            if min(b, stop) - max(a, start) >= MIN_RECORD_ROWS.value
        ]
        first, last = float(self.time[0]), float(self.time[-1])
        return self._of(
            pieces,
            windows=tuple((max(start, first), min(stop, last)) for start, stop in wanted),
            around={r: Samples(values=v, clock=self.time) for r, v in self.channels().items()},
            provenance=self._repaired(window_repair(wanted, spans, len(self))),
        )

    def shifted(self, **shifts: float | str) -> "Record":
        """The record with columns moved to later times, as of a logger that wrote them too early.

        Parameters
        ----------
        **shifts : int, float or str
            By role, whole samples, or a time with its unit: ``control=1``, ``reference="-2ms"``.

        Returns
        -------
        Record
            Without the rows at the ends of each segment that have no partner then.

        Raises
        ------
        UsageError
            A role cannot be moved, or the amount is no whole number of samples.
        """
        wanted = checked_shifts(shifts)  # of roles, and of signals by name
        columns = {
            role: Samples(values=v, clock=self.time)
            for role, v in (*self.channels().items(), (_ROWS, np.arange(float(len(self)))))
            if role != "time"
        }
        masked = covered(self.masked, len(self)).astype(float)
        columns |= {f"{role} {_ROWS}": replace(columns[role], values=masked) for role in wanted}
        moves = {**wanted, **{f"{role} {_ROWS}": shift for role, shift in wanted.items()}}
        found, said = shifted(self._name(), columns, moves, uneven=False)
        kept = found.pop(_ROWS).values.astype(int)
        hidden = masked[kept] > 0
        for role in wanted:
            hidden |= found.pop(f"{role} {_ROWS}").values > 0
        lengths = [int(np.sum((kept >= a) & (kept < b))) for a, b in self.spans]
        joined = [0, *accumulate(lengths)]
        moved = {role: s.values for role, s in found.items()}
        return self.with_channels(
            {"time": self.time[kept], **moved},
            segments=tuple(pairwise(joined)) if self.segments else (),
            masked=runs(hidden),
            provenance=self._repaired(*said[: len(wanted)]),
        )

    def _of(self, pieces: Sequence[Span], **changed: Any) -> "Record":
        """These rows of it, as segments."""
        cut = {
            role: np.concatenate([v[a:b] for a, b in pieces]) for role, v in self.channels().items()
        }
        joined = [0, *accumulate(b - a for a, b in pieces)]
        rows = np.concatenate([np.arange(a, b) for a, b in pieces])
        return self.with_channels(
            cut,
            segments=tuple(pairwise(joined)) if len(pieces) > 1 else (),
            masked=runs(covered(self.masked, len(self))[rows]),
            **changed,
        )

    def _repaired(self, *repairs: Repair) -> Provenance:
        return replace(self.provenance, repairs=(*self.provenance.repairs, *repairs))

    @property
    def commanded(self) -> Array | None:
        """What the control law is to follow: the reference with what was added to it, (N,)."""
        if self.reference is None or self.injected is None or self.injected_at != "reference":
            return self.reference
        return self.reference + self.injected

    @property
    def added_control(self) -> Array | None:
        """What was added to the control, in the drive's unit, (N,); None for nothing."""
        return self.injected if self.injected_at == "control" else None

    def __len__(self) -> int:
        return len(self.time)

    def channels(self) -> dict[str, Array]:
        """The columns there are, by role, and the recorded signals by name."""
        return {**self._of_roles(), **self.signals}

    def with_channels(self, columns: Mapping[str, Array], **changed: Any) -> "Record":
        """The record with other columns, as `channels` gives them."""
        roles: dict[str, Any] = {n: v for n, v in columns.items() if n not in self.signals}
        signals = {name: columns[name] for name in self.signals}
        return replace(self, **roles, signals=signals, **changed)

    def _of_roles(self) -> dict[str, Array]:
        columns = {
            "time": self.time,
            "position": self.position,
            "reference": self.reference,
            "control": self.control,
            "force": self.force,
            "injected": self.injected,
        }
        return {role: values for role, values in columns.items() if values is not None}

    @property
    def digest(self) -> str:
        """Sha256 of the samples: of each channel its role, then its values as 64-bit floats."""
        digest = hashlib.sha256()
        for role, values in self.channels().items():
            digest.update(role.encode())
            digest.update(np.ascontiguousarray(values, dtype="<f8").data)
        return digest.hexdigest()

    def _name(self) -> str:
        return " ".join(
            [self.provenance.source, *([windows_text(self.windows)] if self.windows else [])]
        )

    @property
    def _varying(self) -> set[str]:
        """Roles that say nothing where they are constant; a test signal may move the axis alone."""
        still = {"injected"} if self.injected is None else {"injected", "reference"}
        return {*self._of_roles()} - {"time", *still}

    def _check_signals(self) -> None:
        if not isinstance(self.signals, Mapping):
            raise UsageError(
                f"{self._name()}: the signals are {given(self.signals)}; give arrays by name, such "
                "as {'pressure': values}.",
                code="record-signals",
            )
        if taken := [name for name in self.signals if name in ROLES]:
            raise UsageError(
                f"{self._name()}: {taken[0]!r} is a column of its own, and no signal's name.",
                code="record-signal-name",
            )

    def _check_injected(self) -> None:
        if self.injected is None:
            object.__setattr__(self, "injected_at", None)
        elif self.injected_at not in INJECTION_POINTS:
            raise UsageError(
                f"{self._name()}: the injected signal is added to {self.injected_at!r}; give ",
                Remedy.of(
                    Setting("injected-at", "control"),
                    " or ",
                    Setting("injected-at", "reference"),
                    ".",
                ),
                code="record-injected-at",
            )

    def _column(self, role: str, values: ArrayLike) -> Array:
        column = frozen(real_array(values, f"{self._name()}: the {role}", DataError))
        if column.ndim != 1:
            raise DataError(
                f"{self._name()}: the {role} has the shape {column.shape}; give one row of "
                "numbers.",
                code="signal-shape",
            )
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise DataError(
                f"{self._name()}: the {role} is {column[bad[0]]} in data row {bad[0] + 1} "
                f"({bad.size} in all). Remove such rows or repair the log.",
                code="value-not-finite",
            )
        return column

    def _spans(self, name: str) -> tuple[tuple[int, int], ...]:
        spans = getattr(self, name)
        try:
            return tuple((index(start), index(stop)) for start, stop in spans)
        except (TypeError, ValueError) as error:
            raise UsageError(
                f"{self._name()}: the {name} are {given(spans)}; give pairs of rows, the first "
                "and the one after the last."
            ) from error

    def _check_lengths(self) -> None:
        lengths = {role: len(values) for role, values in self.channels().items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
            raise DataError(
                f"{self._name()}: the columns differ in length: {listed}.", code="record-lengths"
            )
        fewest = MIN_RECORD_ROWS.value
        if len(self) < fewest:
            raise DataError(
                f"{self._name()}: a record needs {fewest} rows or more, not {len(self)}.",
                code="short-record",
            )

    def _check_spans(self) -> None:
        fewest = MIN_RECORD_ROWS.value
        joined = [0, *(row for span in self.segments for row in span), len(self)]
        whole = not self.segments or joined[::2] == joined[1::2]
        lasting = all(stop - start >= fewest for start, stop in self.segments)
        inside = all(0 <= start < stop <= len(self) for start, stop in self.masked)
        if not (whole and lasting and inside):
            raise DataError(
                f"{self._name()}: the segments {self.segments} and masked rows {self.masked} are "
                f"no parts of {len(self)} rows; segments follow one another, with {fewest} rows "
                "or more each.",
                code="record-spans",
            )

    def _check_time(self) -> None:
        back = np.flatnonzero(np.diff(self.time) <= 0)
        if back.size:
            row = back[0] + 2
            raise DataError(
                f"{self._name()}: time does not increase in data row {row}: after "
                f"{self.time[row - 2]:.9g} s comes {self.time[row - 1]:.9g} s. ",
                advice_on_backward(self.time),
                code=BACKWARD,
            )
        inside = np.ones(len(self) - 1, dtype=bool)
        inside[[start - 1 for start, _ in self.segments[1:]]] = False
        self._check_steps(np.diff(self.time), inside)

    def _check_steps(self, steps: Array, inside: NDArray[np.bool_]) -> None:
        """Refuse steps inside the segments that are not the sampling period."""
        typical = float(np.median(steps[inside]))
        gaps = np.flatnonzero(odd_steps(steps, typical) & inside)
        if gaps.size:
            row = gaps[0] + 2
            raise DataError(
                f"{self._name()}: the time step before data row {row} is {steps[gaps[0]]:.6g} s, "
                f"{typical:.6g} s elsewhere ({gaps.size} of {len(steps)} steps differ). ",
                advice_on_uneven(steps[inside], typical),
                code=UNEVEN,
            )
        mean = float(np.mean(steps[inside]))
        check_even(self._name(), typical, mean, self.sample_period, RESAMPLE_EVENLY)
        drift = drift_of([self.time[a:b] for a, b in self.spans])
        drift.check(self._name(), mean, RESAMPLE_EVENLY)


def _frozen_samples(columns: Mapping[str, Samples]) -> FrozenMapping[str, Samples]:
    """Columns that nobody changes."""
    return FrozenMapping(
        {
            role: Samples(
                values=frozen(s.values), clock=None if s.clock is None else frozen(s.clock)
            )
            for role, s in columns.items()
        }
    )


def _made(kind: type[Record], parts: dict[str, Any]) -> Record:
    return kind(**parts)


def check_even(
    source: str, typical: float, mean: float, period: float | None, advice: Remedy
) -> None:
    """Refuse a median and a mean step, s, that are apart, or are not the period that was given."""
    if not abs(mean / typical - 1) < MAX_MEAN_STEP_DEVIATION.value:
        raise DataError(
            f"{source}: the time steps are uneven: {typical:.6g} s in the middle, "
            f"{mean:.6g} s in the mean. ",
            advice,
            code=UNEVEN,
        )
    if period is not None:
        check_stated(source, typical, period)


def check_stated(source: str, found: float, stated: float, uncertainty: float = 0.0) -> None:
    """Refuse a sampling period that was given, s, and is not the one of the time column."""
    if not abs(stated / found - 1) < MAX_STATED_PERIOD_DEVIATION.value + uncertainty:
        raise DataError(
            f"{source}: the sampling period is given as {stated:g} s, but the time "
            f"column steps by {found:g} s. Correct one of them (time is in seconds).",
            code="other-sample-period",
        )


def check_sample_period(period: object) -> None:
    """Refuse what is no sampling period."""
    if period is not None and not (is_real(period) and 0 < period < math.inf):
        raise UsageError(
            f"the sampling period is {given(period)}; give a positive number of seconds.",
            code="bad-sample-period",
        )


def check_varies(source: str, role: str, least: float, most: float) -> None:
    """Refuse a column whose least and largest value are one."""
    if least == most:
        raise DataError(
            f"{source}: the {role} is {least:g} in every row, so it says nothing "
            f"about the axis. Check the {role} column, or record a motion.",
            code="constant-column",
        )


def check_record(record: object) -> None:
    """Refuse what is no record, such as a file's name."""
    if not isinstance(record, Record):
        raise UsageError(
            f"the record is {given(record)}; read one with read_record(path, axis).",
            code="record-type",
        )


def record_labels(records: Sequence[Record]) -> tuple[str, ...]:
    """Names of several records: of their files, with a number where files are alike."""
    sources = [record.provenance.source for record in records]
    return tuple(
        source if sources.count(source) == 1 else f"{source} (record {i})"
        for i, source in enumerate(sources, 1)
    )
