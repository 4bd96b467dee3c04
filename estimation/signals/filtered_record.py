"""A record under a filter: what the filter leaves open is chosen, what it cannot serve refused."""

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

from .drive_response import DriveReplay, acting_control
from .prefilter import Prefilter, SampledFilter, Span
from .sample_selection import Sampling
from .signals import (
    Motion,
    Signals,
    columns_by_signal,
    columns_of,
    hold_mean,
    loss_counts_for,
    recorded_signals,
    remaining_information,
    resting,
    searches_friction,
)


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class FilteredRecord(Exact, Uncached):
    """A record of an axis under a prefilter, filtered once.

    Attributes
    ----------
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
        With the hold and the reversals that `bind` chose where they were left open.
    excluded : tuple of (int, int)
        Samples near reversals and rests that have no weight.
    fastest : float
        Largest filtered speed of the records beside it, of the same machine; 0 for one by itself.
        What is slow beside that is a rest in each of them, as in each segment of a record.
    between : (N,) array or None
        By how much the mean of the control until the next sample is more than that at each, where
        the law is evaluated between them.
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
        """Choose what the prefilter leaves open, for a record of an axis.

        Parameters
        ----------
        axis : GeneratedAxis
        record : Record
        prefilter : Prefilter
        fastest : float
            Of the records beside it, see `FilteredRecord`.

        Raises
        ------
        UsageError, DataError
            The prefilter cannot serve the record, see `SampledFilter.check`, or the axis needs a
            position that was not recorded.
        """
        check_position(axis, record)
        prefilter, law = Prefilter.given(prefilter).at_rate_of(record.period), axis.control
        # What is there after a lag is measured, as a force is.
        measured = record.force is not None or axis.drive.logged == "current"
        is_held = not measured and not (law is not None and law.continuous)
        hold = prefilter.hold or ("zoh" if is_held else "raw")
        settings = replace(prefilter, hold=hold, reversals="keep")
        kept = cls(axis=axis, record=record, prefilter=settings, fastest=fastest)
        what = "the record's longest segment" if record.segments else "the record"
        kept.sampling.filter.check(max(stop - start for start, stop in record.spans), what)
        if prefilter.reversals == "keep" or not (prefilter.reversals or axis.has_direction):
            return kept
        without_turns = kept.without(kept.sampling.turns(kept.motion[1], fastest))
        asked = prefilter.reversals is None and not searches_friction(axis)
        return kept if asked and show_too_little([without_turns]) else without_turns

    def turning_as(self, position: Array, *, also: bool = False) -> "FilteredRecord":
        """Without the samples near the reversals and rests of another motion, (N,).

        Or without those too, where those of its own are left out.
        """
        if also and self.prefilter.reversals == "keep":
            return self
        turns = self.sampling.turns(self.sampling.motion(position)[1], self.fastest)
        return self.without((*self.excluded, *turns) if also else turns)

    @property
    def by_position(self) -> "FilteredRecord | None":
        """The record without what else of its motion was measured; None where there is nothing."""
        record = self.record
        if record.integrated or record.motion == ("position",):
            return None
        return replace(self, record=replace(record, velocity=None, acceleration=None))

    def with_columns(self, **columns: Array) -> "FilteredRecord":
        """As a record of the same samples with other columns, such as a twin, is filtered."""
        return self._changed(("sampling",), record=self.record.with_values(**columns))

    def with_mean_control(self, between: Array | None) -> "FilteredRecord":
        """The record with what its control is more in the mean than at the samples, (N,)."""
        if between is None or self.record.force is not None or self.prefilter.hold != "zoh":
            return self
        return self._changed(("motion",), between=between)

    def without(self, excluded: tuple[Span, ...]) -> "FilteredRecord":
        """The record with other samples that have no weight."""
        settings = replace(self.prefilter, reversals="leave-out" if excluded else "keep")
        same = ("motion", "force", "signals")  # whatever is left out of the rows
        return self._changed(same, prefilter=settings, excluded=tuple(sorted(excluded)))

    def _changed(self, same: tuple[str, ...], **fields: Any) -> "FilteredRecord":
        """With other fields, on which what is the same does not depend."""
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
        """Time between rows that follow each other, s."""
        return self.period * self.prefilter.decimate

    @property
    def hold_delay(self) -> float:
        """Samples by which the prefilter takes the force earlier, for the drive that holds it."""
        if self.prefilter.hold != "zoh":
            return 0.0
        if self.between is not None:
            return 0.5
        return law_clock(self.axis.control, self.record).hold_delay

    @cached_property
    def sampling(self) -> Sampling:
        """Which samples count, and which rows they make."""
        # An axis that is compiled, or was before: the filter alone is no reason to compile.
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
        """Filtered position, velocity and acceleration, each (N,)."""
        record = self.record
        return self.sampling.motion(record.position, record.velocity, record.acceleration)

    @cached_property
    def recorded(self) -> tuple[Array, ...]:
        """The signals that the axis declares, in its order, as they were recorded, (N,) each."""
        return recorded_signals(self.axis, self.record.provenance.source, dict(self.record.signals))

    @cached_property
    def force(self) -> Array:
        """Sample by sample, (N,): measured, or what the drive makes of the control."""
        record = self.record
        if record.force is not None:
            return record.force
        control = self.acting_control
        if control is None:
            raise DataError(
                f"{record.provenance.source} has neither a force nor a control column; name one "
                "with columns force=NAME or columns control=NAME.",
                code="missing-column",
            )
        return self.drive.force(control, self.motion, self.recorded)

    @cached_property
    def signals(self) -> Signals:
        """Filtered motion beside the force, aligned as the prefilter says."""
        return self.beside(self.force)

    @property
    def _starts(self) -> list[int]:
        return [start for start, _ in self.record.spans]

    @cached_property
    def acting_control(self) -> Array | None:
        """What the drive makes its force of: the mean until the next sample where that is known."""
        control = self.record.control
        if control is None:
            return None
        acting = acting_control(self.axis, control, self._starts, self.period)
        return acting if self.between is None else acting + self.between

    @cached_property
    def force_by_gain(self) -> Array:
        """Slope of the signals' force by the logarithm of the drive gain, (N,); 0 if measured."""
        control = self.acting_control
        if self.record.force is not None or control is None:
            return np.zeros(len(self))
        if self.axis.drive.is_gain:
            return self.signals.force
        return self.beside(
            self.drive.force(control, self.motion, self.recorded, by_gain=True)
        ).force

    def force_by(self, added: Array) -> Array:
        """What the signals' force has of something that is added to the control, (N,)."""
        control = np.zeros(len(self)) if self.acting_control is None else self.acting_control
        with_it, without = (
            self.drive.force(each, self.motion, self.recorded)
            for each in (control + added, control)
        )
        return self.beside(with_it - without).force

    @property
    def times_of_rows(self) -> Array:
        """When the rows are, since the first sample, s, (n,)."""
        time = self.record.time
        return np.asarray(time[self.sampling.rows.astype(int)] - time[0], dtype=float)

    @property
    def rows_near_turns(self) -> NDArray[np.bool_]:
        """Which rows are near a reversal or a rest of the measured motion, (n,), if friction is."""
        rows = self.sampling.rows.astype(np.int64)
        if not self.axis.has_direction:
            return np.zeros(len(rows), dtype=bool)
        turns = self.sampling.turns(self.motion[1], self.fastest)
        return np.asarray(mask_of(turns, len(self))[rows], dtype=bool)

    @cached_property
    def rest(self) -> float:
        """Part of the samples of a fit at which the axis stands still."""
        return resting(self.signals, self.sampling.used, self.fastest)

    def reduce(self, columns: Array) -> Array:
        """Rows of signals, (N,) or (N, k) to (n,) or (n, k), see `Sampling.reduce`."""
        return self.sampling.reduce(columns)

    @property
    def drive(self) -> DriveReplay:
        """The drive along the record's motion, as the hold pairs the two."""
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
        """The filtered motion beside a force as the hold pairs them."""
        q, velocity, acceleration = self.motion
        starts, delay = self._starts, self.hold_delay
        return Signals(
            position=q,
            velocity=velocity,
            acceleration=acceleration,
            force=hold_mean(force, starts, delay) if delay else force,
            direction=np.sign(velocity),
            recorded=tuple(
                hold_mean(values, starts) if signal.is_held else values
                for signal, values in zip(self.axis.signals, self.recorded, strict=True)
            ),
        )


def show_too_little(records: Sequence[FilteredRecord], into: Sequence[Array] = ()) -> bool:
    """Whether records without reversals and rests hardly show a parameter.

    Parameters
    ----------
    records : sequence of FilteredRecord
    into : sequence of (p, P) array
        What makes each one's parameters of those of all; none where all have the same.
    """
    into = into or [np.eye(len(each.axis.parameters)) for each in records]
    pairs = [*zip(records, into, strict=True)]
    fastest = max(max(float(np.abs(each.motion[1]).max()), each.fastest) for each in records)
    counts = np.any([loss_counts_for(d.axis) @ np.abs(m) > 0 for d, m in pairs], axis=0)
    information = []
    for each, transform in pairs:
        signals = each.beside(np.zeros(len(each)))  # the regressor is of the motion alone
        columns = columns_of(each.axis, signals) @ transform
        moves = np.abs(signals.velocity) > MIN_MOVING_SPEED.value * fastest
        parts = columns[each.sampling.kept & moves], columns[each.sampling.used]
        information.append([part.T @ part for part in parts])
    moving, used = np.sum(information, axis=0)
    return remaining_information(counts, moving, used) < MIN_INFORMATION_LEFT.value


#: What may depend on the position: function, its output, the position's place among its inputs.
_TAKING_POSITION = (
    ("the known terms", "idm_regressor", 1, 0),
    ("the force of the drive", "drive_force", 0, 1),
)


def check_position(axis: GeneratedAxis, record: Record) -> None:
    """Refuse a record of velocity alone for an axis whose model needs the position.

    Raises
    ------
    DataError
        It does; what depends on the position is named.
    """
    if not record.integrated:
        return
    columns = columns_by_signal(axis)["position"]
    needing = [name for name, needs in zip(axis.names, columns, strict=True) if needs]
    needing += [
        what
        for what, function, output, place in _TAKING_POSITION
        if np.any(axis.functions[function].jac_sparsity(output, place).nnz())
    ]
    if needing:
        raise DataError(
            f"{record.provenance.source} has no position, on which {' and '.join(needing)} of "
            f"axis {axis.name!r} depend{'s' * (len(needing) == 1)}; the integral of a "
            "measured velocity drifts. Name it with columns position=NAME.",
            code="missing-column",
        )
