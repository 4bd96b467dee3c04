"""The clocks of a record and its law: when that is evaluated along a log, and with what."""

import math
import weakref
from collections.abc import Hashable
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record, at_times, clock_of, evaluations_per_sample
from axisid.estimation.signals import Prefilter, SampledFilter, recorded_signals
from axisid.estimation.simulation import TwoClocks, at_law, law_of
from axisid.estimation.thresholds import COMPARISON_CUTOFF, MIN_PHASE_AGREEMENT
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class RecordCache(Generic[K, V]):
    """What is known of records that are alive, by their identity, asked for in every iteration."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[weakref.ref[Record], dict[K, V]]] = {}

    def of(self, record: Record) -> dict[K, V]:
        """What is known of a record, to be added to."""
        found = self._known.get(id(record))
        if found is None:
            alive = weakref.ref(record, partial(self._forget, id(record)))
            found = self._known[id(record)] = (alive, {})
        return found[1]

    def __len__(self) -> int:
        return len(self._known)

    def _forget(self, record: int, _: object) -> None:
        self._known.pop(record, None)


#: With the reference that they took to the law's evaluations.
_KNOWN: RecordCache[tuple[GeneratedAxis, tuple[int, int]], TwoClocks | None] = RecordCache()


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
    known = _KNOWN.of(record)
    if (axis, span) not in known:
        known[axis, span] = _two_clocks(axis, record, span)
    return known[axis, span]


def _two_clocks(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> TwoClocks | None:
    law = law_of(axis)
    ratio = evaluations_per_sample(law, record.period, clock_of(record)) or 1.0
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
class LawTicks:
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
    def signals(self) -> list[Array]:
        """What a law's function reads before its memory, (1, M) each."""
        read = (self.reference, self.position, self.velocity, *self.recorded)
        return [values[None, :] for values in read]

    @classmethod
    def at_samples(
        cls,
        reference: Array,
        position: Array,
        velocity: Array,
        recorded: tuple[Array, ...] = (),
        added: Array | None = None,
    ) -> "LawTicks":
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

    def first(self, samples: int) -> "LawTicks":
        """Those of the first samples of the log."""
        held = self.held[:samples]
        until = int(held[-1]) + 1
        return LawTicks(
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


def law_ticks(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], *, noisy: bool = False
) -> LawTicks:
    """What the law of an axis measured along a segment of a record with a reference.

    An ideal velocity is of the low-passed positions, or noisy, of all that is in them: for what
    goes through that low-pass itself, twice through which is late where the motion has corners.
    """
    law, rows = law_of(axis), slice(*span)
    reference, position = np.asarray(record.commanded)[rows], record.position[rows]
    velocity = _velocity(law, position, record.period, noisy=noisy)
    added = record.added_control
    added = np.zeros(len(position)) if added is None else added[rows]
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    recorded = tuple(values[rows] for values in signals)
    clocks = two_clocks(axis, record, span)
    if clocks is None:
        held = np.arange(len(position))
    else:
        reference, added, held = clocks.reference(reference), clocks.held(added), clocks.elapsed[0]
        position, velocity = (
            at_times(clocks.times, np.arange(float(len(values))), values, "spline")
            for values in (position, velocity)
        )
        recorded = at_law(axis, recorded, clocks)
    return LawTicks(
        reference=reference,
        position=position,
        velocity=velocity,
        added=added,
        held=held,
        recorded=recorded,
    )


def _velocity(law: ControlLaw, position: Array, period: float, *, noisy: bool) -> Array:
    """What an ideal sensor sees, of a law that reads one; it is in no log."""
    if not law.takes_velocity:
        return np.zeros_like(position)
    if not noisy:
        return measured_velocity(position, period)
    from scipy.interpolate import CubicSpline

    samples = np.arange(len(position))
    return np.asarray(CubicSpline(samples, position)(samples, 1)) / period


def measured_velocity(position: Array, period: float) -> Array:
    """Velocity of recorded positions by a low-pass without a delay, (N,)."""
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / period)
    return SampledFilter(low_pass, period).motion(position)[1]
