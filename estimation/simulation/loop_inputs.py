"""Inputs of simulated loops, at the samples of a log or at the evaluations of a control law.

If their rates differ, the loop is simulated at the rate of the law and sampled at that of the log.
From the evaluation before a sample, the plant is integrated up to the sample as in the simulation
itself: under the held force, and through every stop, reversal and kink over the position.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopSettings, LoopStart
from axisid.codegen.runtime import VirtualLoop
from axisid.estimation.records import at_times, is_same_period
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, frozen
from axisid.support.errors import UsageError

# Largest ratio of the periods of law and reference: 20 kHz logged at 50 Hz. A period in ms would be
# 1000 times too long, and is refused.
_MAX_CLOCK_RATIO = 400.0
_COINCIDES = 1e-6  # of a period: a sample as near to an evaluation as this coincides with it
_FEWEST_OF_A_SPLINE = 4  # samples; fewer are interpolated linearly


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoClocks:
    """Times of the evaluations of a law along a log of another period.

    Attributes
    ----------
    samples : int
        Number of samples of the log.
    log_period, law_period : float
        Sampling period of the log, and period of the law, s.
    first : float
        Time of the first evaluation, s from the first sample; 0 or negative.
    between : str
        Interpolation of the reference between samples: ``spline``, ``linear`` or ``held``.
    """

    samples: int
    log_period: float
    law_period: float
    first: float = 0.0
    between: str = "spline"
    # Cache: the last reference, and its spline at the evaluations; empty at first.
    _smooth: list[tuple[Array, Array]] = field(
        init=False, default_factory=list, repr=False, compare=False
    )

    @property
    def times(self) -> Array:
        """Times of the M evaluations, in samples of the log.

        The last evaluation is the first after the last sample.
        """
        last = (self.samples - 1) * self.log_period - self.first
        count = math.floor(last / self.law_period + _COINCIDES) + 2
        return np.asarray((self.first + self.law_period * np.arange(count)) / self.log_period)

    @property
    def elapsed(self) -> tuple[NDArray[np.intp], Array]:
        """Index of the evaluation at or before each sample, and the time since then, s, (N,) each.

        The time is 0 for a sample that coincides with an evaluation.
        """
        time = self.log_period * np.arange(self.samples) - self.first
        last = np.floor(time / self.law_period + _COINCIDES).astype(np.intp)
        since = time - self.law_period * last
        return last, np.where(since > _COINCIDES * self.law_period, since, 0.0)

    def reference(self, values: Array) -> Array:
        """Return a reference of the log, (N,) or (N, B), at the evaluations, (M,) or (M, B).

        The last spline is cached, because a record's loop is simulated many times with one
        reference.
        """
        if self.between == "held":
            return self.held(values)
        if self.between == "linear" or len(values) < _FEWEST_OF_A_SPLINE:
            return straight(self.times, values)
        if not (self._smooth and np.array_equal(self._smooth[0][0], values)):
            smooth = at_times(self.times, np.arange(float(len(values))), values, "spline")
            self._smooth[:] = [(values.copy(), frozen(smooth))]
        return self._smooth[0][1]

    def mean_held(self, values: Array) -> Array:
        """Return the mean of a held signal from each evaluation to the next, (M,).

        The signal is held between the samples of the log. If the law is not slower than the log,
        the value at the evaluation is returned instead.
        """
        if self.law_period <= self.log_period:
            return self.held(values)
        # Integral of the signal up to each sample, and its increase between two evaluations.
        until = np.concatenate([0 * values[:1], np.cumsum(values, axis=0)])
        edges = np.append(self.times, self.times[-1] + self.law_period / self.log_period)
        inside = np.clip(edges, 0, len(values))
        integrals, spans = np.diff(straight(inside, until), axis=0), np.diff(inside)
        mean = self.held(values)  # constant beyond the end of the log
        mean[spans > 0] = (integrals[spans > 0].T / spans[spans > 0]).T
        return mean

    def held(self, values: Array) -> Array:
        """Return a signal held between samples of the log, at the evaluations, (M,)."""
        row = np.floor(self.times + _COINCIDES).astype(np.intp)
        return np.asarray(values[np.clip(row, 0, len(values) - 1)])


def straight(times: Array, values: Array) -> Array:
    """Return values at samples, (N, ...), interpolated linearly at M times, (M, ...).

    `times`, (M,), are in samples.
    """
    rows = np.arange(len(values))
    return np.asarray(np.apply_along_axis(lambda column: np.interp(times, rows, column), 0, values))


def clocks_of(law: ControlLaw, samples: int, period: float) -> TwoClocks | None:
    """Return the times of a law's evaluations along a reference, the first at the first sample.

    None for equal periods of law and reference, and for a continuous law.

    Parameters
    ----------
    law : ControlLaw
    samples : int
        Number of samples of the reference.
    period : float
        Period of the reference, s.

    Raises
    ------
    UsageError
        One period is more than 400 times as long as the other, and is probably in another unit.
    """
    if law.continuous or is_same_period(period, law.period):
        return None
    ratio, most = period / law.period, _MAX_CLOCK_RATIO
    if not 1 / most <= ratio <= most:
        raise UsageError(
            f"the sampling period is {period:g} s, but the control law is evaluated every "
            f"{law.period:g} s. The two periods may differ by a factor of at most {most:g}. Give "
            "the sampling period in seconds, or declare another period of the control law.",
            code="loop-period",
        )
    return TwoClocks(
        samples=samples,
        log_period=period,
        law_period=law.period,
        between=law.reference_between or "spline",
    )


def at_log_samples(
    axis: GeneratedAxis,
    parameters: Array,
    signals: dict[str, Array],
    clocks: TwoClocks,
    recorded: Sequence[Array],
    substeps: int,
) -> dict[str, Array]:
    """Return the signals of a loop at the samples of the log, from those at the law's evaluations.

    A sample at the time of an evaluation has the signals of the evaluation. For a sample between
    two evaluations, the plant is integrated from the earlier one under the held force.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    signals : dict of str to (M,) array
        Signals by the names of `SIGNALS`; NaN after an early end of the simulation.
    clocks : TwoClocks
        Times of the law's evaluations along the log.
    recorded : sequence of (M,) array
        The recorded signals of the axis's declaration, at the evaluations.
    substeps : int
        Steps of the simulation per evaluation.

    Returns
    -------
    dict of str to (N,) array
        The signals, and ``held``: the force just before a sample.

    Raises
    ------
    UsageError
        Friction has internal state, and a sample is between two evaluations.
    """
    last, since = clocks.elapsed
    force = signals["force"]
    earlier = np.concatenate([force[:1], force[:-1]])
    out = {name: values[last] for name, values in signals.items()}
    out["held"] = np.where(since > 0, force[last], earlier[last])
    between_ticks = np.flatnonzero(since > 0)
    if not between_ticks.size:
        return out
    if axis.states:
        raise UsageError(
            f"the log of axis {axis.name!r} has samples between the evaluations of the control "
            "law, where the internal state of the friction is not known. Give the period of the "
            "control law, or a whole multiple of this period.",
            code="loop-period",
        )
    # The evaluation before each of these samples, the time since, s, and the values held.
    begin, span = last[between_ticks], since[between_ticks]
    recorded_lines = lines(axis, recorded, clocks.law_period)
    between = np.zeros((len(force), 0)) if recorded_lines is None else recorded_lines
    motion = signals["position"][begin], signals["velocity"][begin]
    held, step = np.column_stack([force, between])[begin], clocks.law_period / substeps
    library = axis.native.library()
    if library is not None:
        position, velocity, direction = library.later(motion, held, span, step, parameters)
    else:
        settings = LoopSettings(period=step, resolution=0.0, allowed=np.inf, substeps=1)
        loop = VirtualLoop(axis.functions, parameters, settings)
        position, velocity, direction = loop.later(motion, held, span, step)
    # The acceleration with the recorded signals at the sample; 0 while the axis sticks.
    signals_then = between[begin, ::2] + span[:, None] * between[begin, 1::2]
    (acceleration,) = axis.evaluate(
        "direct_dynamics", position, velocity, force[begin], direction, *signals_then.T, parameters
    )
    sticks = (velocity == 0) & (np.abs(direction) < 1)
    out["position"][between_ticks], out["velocity"][between_ticks] = position, velocity
    out["direction"][between_ticks] = out["direction_before"][between_ticks] = direction
    out["acceleration"][between_ticks] = np.where(sticks, 0.0, acceleration[:, 0])
    return out


def lines(axis: GeneratedAxis, signals: Sequence[Array], period: float) -> Array | None:
    """Return value and rate of change of each of s signals at each sample, alternating.

    The shape is (N, 2 s) if all lanes share the signals, otherwise (N, 2 s, B). The rate of a
    signal that is held between samples is 0. None without signals.

    Parameters
    ----------
    axis : GeneratedAxis
    signals : sequence of (N,) or (N, B) array
        Recorded signals in the order of the axis's declaration.
    period : float
        Sampling period of the signals, s.
    """
    if not signals:
        return None
    here = np.stack(np.broadcast_arrays(*(s.reshape(len(s), -1) for s in signals)), axis=1)
    following = np.concatenate([here[1:], here[-1:]])  # constant after the last sample
    is_held = [declared.is_held for declared in axis.signals]
    following[:, is_held] = here[:, is_held]
    pairs = np.stack([here, (following - here) / period], axis=2)
    stacked = pairs.reshape(len(here), -1, here.shape[2])
    shared = all(s.ndim == 1 for s in signals)
    return np.ascontiguousarray(stacked[:, :, 0] if shared else stacked)


def law_of(axis: GeneratedAxis) -> ControlLaw:
    """Return the control law of an axis that is known to have one."""
    law = axis.control
    assert law is not None  # noqa: S101  # callers refuse an axis without a law
    return law


#: Index of one lane, or indices of several lanes.
Chosen = int | slice | NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopInputs:
    """Inputs of the simulated loops of one stretch: one loop, or several lanes in parallel.

    Attributes
    ----------
    reference : (M,) or (M, B) array
        Reference of all lanes, or of each lane.
    period : float
        Time between the samples of the inputs, s.
    start : LoopStart
        Position, velocity and memory at the first sample, of all lanes or of each lane.
    noise : (M,) or (M, B) array or None
        Noise that is added to the position that the law measures.
    injected : (M,) or (M, B) array or None
        Signal that is added to the control.
    signals : tuple of (M,) or (M, B) array
        Recorded signals in the order of the axis's declaration.
    gains : (g,) or (B, g) array or None
        Gains of the law; None for the declared ones.
    resolution : float
        Encoder step; 0 for none.
    clocks : TwoClocks or None
        Times of the evaluations if the law and the log have different periods; the simulated
        signals are returned at the samples of the log.
    log : LoopInputs or None
        Inputs at the samples of the log; None without `clocks`.
    """

    reference: Array
    period: float
    start: LoopStart
    noise: Array | None = None
    injected: Array | None = None
    signals: tuple[Array, ...] = ()
    gains: Array | None = None
    resolution: float = 0.0
    clocks: TwoClocks | None = None
    log: "LoopInputs | None" = None

    def at_law(self, axis: GeneratedAxis, clocks: TwoClocks | None) -> "LoopInputs":
        """Return the inputs at the law's evaluations; unchanged if `clocks` is None.

        If the log is faster than the law, a held signal is averaged up to the next evaluation,
        unless the law or the drive reads the signal at the evaluation.
        """
        if clocks is None:
            return self
        start, read = self.start, axis.sampled_signals
        signals = []
        for declared, values in zip(axis.signals, self.signals, strict=True):
            if not declared.is_held:
                signals.append(straight(clocks.times, values))
            elif declared.name in read:
                signals.append(clocks.held(values))
            else:
                signals.append(clocks.mean_held(values))
        return replace(
            self,
            reference=clocks.reference(self.reference),
            period=clocks.law_period,
            start=replace(start, position=start.position + start.velocity * clocks.first),
            noise=None if self.noise is None else clocks.held(self.noise),
            injected=None if self.injected is None else clocks.held(self.injected),
            signals=tuple(signals),
            clocks=clocks,
            log=self,
        )

    @property
    def first_signals(self) -> tuple[Array, ...]:
        """Recorded signals at the first sample, () or (B,) each."""
        return tuple(values[0] for values in self.signals)

    def lanes(self, chosen: Chosen) -> "LoopInputs":
        """Return the inputs of the lanes with the indices `chosen`, or of a single lane.

        The start must have a value for each lane.
        """
        start = self.start
        memory = None if start.memory is None else np.ascontiguousarray(start.memory[chosen])
        return replace(
            self,
            reference=_of_lanes(self.reference, chosen),
            start=LoopStart(
                position=start.position[chosen], velocity=start.velocity[chosen], memory=memory
            ),
            noise=None if self.noise is None else _of_lanes(self.noise, chosen),
            injected=None if self.injected is None else _of_lanes(self.injected, chosen),
            signals=tuple(_of_lanes(values, chosen) for values in self.signals),
            gains=None if self.gains is None else self.gains[chosen],
            log=None if self.log is None else self.log.lanes(chosen),
        )


def axis_of(axis: GeneratedAxis, inputs: LoopInputs) -> GeneratedAxis:
    """Return the axis of one loop, with the law's gains of the inputs if they are given."""
    return axis if inputs.gains is None else _with_gains(axis, tuple(inputs.gains.tolist()))


# Most lanes of a batch have the same gains.
@lru_cache(maxsize=64)
def _with_gains(axis: GeneratedAxis, gains: tuple[float, ...]) -> GeneratedAxis:
    """Return the axis with all gains of its law given, in the law's order."""
    return axis.with_gains(dict(zip(law_of(axis).gains, gains, strict=True)))


def _of_lanes(values: Array, chosen: Chosen) -> Array:
    """Return the signal of some lanes; unchanged if all lanes share it."""
    return values if values.ndim == 1 else values[:, chosen]
