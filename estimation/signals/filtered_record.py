"""Record of an axis with its prefilter.

Settings of the prefilter that the user left open are chosen, and unsuitable records are refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.records import Record, law_clock
from axisid.estimation.thresholds import MIN_INFORMATION_LEFT, MIN_MOVING_SPEED
from axisid.support.arrays import Array, Exact, Uncached, mask_of
from axisid.support.errors import DataError
from axisid.support.settings import setting

from .drive_response import DriveReplay, acting_control
from .information import (
    columns_by_signal,
    columns_of,
    has_nonlinear_speed_friction,
    is_speed_friction,
    remaining_information,
)
from .motion import resting
from .prefilter import Prefilter, SampledFilter, Span
from .sample_selection import Sampling
from .signals import Motion, Signals, hold_mean, recorded_signals


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class FilteredRecord(Exact, Uncached):
    """Record of an axis with a prefilter; filtered signals are computed once.

    Attributes
    ----------
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
        Settings of the filter; `bind` chooses the hold and the treatment of reversals if the user
        left them open.
    excluded : tuple of (int, int)
        Samples near reversals and rests that have no weight.
    fastest : float
        Largest filtered speed of other records of the same machine, m/s or rad/s; 0 without other
        records. The speed below which an axis is at rest is relative to the largest speed of all
        records.
    between : (N,) array or None
        Mean of the control until the next sample minus the control at the sample, in the drive's
        unit, if the law is evaluated between samples; None otherwise.
    """

    axis: GeneratedAxis
    record: Record
    prefilter: Prefilter
    excluded: tuple[Span, ...] = ()
    fastest: float = 0.0
    between: Array | None = None

    @classmethod
    def bind(
        cls, axis: GeneratedAxis, record: Record, prefilter: Prefilter, fastest: float = 0.0
    ) -> "FilteredRecord":
        """Return the filtered record, with the open settings of the prefilter chosen.

        Parameters
        ----------
        axis : GeneratedAxis
        record : Record
        prefilter : Prefilter
            Settings, of which cut-off, decimation, hold and treatment of reversals may be open.
        fastest : float
            Largest speed of other records, see `FilteredRecord`.

        Raises
        ------
        UsageError, DataError
            The prefilter does not suit the record, see `SampledFilter.check`, or the axis needs a
            position that was not recorded.
        """
        check_position(axis, record)
        prefilter, law = Prefilter.given(prefilter).at_rate_of(record.period), axis.control
        # Hold. A control logged after the lag is continuous, as a measured force is.
        measured = record.force is not None or axis.drive.logged == "current"
        is_held = not measured and not (law is not None and law.continuous)
        hold = prefilter.hold or ("zoh" if is_held else "raw")
        settings = replace(prefilter, hold=hold, reversals="keep")
        kept = cls(axis=axis, record=record, prefilter=settings, fastest=fastest)
        what = "the record's longest segment" if record.segments else "the record"
        kept.sampling.filter.check(max(stop - start for start, stop in record.spans), what)
        # Reversals are left out, unless too little information remains and the user left it open.
        if prefilter.reversals == "keep" or not (prefilter.reversals or axis.has_direction):
            return kept
        without_turns = kept.without(kept.sampling.turns(kept.motion[1], fastest))
        is_open = prefilter.reversals is None and not has_nonlinear_speed_friction(axis)
        if is_open and show_too_little([without_turns]):
            return kept
        return without_turns

    def turning_as(self, position: Array, *, also: bool = False) -> "FilteredRecord":
        """Return the record without the samples near reversals and rests of another motion.

        Parameters
        ----------
        position : (N,) array
            Position of the other motion, such as a simulated motion, SI.
        also : bool
            True if the samples that are left out already stay left out. The record is then
            unchanged if the prefilter keeps reversals.
        """
        if also and self.prefilter.reversals == "keep":
            return self
        turns = self.sampling.turns(self.sampling.motion(position)[1], self.fastest)
        if also:
            turns = (*self.excluded, *turns)
        return self.without(turns)

    @property
    def by_position(self) -> "FilteredRecord | None":
        """The same record without measured velocity and acceleration.

        None if only the position is measured, or if the position is not measured.
        """
        record = self.record
        if record.integrated or record.motion == ("position",):
            return None
        return replace(self, record=replace(record, velocity=None, acceleration=None))

    def with_columns(self, **columns: Array) -> "FilteredRecord":
        """Return the record with other values of columns by role, such as a simulated replica.

        Each column has shape (N,).
        """
        return self._changed(("sampling",), record=self.record.with_values(**columns))

    def with_mean_control(self, between: Array | None) -> "FilteredRecord":
        """Return the record with a new value of the attribute `between`.

        The record is unchanged if `between` is None, if the force is measured, or without the hold
        ``zoh``.
        """
        if between is None or self.record.force is not None or self.prefilter.hold != "zoh":
            return self
        return self._changed(("motion",), between=between)

    def without(self, excluded: tuple[Span, ...]) -> "FilteredRecord":
        """Return the record in which the given samples have no weight.

        They replace the samples that have no weight now. `excluded` has the first sample and the
        one after the last of each piece.
        """
        settings = replace(self.prefilter, reversals="leave-out" if excluded else "keep")
        same = ("motion", "force", "signals")  # do not depend on the rows that are left out
        return self._changed(same, prefilter=settings, excluded=tuple(sorted(excluded)))

    def _changed(self, same: tuple[str, ...], **fields: Any) -> "FilteredRecord":
        """Return the record with new values of attributes.

        `same` are the names of cached properties that do not change, and whose values are kept.
        """
        other = replace(self, **fields)
        vars(other).update({name: vars(self)[name] for name in same if name in vars(self)})
        return other

    def __len__(self) -> int:
        return len(self.record)

    def __repr__(self) -> str:
        return f"{self.record!r} under {self.prefilter!r}"

    @property
    def period(self) -> float:
        """Sampling period, s."""
        return self.record.period

    @property
    def row_period(self) -> float:
        """Time between consecutive rows, s."""
        return self.period * self.prefilter.decimate

    @property
    def hold_delay(self) -> float:
        """Delay in samples of the force in the rows, as the drive holds its force over a period."""
        if self.prefilter.hold != "zoh":
            return 0.0
        if self.between is not None:
            return 0.5
        return law_clock(self.axis.control, self.record).hold_delay

    @cached_property
    def sampling(self) -> Sampling:
        """Selection of the samples, and the rows that they give."""
        # Uses compiled code if the axis is compiled already; a filter alone is not worth compiling.
        native = self.axis.native.evaluator("drive_force") is not None
        return Sampling(
            filter=SampledFilter(self.prefilter, self.period, native),
            samples=len(self.record),
            segments=self.record.segments,
            masked=self.record.masked,
            excluded=self.excluded,
        )

    @cached_property
    def motion(self) -> Motion:
        """Filtered position, velocity and acceleration, each (N,), SI."""
        record = self.record
        return self.sampling.motion(record.position, record.velocity, record.acceleration)

    @cached_property
    def recorded(self) -> tuple[Array, ...]:
        """Recorded signals in the order of the axis's declaration, unfiltered, (N,) each."""
        return recorded_signals(self.axis, self.record.provenance.source, dict(self.record.signals))

    @cached_property
    def force(self) -> Array:
        """Force at each sample, N or N m, (N,): measured, or computed from the control.

        Raises
        ------
        DataError
            The record has neither a force nor a control.
        """
        record = self.record
        if record.force is not None:
            return record.force
        control = self.acting_control
        if control is None:
            raise DataError(
                f"{record.provenance.source} has neither a force nor a control column. Name one of "
                f"these columns with {setting('columns', {'force': 'NAME'})} or "
                f"{setting('columns', {'control': 'NAME'})}.",
                code="missing-column",
            )
        return self.drive.force(control, self.motion, self.recorded)

    @cached_property
    def signals(self) -> Signals:
        """Filtered motion with the force, aligned by the prefilter's hold."""
        return self.beside(self.force)

    @property
    def _starts(self) -> list[int]:
        """First samples of the segments."""
        return [start for start, _ in self.record.spans]

    @cached_property
    def acting_control(self) -> Array | None:
        """Control that the drive's force follows, in the drive's unit, (N,).

        It is the mean from each sample to the next if `between` is known. None without a recorded
        control.
        """
        control = self.record.control
        if control is None:
            return None
        acting = acting_control(self.axis, control, self._starts, self.period)
        return acting if self.between is None else acting + self.between

    @cached_property
    def force_by_gain(self) -> Array:
        """Derivative of the force by the logarithm of the drive gain, (N,).

        It is 0 if the force was measured, or without a control.
        """
        control = self.acting_control
        if self.record.force is not None or control is None:
            return np.zeros(len(self))
        if self.axis.drive.is_gain:
            return self.signals.force
        slope = self.drive.force(control, self.motion, self.recorded, by_gain=True)
        return self.beside(slope).force

    def force_by(self, added: Array) -> Array:
        """Return the change of the force due to a signal added to the control, N or N m, (N,).

        `added` is in the drive's unit, (N,). Without a recorded control, a control of 0 is assumed.
        """
        control = self.acting_control
        if control is None:
            control = np.zeros(len(self))
        force_with = self.drive.force(control + added, self.motion, self.recorded)
        force_without = self.drive.force(control, self.motion, self.recorded)
        return self.beside(force_with - force_without).force

    @property
    def times_of_rows(self) -> Array:
        """Times of the rows from the first sample, s, (n,)."""
        time = self.record.time
        return np.asarray(time[self.sampling.rows.astype(int)] - time[0], dtype=float)

    @property
    def rows_near_turns(self) -> NDArray[np.bool_]:
        """True for rows near a reversal or rest of the measured motion, (n,).

        False for all rows of an axis whose force does not depend on the direction.
        """
        rows = self.sampling.rows.astype(np.int64)
        if not self.axis.has_direction:
            return np.zeros(len(rows), dtype=bool)
        turns = self.sampling.turns(self.motion[1], self.fastest)
        return np.asarray(mask_of(turns, len(self))[rows], dtype=bool)

    @cached_property
    def rest(self) -> float:
        """Share of the samples of a fit at which the axis is at standstill."""
        return resting(self.signals, self.sampling.used, self.fastest)

    def reduce(self, columns: Array) -> Array:
        """Return the filtered, decimated rows of signals, (n,) or (n, k), from (N,) or (N, k)."""
        return self.sampling.reduce(columns)

    @cached_property
    def drive(self) -> DriveReplay:
        """The drive along the record's motion, with the force aligned by the hold."""
        ratio = law_clock(self.axis.control, self.record).ratio or 1.0
        return DriveReplay(
            axis=self.axis,
            starts=self._starts,
            period=self.period,
            held=ratio <= 1 or self.between is not None,
            delay=self.hold_delay,
            mean=self.prefilter.hold == "zoh",
        )

    def beside(self, force: Array) -> Signals:
        """Return the filtered motion with a given force, (N,), which the hold aligns."""
        q, velocity, acceleration = self.motion
        starts, delay = self._starts, self.hold_delay
        if delay:
            force = hold_mean(force, starts, delay)
        recorded = []
        for signal, values in zip(self.axis.signals, self.recorded, strict=True):
            recorded.append(hold_mean(values, starts) if signal.is_held else values)
        return Signals(
            position=q,
            velocity=velocity,
            acceleration=acceleration,
            force=force,
            direction=np.sign(velocity),
            recorded=tuple(recorded),
        )


def show_too_little(records: Sequence[FilteredRecord], into: Sequence[Array] = ()) -> bool:
    """Return True if samples left out near reversals carry much information on a parameter.

    That is so if less than two thirds of the information on a parameter remain in all records
    together, see `remaining_information`.

    Parameters
    ----------
    records : sequence of FilteredRecord
        Records without the samples near reversals and rests.
    into : sequence of (p, P) array
        Matrix from the common parameters to those of each record; empty if they are equal.
    """
    into = into or [np.eye(len(each.axis.parameters)) for each in records]
    pairs = [*zip(records, into, strict=True)]
    fastest = max(max(float(np.abs(each.motion[1]).max()), each.fastest) for each in records)
    # Common parameters that are considered: those that affect a considered parameter of a record.
    counts = np.any([~is_speed_friction(d.axis) @ np.abs(m) > 0 for d, m in pairs], axis=0)
    # X'X of the samples in motion, and of the samples that are used.
    information = []
    for each, transform in pairs:
        signals = each.beside(np.zeros(len(each)))  # the regressor does not depend on the force
        columns = columns_of(each.axis, signals) @ transform
        moves = np.abs(signals.velocity) > MIN_MOVING_SPEED.value * fastest
        parts = columns[each.sampling.kept & moves], columns[each.sampling.used]
        information.append([part.T @ part for part in parts])
    moving, used = np.sum(information, axis=0)
    return remaining_information(counts, moving, used) < MIN_INFORMATION_LEFT.value


#: Terms that may depend on the position: name, function, index of its output, and index of the
#: position among its inputs.
_TERMS_OF_POSITION = (
    ("the known terms", "idm_regressor", 1, 0),
    ("the force of the drive", "drive_force", 0, 1),
)


def check_position(axis: GeneratedAxis, record: Record) -> None:
    """Refuse a record without a position for an axis whose model depends on the position.

    Raises
    ------
    DataError
        The model depends on the position; the message names the terms that do.
    """
    if not record.integrated:
        return
    columns = columns_by_signal(axis)["position"]
    needing = [name for name, needs in zip(axis.names, columns, strict=True) if needs]
    needing += [
        what
        for what, function, output, position in _TERMS_OF_POSITION
        if np.any(axis.functions[function].jac_sparsity(output, position).nnz())
    ]
    if needing:
        depend = "depends" if len(needing) == 1 else "depend"
        raise DataError(
            f"{record.provenance.source} has no position, but {' and '.join(needing)} of axis "
            f"{axis.name!r} {depend} on the position. The integral of a measured velocity drifts, "
            "so it cannot replace the position. Name the position with "
            f"{setting('columns', {'position': 'NAME'})}.",
            code="missing-column",
        )
