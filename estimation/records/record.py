"""The record: measured signals, checked once, then read-only; and the clock of the control law.

A time column in another unit, or with a wrong scale, changes every inertia by the square of the
scale, and shows no other effect in a record without reference. If the axis declares a control law,
the period of the law is compared with the period of the log. If the periods differ, the user has to
confirm the period of the log, or to declare how the law interpolates its reference between the
samples of the log. A continuous law has no period.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.generated_axes import GeneratedAxis, as_declared
from axisid.estimation.findings import Finding
from axisid.estimation.raw_tables import PeriodSource, Provenance, Repair, Samples
from axisid.estimation.records.columns import log_content
from axisid.estimation.thresholds import LARGEST_VALUE, MIN_RECORD_SAMPLES
from axisid.modeling.declaration import INJECTION_POINTS, ROLES, Axis, ControlLaw
from axisid.modeling.quantities import settle
from axisid.support.arrays import Array, Exact, frozen, mask_of, runs
from axisid.support.checks import real_array, refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.files import write_file
from axisid.support.mappings import FrozenMapping
from axisid.support.presentable import Presentable
from axisid.support.wording import quoted

from .clocks import check_sample_period, check_time, period_uncertainty
from .segments import (
    Span,
    Window,
    adjoining,
    check_spans,
    checked_spans,
    checked_windows,
    reaching,
    samples_within,
    window_repair,
    windows_text,
)
from .shifts_and_interpolation import Rows, check_movable, checked_shifts, shifted_rows

#: First word of the description in a log that `Record.write` writes.
MARK = "axisid.record/1"


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False, weakref_slot=True)
class Record(Presentable, Exact):
    """A closed-loop record at one sampling period, in SI units.

    Attributes
    ----------
    time : (N,) array
        Time, s, strictly increasing, without gaps inside a segment.
    position : (N,) array
        Measured position, m or rad. If none is given, the integral of the velocity, segment by
        segment from the reference at its start or from 0; only an axis whose model does not depend
        on the position can use it.
    velocity : (N,) array or None
        Measured velocity, m/s or rad/s; used instead of the differentiated position. None if it was
        not recorded; the same applies to the columns below.
    acceleration : (N,) array or None
        Measured acceleration, m/s^2 or rad/s^2; used instead of the differentiated velocity.
    reference : (N,) array or None
        Commanded position, m or rad; instrumental variables need it.
    control : (N,) array or None
        Control signal in the drive's unit.
    force : (N,) array or None
        Drive force, N or N m; used instead of the control if both are given.
    injected : (N,) array or None
        Test signal that was added in the loop, in the unit of the signal that it was added to.
    injected_at : str or None
        Injection point: ``control``, between the law and the drive's limit, or ``reference``. None
        without a test signal.
    signals : mapping of str to (N,) array
        Recorded signals that an axis declares, by name.
    sample_period : float or None
        Sampling period, s; the mean step of the time column for None. A given period confirms that
        the log is not sampled with the period of the control law, which is then simulated at its
        own period.
    segments : tuple of (int, int)
        First sample and the one after the last of each piece without gaps; empty for one piece.
    masked : tuple of (int, int)
        First sample and the one after the last of each piece that is not a measurement (clipped).
    windows : tuple of (float, float)
        First and last time, s, of each part of a log; empty for the whole log.
    around : mapping of str to Samples
        Columns of the whole log, for figures of a record of windows; otherwise empty.
    provenance : Provenance
        Source of the record.
    integrated : bool
        True if the position is the integral of the velocity; set if no position is given.
    sampled : Record or None
        Rows of a resampled record before resampling, if its columns have one clock and no gaps:
        these are the values that the control law read. None otherwise.

    Raises
    ------
    DataError
        Columns of different lengths, not finite, constant; time that does not increase evenly.
    """

    time: Array
    position: Array = field(default_factory=lambda: np.empty(0))
    velocity: Array | None = None
    acceleration: Array | None = None
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
    integrated: bool = False
    sampled: "Record | None" = None

    def __post_init__(self) -> None:
        """Check the record, and store its arrays read-only.

        The steps are:

        1. Check that there is a time and a motion, and the names of signals and of the injection
           point. Mark the position as integrated if none is given.
        2. Check a given sampling period, and each column: finite numbers, equal lengths.
        3. Store the columns, `around`, the segments and the masked pieces in their final form.
        4. Check the segments and masked pieces, then the time within each segment.
        5. Integrate the velocity if there is no position.
        6. Refuse a constant column.
        """
        self._check_roles()
        name, injected = self._name(), self.injected is not None
        if self.sample_period is not None:
            check_sample_period(self.sample_period)
        # Check the columns one by one, then keep them read-only.
        columns = {role: checked_column(name, role, v) for role, v in self.channels().items()}
        check_lengths(name, columns)
        # Columns of the whole log for figures, with a time for each value.
        around = {
            role: Samples(values=frozen(s.values), clock=frozen(s.times))
            for role, s in self.around.items()
        }
        settle(
            self,
            **{role: values for role, values in columns.items() if role in ROLES},
            signals=FrozenMapping({each: columns[each] for each in self.signals}),
            injected_at=self.injected_at if injected else None,
            around=FrozenMapping(around),
            segments=checked_spans(name, "segments", self.segments),
            masked=checked_spans(name, "masked", self.masked),
        )
        check_spans(name, self.time, self.segments, self.masked)
        check_time(name, self.time, self.spans, self.sample_period)
        # Integrate the velocity. A copy or a pickle of a record has its integral already, with a
        # value for each sample; otherwise the position is empty.
        if self.integrated:
            has_integral = np.size(self.position) == len(self)
            settle(self, position=frozen(self.position if has_integral else self._integral()))
        # Refuse a constant column. The reference may be constant if a test signal moves the axis.
        unchecked = ("time", "injected", "reference") if injected else ("time",)
        for role, values in columns.items():
            if role in ROLES and role not in unchecked and values.min() == values.max():
                raise DataError(
                    f"{name}: the {role} is {values[0]:g} in every row, so it has no information "
                    f"about the axis. Check the {role} column, or record a motion.",
                    code="not-shown",
                )

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        """Return a constructor call for pickling, as the arrays of a pickle are not read-only."""
        return partial(
            type(self), **{each.name: getattr(self, each.name) for each in fields(self)}
        ), ()

    def __repr__(self) -> str:
        columns = ", ".join(role for role in self.channels() if role != "time")
        return f"record {self._name()}: {self.size}; {columns}"

    @property
    def size(self) -> str:
        """Number of samples and sampling period as a text, with the number of segments."""
        pieces = f" in {len(self.segments)} segments" if self.segments else ""
        return f"{len(self)} samples of {1e3 * self.period:.6g} ms{pieces}"

    @property
    def motion(self) -> tuple[str, ...]:
        """Names of the recorded columns among position, velocity and acceleration."""
        return tuple(r for r in ("position", "velocity", "acceleration") if r in self.channels())

    @property
    def period(self) -> float:
        """Sampling period, s."""
        if self.sample_period is not None:
            return self.sample_period
        steps = sum(stop - start - 1 for start, stop in self.spans)
        return float(sum(self.time[b - 1] - self.time[a] for a, b in self.spans) / steps)

    @property
    def spans(self) -> tuple[tuple[int, int], ...]:
        """First sample and the one after the last of each segment, or of the whole record."""
        return self.segments or ((0, len(self)),)

    def longest(self) -> "Record":
        """Return the longest segment as a record; the record itself if it has one piece."""
        longest = max(self.spans, key=lambda span: span[1] - span[0])
        return self._with_pieces([longest]) if self.segments else self

    def windowed(self, *windows: tuple[float | None, float | None]) -> "Record":
        """Return the record within windows of time, each of which is a segment.

        Parameters
        ----------
        *windows : (float or None, float or None)
            First and last time of each window, s, in the record's `time`; None for the start or end
            of the record.

        Returns
        -------
        Record
            Samples within the windows. Each window is a segment, or several if it has gaps. The
            channels of the whole record, also outside the windows, are kept in `around` for
            figures; they have no effect on estimates.

        Raises
        ------
        UsageError
            A window is not a pair of times, or two windows overlap.
        DataError
            A window is outside the record, or has fewer than three samples.
        """
        wanted = checked_windows(windows)
        if not wanted:
            return self
        spans = samples_within(self._name(), self.time, wanted, MIN_RECORD_SAMPLES.value)
        # Each window is divided at the gaps of the record; pieces that are too short are left out.
        pieces = [
            (max(a, start), min(b, stop))
            for start, stop in spans
            for a, b in self.spans
            if min(b, stop) - max(a, start) >= MIN_RECORD_SAMPLES.value
        ]
        return self._with_pieces(
            pieces,
            windows=reaching(wanted, float(self.time[0]), float(self.time[-1])),
            around={r: Samples(values=v, clock=self.time) for r, v in self.channels().items()},
            provenance=self._provenance_with(window_repair(wanted, spans, len(self))),
        )

    def shifted(self, **shifts: float | str) -> "Record":
        """Return the record with columns shifted to later times, if a logger wrote them too early.

        Parameters
        ----------
        **shifts : int, float or str
            Shifts by role, or by name of a recorded signal: a whole number of samples, or a time
            with its unit that is a whole number of samples, as in ``control=1`` and
            ``reference="-2ms"``. A negative shift is to earlier times.

        Returns
        -------
        Record
            Shifted record without the samples at the ends of each segment that have no counterpart.

        Raises
        ------
        UsageError
            The time is to be shifted, or a shift is not a whole number of samples.
        DataError
            There is no column of a given role or name.
        """
        wanted = checked_shifts(shifts)
        check_movable(self._name(), self.channels(), wanted)
        kept, counterparts, repairs = shifted_rows(self._name(), self.time, wanted)
        lengths = [int(np.sum((kept >= a) & (kept < b))) for a, b in self.spans]
        return self._with_rows(
            kept, lengths, counterparts, provenance=self._provenance_with(*repairs)
        )

    def write(self, file: str | Path, axis: Axis | GeneratedAxis) -> Path:
        """Write the record as a log that `read_record` reads back unchanged.

        Columns have the names and units that the axis declares, or else their roles and SI. Columns
        that the axis does not name, such as a velocity or an injected signal, have to be named when
        the log is read: ``columns={"velocity": "velocity"}``. Segments are gaps in the time, for
        ``Repairs(gaps="split")``; masked samples are written like others.

        Parameters
        ----------
        file : str or Path
            Path of the log, which ends in ``.csv``, ``.parquet`` (needs pyarrow) or ``.npz``. If
            writing fails, no file is left behind.
        axis : Axis or GeneratedAxis
            Axis with the names and units of the columns.

        Returns
        -------
        Path
            Path of the log.

        Raises
        ------
        UsageError
            The ending is not one of these, or the file cannot be written.
        ModelError
            The axis declares a column name that is not possible in a header.
        DataError
            pyarrow is not installed.
        """
        if not isinstance(file, (str, Path)):
            raise UsageError(
                f"the file is {quoted(file)}. Give the path of the file as a text or a Path.",
                code="twin",
            )
        path, declared = Path(file), as_declared(axis)
        if declared is None:
            raise UsageError(
                f"the axis is {quoted(axis)}. Give the axis of the record, as load_axis or build "
                "returns it.",
                code="twin",
            )
        return write_file(path, log_content(self.channels(), declared, MARK, self._name(), path))

    def _with_pieces(self, pieces: Sequence[Span], **changed: Any) -> "Record":
        """Return the record reduced to some pieces, each of which becomes a segment.

        Parameters
        ----------
        pieces : sequence of (int, int)
            First sample and the one after the last of each piece.
        **changed
            New values of further attributes.
        """
        rows = np.flatnonzero(mask_of(pieces, len(self)))
        return self._with_rows(rows, [b - a for a, b in pieces], {}, **changed)

    def _with_rows(
        self, rows: Rows, lengths: Sequence[int], rows_by_role: Mapping[str, Rows], **changed: Any
    ) -> "Record":
        """Return the record reduced to some rows.

        A sample is masked if any of its values was masked.

        Parameters
        ----------
        rows : (n,) array of int
            Rows that are kept.
        lengths : sequence of int
            Number of kept rows in each segment.
        rows_by_role : mapping of str to (n,) array of int
            Rows of the columns that are shifted, by role, instead of `rows`.
        **changed
            New values of further attributes.
        """
        columns = {role: v[rows_by_role.get(role, rows)] for role, v in self.channels().items()}
        masked = mask_of(self.masked, len(self))
        masked_rows = [masked[column_rows] for column_rows in (rows, *rows_by_role.values())]
        # An integrated position is not among the columns: it is integrated again.
        return self.with_channels(
            {"position": np.empty(0), **columns},
            segments=adjoining(lengths),
            masked=runs(np.any(masked_rows, axis=0)),
            **changed,
        )

    def _provenance_with(self, *repairs: Repair) -> Provenance:
        """Return the provenance of the record with further repairs."""
        return replace(self.provenance, repairs=(*self.provenance.repairs, *repairs))

    @property
    def commanded(self) -> Array | None:
        """Reference that the law follows, including a test signal added to it, (N,).

        None if the record has no reference.
        """
        if self.reference is None or self.injected is None or self.injected_at != "reference":
            return self.reference
        return self.reference + self.injected

    @property
    def added_control(self) -> Array | None:
        """Test signal added to the control, in the drive's unit, (N,).

        None if there is no test signal, or if it was added to the reference.
        """
        return self.injected if self.injected_at == "control" else None

    def __len__(self) -> int:
        return len(self.time)

    def channels(self) -> dict[str, Array]:
        """Return the recorded columns by role or name of a signal, (N,) each.

        A position that is integrated from the velocity is not among them.
        """
        roles = {r: getattr(self, r) for r in ROLES if not (self.integrated and r == "position")}
        return {**{r: v for r, v in roles.items() if v is not None}, **self.signals}

    def with_channels(self, columns: Mapping[str, Array], **changed: Any) -> "Record":
        """Return the record with all columns replaced.

        The samples before resampling (`sampled`) are dropped.

        Parameters
        ----------
        columns : mapping of str to (n,) array
            New columns by role or name of a signal, as in `channels`.
        **changed
            New values of further attributes.
        """
        roles: dict[str, Any] = {n: v for n, v in columns.items() if n not in self.signals}
        roles["signals"] = {name: columns[name] for name in self.signals}
        return replace(self, **{"sampled": None, **roles, **changed})

    def with_values(self, **columns: Array) -> "Record":
        """Return the record with new values of some columns, by role; only these are checked."""
        changed, name = object.__new__(type(self)), self._name()
        settle(changed, **{each.name: getattr(self, each.name) for each in fields(self)})
        settle(changed, **{r: checked_column(name, r, values) for r, values in columns.items()})
        check_lengths(name, changed.channels())
        return changed

    @property
    def digest(self) -> str:
        """SHA-256 of the samples: of the role of each channel, then its values as 64-bit floats."""
        digest = hashlib.sha256()
        for role, values in self.channels().items():
            digest.update(role.encode())
            digest.update(np.ascontiguousarray(values, dtype="<f8").data)
        return digest.hexdigest()

    def _name(self) -> str:
        """Return the name of the log and its windows, for messages."""
        return f"{self.provenance.source} {windows_text(self.windows)}".rstrip()

    def _check_roles(self) -> None:
        """Refuse a record without time or motion, or a test signal without an injection point.

        For a record with a velocity only, mark the position as integrated.
        """
        no_position = self.position is None or not np.size(self.position)
        refuse(
            DataError,
            (self.time is None, "the record has no time. Give the argument time"),
            (
                no_position and self.velocity is None,
                "the record has neither a position nor a velocity. Give at least one of them",
            ),
            before=f"{self._name()}: ",
            code="missing-column",
        )
        # Signals that are not a mapping, or a signal with the name of a role; empty for none.
        no_mapping = "" if isinstance(self.signals, Mapping) else quoted(self.signals)
        names = () if no_mapping else self.signals
        role_name = next((name for name in names if name in ROLES), "")
        refuse(
            UsageError,
            (
                no_mapping,
                f"the signals are {no_mapping}. Give arrays by name, such as "
                "{'pressure': values}",
                "record",
            ),
            (
                role_name,
                f"the signal {role_name!r} has the name of a column. Rename the signal",
                "record",
            ),
            (
                self.injected is not None and self.injected_at not in INJECTION_POINTS,
                f"the injection point of the test signal is {self.injected_at!r}. Set "
                'injected_at = "control" or injected_at = "reference" in run.toml',
                "test-signal",
            ),
            before=f"{self._name()}: ",
        )
        if no_position:
            settle(self, position=np.empty(0), integrated=True)

    def _integral(self) -> Array:
        """Return the position as the integral of the velocity by trapezoids, m or rad, (N,).

        The position of each segment starts at its first reference, or at 0 without a reference.
        """
        velocity, position = np.asarray(self.velocity), np.zeros(len(self))
        for start, stop in self.spans:
            steps = self.period * (velocity[start + 1 : stop] + velocity[start : stop - 1]) / 2
            position[start + 1 : stop] = np.cumsum(steps)
            if self.commanded is not None:
                position[start:stop] += self.commanded[start]
        return position


def check_record(record: object) -> None:
    """Refuse an argument that is not a `Record`, such as the name of a file."""
    if not isinstance(record, Record):
        raise UsageError(
            f"the record is {quoted(record)}. Read a record with read_record(path, axis).",
            code="record",
        )


def record_labels(records: Sequence[Record]) -> tuple[str, ...]:
    """Return names of several records: their files, with a number if files have equal names."""
    sources = [record.provenance.source for record in records]
    return tuple(
        source if sources.count(source) == 1 else f"{source} (record {i})"
        for i, source in enumerate(sources, 1)
    )


def checked_column(source: str, role: str, values: ArrayLike) -> Array:
    """Return a column as a read-only array of finite numbers, (N,).

    Raises
    ------
    DataError
        The values are not numeric, have another shape, or are not finite or too large.
    """
    column = frozen(real_array(values, f"{source}: the {role}", DataError))
    if column.ndim != 1:
        raise DataError(
            f"{source}: the {role} has the shape {column.shape}. Give a one-dimensional array.",
            code="record",
        )
    largest = LARGEST_VALUE.value
    bad = np.flatnonzero(~(np.abs(column) <= largest))
    if bad.size:
        raise DataError(
            f"{source}: the {role} is {column[bad[0]]:g} in data row {bad[0] + 1}. Values must be "
            f"finite and at most {largest:g}, but {bad.size} of {len(column)} rows have other "
            "values. Remove these rows, or repair the log.",
            code="not-finite",
        )
    return column


def check_lengths(source: str, channels: Mapping[str, Array]) -> None:
    """Refuse columns of different lengths, or with fewer rows than a record needs."""
    lengths = {role: len(values) for role, values in channels.items()}
    listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
    fewest = MIN_RECORD_SAMPLES.value
    refuse(
        DataError,
        (
            len({*lengths.values()}) > 1,
            f"the columns differ in length: {listed}. Give one value per time in each column",
            "record",
        ),
        (
            lengths["time"] < fewest,
            f"the record has {lengths['time']} rows. Give at least {fewest} rows",
            "too-short",
        ),
        before=f"{source}: ",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherPeriod(Finding):
    """A log that is sampled with another period than the control law.

    Attributes
    ----------
    period : float
        Sampling period of the log, s.
    law_period : float
        Period of the control law, s.
    kept : int or None
        Number of periods of the law in one period of the log; None if it is not a whole number.
    is_given : bool
        True if the user gave the period of a log without times, so that nothing confirms it.
    """

    period: float
    law_period: float
    kept: int | None
    is_given: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LawClock:
    """Sampling period of a record relative to the period of the control law of its axis.

    Attributes
    ----------
    ratio : float or None
        Number of evaluations of the law per sample: 1 for equal clocks, for a continuous law, and
        without a law. None if the periods differ without a confirmation, or because the record was
        resampled.
    resampled : bool
        True if the record has other samples than its log.
    other : OtherPeriod or None
        The finding that the log has another period than the law, if nothing confirms the
        difference; None otherwise.
    confirmed : str
        Text on the different periods, if the user or the law confirms them; otherwise empty.
    """

    ratio: float | None
    resampled: bool
    other: OtherPeriod | None = None
    confirmed: str = ""

    @property
    def doubt(self) -> str:
        """Warning that log and control law have different sampling periods, with a remedy.

        Empty if the periods are equal, or if the user or the law confirms the difference.
        """
        return "" if self.other is None else self.other.sentence

    @property
    def hold_delay(self) -> float:
        """Mean delay of a control that the drive holds for a period of the law, in samples.

        It is half of that period, at most half a sample.
        """
        return 0.5 / max(self.ratio or 1.0, 1.0)


def is_same_period(one: float, other: float, uncertainty: float = 0.0) -> bool:
    """Return True if two sampling periods are the same, up to a relative uncertainty."""
    return abs(one / other - 1) <= 5e-4 + uncertainty  # ten times the tolerance of quartz crystals


def law_clock(law: ControlLaw | None, record: Record) -> LawClock:
    """Return the sampling period of a record relative to the control law, see `LawClock`.

    `law` is None for an axis without a declared control law.

    Different periods are confirmed by a given `Record.sample_period`, or by a law that declares the
    interpolation of its reference between the samples of a log. Without a confirmation,
    `LawClock.other` reports the difference.
    """
    period, clock = record.period, record.provenance.clock
    stated = record.sample_period is not None and (clock is None or clock.stated)
    if clock is None:  # a record of arrays has its own times
        uncertainty = 0.0
        if not stated:
            pieces = [record.time[start:stop] for start, stop in record.spans]
            uncertainty = period_uncertainty(pieces)
        clock = PeriodSource(uncertainty=uncertainty)
    # The period of the log, from which the period of a resampled record may differ.
    logged, resampled = clock.step * period, clock.step != 1
    if law is None or law.continuous:
        return LawClock(ratio=1.0, resampled=resampled)
    jitter = 0.0 if resampled else clock.uncertainty
    ratio = 1.0 if is_same_period(period, law.period, jitter) else None
    if is_same_period(logged, law.period, clock.uncertainty):
        return LawClock(ratio=ratio, resampled=resampled)
    sentence = (
        f"the record is sampled every {logged:.6g} s, and the control law runs every "
        f"{law.period:.6g} s"
    )
    if law.reference_between or (stated and not clock.counted):
        confirming = "the declaration" if law.reference_between else "sample_period"
        return LawClock(
            ratio=ratio if resampled else period / law.period,
            resampled=resampled,
            confirmed=f"{sentence}, which {confirming} confirms",
        )
    # Not confirmed: a log may have every n-th sample of the law.
    count = round(logged / law.period)
    decimated = 2 <= count <= 1000 and is_same_period(logged / law.period, count)
    other = OtherPeriod(
        period=float(logged),
        law_period=float(law.period),
        kept=count if decimated else None,
        is_given=clock.counted,
    )
    return LawClock(ratio=ratio, resampled=resampled, other=other)
