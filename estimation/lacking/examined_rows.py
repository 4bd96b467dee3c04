"""The rows on which what a model lacks is looked for, and score tests on them.

Where the loop can be simulated they are all rows in motion, those near reversals among them: what
the same filter leaves of the noise-free loop is taken off, rounding of friction included, and terms
are those of its motion, so that no noise is in them. Elsewhere they are the rows of the estimate
away from reversals, with the measured motion.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import noise_free_record
from axisid.estimation.regression import Equations, recorded_loops
from axisid.estimation.signals import FilteredRecord, Neighbours, Sampling, Signals, Span
from axisid.estimation.thresholds.estimates import MAX_STARTING_SPEED
from axisid.estimation.thresholds.lacking import MIN_REST_OF_LOOP, MIN_ROWS_TO_LOOK
from axisid.estimation.twins import twins_of
from axisid.support.arrays import Array, covered, runs
from axisid.support.errors import AxisidError
from axisid.support.missing import Missing

from .terms import Along

_TWINS = 10


@dataclass(frozen=True, kw_only=True)
class ExaminedRows:
    """Rows of the inverse model on which what it lacks is looked for.

    Attributes
    ----------
    residuals : (n,) array
        Less what the estimator leaves of its loop, where that is known.
    left : (n,) array
        The force.
    regressor : (n, k) array
        Of the noise-free loop, or measured; without the force that is constant.
    weights : (n,) array
        What each row makes of 1.
    signals, measured : Signals
        Motion of which the terms are made, and as it was measured, at every sample.
    sampling : Sampling
        Which samples make the rows.
    times : (n,) array
        Of the rows since the record's first sample, s.
    by_loop : bool
        Whether the motion is the noise-free loop's.
    """

    residuals: Array
    left: Array
    regressor: Array
    weights: Array
    signals: Signals
    measured: Signals
    sampling: Sampling
    times: Array
    by_loop: bool

    @property
    def neighbours(self) -> Neighbours:
        """Which of the rows follow each other in time."""
        return self.sampling.neighbours

    @property
    def samples(self) -> NDArray[np.int64]:
        """Of the rows, (n,)."""
        return self.sampling.rows.astype(np.int64)

    @cached_property
    def along(self) -> Along:
        """The motion of which the terms are made."""
        return self._along(self.signals, 0.0 if self.by_loop else self.sampling.prefilter.cutoff)

    @cached_property
    def measured_along(self) -> Along:
        """The motion that was measured."""
        return self._along(self.measured, self.sampling.prefilter.cutoff)

    def _along(self, s: Signals, noisy_below: float) -> Along:
        sampling, rows = self.sampling, self.samples
        return Along(
            time=np.asarray(sampling.period * np.arange(len(s.position)), dtype=float),
            position=s.position - s.position[rows].mean(),
            velocity=s.velocity,
            acceleration=s.acceleration,
            direction=s.direction,
            force=s.force,
            spans=sampling.spans,
            rows=rows,
            reduce=sampling.reduce,
            row_period=sampling.period * sampling.prefilter.decimate,
            noisy_below=noisy_below,
        )


def examined(data: FilteredRecord, preferred: Estimate) -> ExaminedRows | Missing:
    """The rows of a record on which what the judged estimate lacks is looked for."""
    if preferred.ddm_quantities:
        return Missing("the rows of a direct model are accelerations")
    if preferred.noise_free is not None:
        try:
            return _by_loop(data, preferred)
        except AxisidError as error:
            return Missing.of(error.note)
    sampling = data.sampling
    if data.axis.has_direction:
        turns = sampling.turns(data.motion[1])
        sampling = replace(sampling, excluded=_joined((*sampling.excluded, *turns), len(data)))
    every = preferred.form.equations(data.signals)
    left = _left_by(every, preferred)
    return _rows(every, left, data.signals, sampling, data, by_loop=False)


def _by_loop(data: FilteredRecord, preferred: Estimate) -> ExaminedRows | Missing:
    # What the filter moves the estimate by is no lack of the model.
    loops = recorded_loops(data, preferred.corrected)
    quiet = noise_free_record(data, loops)
    form = preferred.form
    measured, clean = form.equations(data.signals), form.equations(quiet.signals)
    stuck = np.concatenate([loop.mode == 0 for loop in loops])
    velocity = np.concatenate([loop.velocity for loop in loops])
    apart = np.abs(data.signals.velocity - velocity)
    excluded = _joined((*_rests(stuck, data), *_starts(apart, data)), len(data))
    sampling = replace(data.sampling, excluded=excluded)
    moved = Signals(
        position=quiet.record.position,
        velocity=velocity,
        acceleration=np.concatenate([loop.acceleration for loop in loops]),
        force=np.concatenate([loop.force for loop in loops]),
        direction=np.concatenate([loop.direction for loop in loops]),
        recorded=data.recorded,
    )
    net = _left_by(measured, preferred) - _left_by(clean, preferred)
    every = replace(clean, left=measured.left)
    return _rows(every, net, moved, sampling, data, by_loop=True)


def examined_again(data: FilteredRecord, preferred: Estimate) -> Iterator[ExaminedRows]:
    """The same rows of twins, which lack nothing; none without."""
    for chain in preferred.inference.chains:
        for record in twins_of(data, preferred.corrected, chain, _TWINS):
            with suppress(AxisidError):
                found = _by_loop(record, preferred)
                if not isinstance(found, Missing):
                    yield found


def _rows(
    every: Equations,
    residuals: Array,
    signals: Signals,
    sampling: Sampling,
    data: FilteredRecord,
    *,
    by_loop: bool,
) -> ExaminedRows | Missing:
    n, k = len(sampling.rows), every.regressor.shape[1]
    if n < MIN_ROWS_TO_LOOK.value * (k + 1):
        return Missing(f"{n} rows in motion are too few to tell what is missing")
    times = data.record.time
    reduced = sampling.reduce(np.column_stack([residuals, every.left, every.regressor]))
    return ExaminedRows(
        residuals=reduced[:, 0],
        left=reduced[:, 1],
        regressor=reduced[:, 2:],
        weights=sampling.weights,
        signals=signals,
        measured=data.signals,
        sampling=sampling,
        times=times[sampling.rows.astype(int)] - times[0],
        by_loop=by_loop,
    )


def _left_by(every: Equations, preferred: Estimate) -> Array:
    """What the model leaves; of an output error the force, less the loop's in what is netted."""
    if preferred.by_output_error:
        return every.left
    return every.left - every.intercept - every.regressor @ preferred.theta


def _rests(stuck: NDArray[np.bool_], data: FilteredRecord) -> tuple[Span, ...]:
    """Where the loop rests, and as far around as the low-pass reaches; not where it turns."""
    reach, n = data.sampling.filter.turn_reach, len(stuck)
    least = max(int(MIN_REST_OF_LOOP.value * reach), 1)
    rests = [(a, b) for a, b in runs(stuck) if b - a > least]
    return tuple((max(a - reach, 0), min(b + reach, n)) for a, b in rests)


def _starts(apart: Array, data: FilteredRecord) -> tuple[Span, ...]:
    """Where a loop has not caught up with a segment that it does not begin like."""
    reach = 2 * data.sampling.filter.turn_reach
    most = MAX_STARTING_SPEED.value * float(np.abs(data.signals.velocity).max())
    found = []
    for first, last in data.record.spans:
        far = apart[first:last] > most
        if far[: min(reach, len(far))].any():
            caught_up = int(np.argmin(far[int(np.argmax(far)) :])) + int(np.argmax(far))
            found.append((first, min(first + caught_up + reach, last)))
    return tuple(found)


def _joined(spans: Sequence[Span], samples: int) -> tuple[Span, ...]:
    """Spans in order, those that touch as one."""
    return runs(covered(spans, samples))
