"""What a control law reads of a record: its signals, where it is evaluated."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record, at_times, law_clock
from axisid.estimation.signals import (
    Prefilter,
    SampledFilter,
    recorded_signals,
)
from axisid.estimation.simulation import LoopInputs, TwoClocks, law_of
from axisid.estimation.thresholds import COMPARISON_CUTOFF, MIN_PHASE_AGREEMENT
from axisid.support.arrays import Array
from axisid.support.caching import cached_while_alive


@cached_while_alive
def two_clocks(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> TwoClocks | None:
    """When the law is evaluated along a segment of a record; None at each of its samples.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
    span : tuple of int
        First row and the one after the last.
    """
    law = law_of(axis)
    ratio = law_clock(law, record).ratio or 1.0
    if ratio == 1.0:
        return None
    control = None if record.control is None else record.control[slice(*span)]
    late = 0.0 if ratio > 1 or control is None else _first_change(control, 1 / ratio)
    return TwoClocks(
        samples=span[1] - span[0],
        log_period=record.period,
        law_period=law.period,
        first=record.period * late,
        between=law.reference_between or "spline",
    )


def _first_change(control: Array, samples: float) -> float:
    """When a control that is held over so many samples was last changed before the first, samples.

    0 where it changes at no even distance.
    """
    changes = np.flatnonzero(np.diff(control)) + 1.0
    whole = math.isclose(samples, round(samples), rel_tol=1e-3)
    if not whole:
        changes -= 0.5  # it was somewhere in the step before
    turns = np.exp(2j * np.pi * changes / samples)
    mean = turns.mean() if len(turns) else 0.0
    if abs(mean) < MIN_PHASE_AGREEMENT.value:
        return 0.0
    phase = float(np.angle(mean)) / (2 * np.pi) % 1.0 * samples
    phase = round(phase) % round(samples) if whole else phase
    return phase - samples if phase > 0 else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LawInputs:
    """The signals that a law reads, where it is evaluated.

    Attributes
    ----------
    reference, position, velocity : (M,) array
        At the evaluations.
    added : (M,) array
        What is added to the law's output.
    recorded : tuple of (M,) array
        The recorded signals that the axis declares, in its order.
    held : (N,) array of int
        The evaluation at or before each sample of the log.
    """

    reference: Array
    position: Array
    velocity: Array
    added: Array
    held: NDArray[np.intp]
    recorded: tuple[Array, ...] = ()

    @property
    def signals(self) -> tuple[Array, ...]:
        """What a law's function reads before its memory, (M,) each."""
        return self.reference, self.position, self.velocity, *self.recorded

    @classmethod
    def at_samples(
        cls,
        reference: Array,
        position: Array,
        velocity: Array,
        recorded: tuple[Array, ...] = (),
        added: Array | None = None,
    ) -> "LawInputs":
        """A law that is evaluated at the samples of a log, (N,) each; nothing added by default."""
        return cls(
            reference=reference,
            position=position,
            velocity=velocity,
            added=np.zeros(len(position)) if added is None else added,
            held=np.arange(len(position)),
            recorded=recorded,
        )

    def __len__(self) -> int:
        return len(self.reference)

    def first(self, samples: int) -> "LawInputs":
        """Those of the first samples of the log."""
        held = self.held[:samples]
        until = int(held[-1]) + 1
        return LawInputs(
            reference=self.reference[:until],
            position=self.position[:until],
            velocity=self.velocity[:until],
            added=self.added[:until],
            held=held,
            recorded=tuple(values[:until] for values in self.recorded),
        )

    def added_at_samples(self, delay: int) -> Array:
        """What is added to the control that a sample of the log shows, so many evaluations late."""
        late = self.held - delay
        return np.where(late < 0, 0.0, self.added[np.maximum(late, 0)])


def recorded_inputs(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], start: LoopStart
) -> LoopInputs:
    """What the loop of a segment of a record with a reference is simulated from."""
    rows, added = slice(*span), record.added_control
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    return LoopInputs(
        reference=np.asarray(record.commanded)[rows],
        period=record.period,
        start=start,
        injected=None if added is None else added[rows],
        signals=tuple(values[rows] for values in signals),
    ).at_law(axis, two_clocks(axis, record, span))


def law_ticks(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], *, noisy: bool = False
) -> LawInputs:
    """What the law of an axis measured along a segment of a record with a reference.

    An ideal velocity is of the low-passed positions, or noisy, of all that is in them: for what
    goes through that low-pass itself, twice through which is late where the motion has corners.
    """
    position = record.position[slice(*span)]
    velocity = np.zeros_like(position)
    # What an ideal sensor sees, of a law that reads one; it is in no log.
    if law_of(axis).takes_velocity and noisy:
        from scipy.interpolate import CubicSpline

        samples = np.arange(len(position))
        velocity = np.asarray(CubicSpline(samples, position)(samples, 1)) / record.period
    elif law_of(axis).takes_velocity:
        velocity = measured_velocity(position, record.period)
    inputs = recorded_inputs(axis, record, span, LoopStart(position=position[0]))
    clocks, held = inputs.clocks, np.arange(len(position))
    if clocks is not None:
        rows, held = held.astype(float), clocks.elapsed[0]
        position, velocity = (
            at_times(clocks.times, rows, each, "spline") for each in (position, velocity)
        )
    return LawInputs(
        reference=inputs.reference,
        position=position,
        velocity=velocity,
        added=np.zeros(len(position)) if inputs.injected is None else inputs.injected,
        held=held,
        recorded=inputs.signals,
    )


def measured_velocity(position: Array, period: float) -> Array:
    """Velocity of recorded positions by a low-pass without a delay, (N,)."""
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / period)
    return SampledFilter(low_pass, period).motion(position)[1]
