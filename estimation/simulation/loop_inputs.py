"""What loops are simulated from: at the samples of a log, or at the evaluations of a law.

Where their rates differ the loop is simulated as the law runs, and sampled as the log is. From the
evaluation before a sample the plant goes on as in the simulation itself, under the force that is
held, through every stop, reversal and side on its way.
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

# between periods of law and reference: 20 kHz logged at 50 Hz; a period in ms is 1000 times too
# long
_MAX_CLOCK_RATIO = 400.0
_COINCIDES = 1e-6  # of a period, from an evaluation
_FEWEST_OF_A_SPLINE = 4  # samples


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoClocks:
    """When a law is evaluated along a log of another period.

    Attributes
    ----------
    samples : int
        Of the log.
    log_period, law_period : float
        s
    first : float
        Time of the first evaluation, s from the first sample; 0 or before it.
    between : str
        How the reference runs between samples, ``spline``, ``linear`` or ``held``.
    """

    samples: int
    log_period: float
    law_period: float
    first: float = 0.0
    between: str = "spline"
    _smooth: list[tuple[Array, Array]] = field(
        init=False, default_factory=list, repr=False, compare=False
    )

    @property
    def times(self) -> Array:
        """Of the evaluations up to the one after the last sample, in samples of the log."""
        last = (self.samples - 1) * self.log_period - self.first
        count = math.floor(last / self.law_period + _COINCIDES) + 2
        return np.asarray((self.first + self.law_period * np.arange(count)) / self.log_period)

    @property
    def elapsed(self) -> tuple[NDArray[np.intp], Array]:
        """The evaluation at or before each sample, and the time since then, s, (N,) each."""
        time = self.log_period * np.arange(self.samples) - self.first
        last = np.floor(time / self.law_period + _COINCIDES).astype(np.intp)
        since = time - self.law_period * last
        return last, np.where(since > _COINCIDES * self.law_period, since, 0.0)

    def reference(self, values: Array) -> Array:
        """A reference of the log, (N,), where the law is evaluated, (M,); (N, B) likewise.

        The last smooth one is kept: a record's loop is simulated many times with it.
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
        """Mean until the next evaluation of what is held between samples of the log, (M,)."""
        if self.law_period <= self.log_period:
            return self.held(values)
        until = np.concatenate([0 * values[:1], np.cumsum(values, axis=0)])
        edges = np.append(self.times, self.times[-1] + self.law_period / self.log_period)
        inside = np.clip(edges, 0, len(values))
        integrals, spans = np.diff(straight(inside, until), axis=0), np.diff(inside)
        mean = self.held(values)  # beyond the log it stays
        mean[spans > 0] = (integrals[spans > 0].T / spans[spans > 0]).T
        return mean

    def held(self, values: Array) -> Array:
        """What is held from a sample of the log to the next, where the law is evaluated, (M,)."""
        row = np.floor(self.times + _COINCIDES).astype(np.intp)
        return np.asarray(values[np.clip(row, 0, len(values) - 1)])


def straight(times: Array, values: Array) -> Array:
    """What runs straight between samples, (N, ...), at times in samples, (M, ...)."""
    rows = np.arange(len(values))
    return np.asarray(np.apply_along_axis(lambda column: np.interp(times, rows, column), 0, values))


def clocks_of(law: ControlLaw, samples: int, period: float) -> TwoClocks | None:
    """When a law is evaluated along a reference whose period is not the law's; None where it is.

    The first evaluation is at the first sample. A continuous law has no clock.

    Parameters
    ----------
    law : ControlLaw
    samples : int
    period : float
        Of the reference, s.

    Raises
    ------
    UsageError
        One period is so many times the other that it is in another unit.
    """
    if law.continuous or is_same_period(period, law.period):
        return None
    ratio, most = period / law.period, _MAX_CLOCK_RATIO
    if not 1 / most <= ratio <= most:
        raise UsageError(
            f"the period is {period:g} s, but the control law is evaluated every {law.period:g} s; "
            f"give one that is at most {most:g} times as long or as short, in seconds, or declare "
            "the law with another.",
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
    """Signals of a loop at the law's evaluations, (M,), at the samples of the log, (N,).

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    signals : dict of str to (M,) array
        By the names of `SIGNALS`; NaN from where the simulation ended early.
    clocks : TwoClocks
    recorded : sequence of (M,) array
        The recorded signals that the axis declares, at the evaluations.
    substeps : int
        That the simulation took in a sample.

    Returns
    -------
    dict of str to (N,) array
        The same, and ``held``: the force just before a sample.
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
            f"the log of axis {axis.name!r} is sampled between the evaluations of its law, "
            "where what its friction remembers is not known; give the law's period, or whole "
            "multiples of it.",
            code="loop-period",
        )
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
    then = between[begin, ::2] + span[:, None] * between[begin, 1::2]
    (acceleration,) = axis.evaluate(
        "direct_dynamics", position, velocity, force[begin], direction, *then.T, parameters
    )
    sticks = (velocity == 0) & (np.abs(direction) < 1)
    out["position"][between_ticks], out["velocity"][between_ticks] = position, velocity
    out["direction"][between_ticks] = out["direction_before"][between_ticks] = direction
    out["acceleration"][between_ticks] = np.where(sticks, 0.0, acceleration[:, 0])
    return out


def lines(axis: GeneratedAxis, signals: Sequence[Array], period: float) -> Array | None:
    """Value and rate of each signal in turn, (N, 2 s) or (N, 2 s, B); None for no signals.

    Parameters
    ----------
    axis : GeneratedAxis
    signals : sequence of (N,) or (N, B) array
        In the axis's order.
    period : float
        s
    """
    if not signals:
        return None
    here = np.stack(np.broadcast_arrays(*(s.reshape(len(s), -1) for s in signals)), axis=1)
    following = np.concatenate([here[1:], here[-1:]])
    is_held = [declared.is_held for declared in axis.signals]
    following[:, is_held] = here[:, is_held]
    pairs = np.stack([here, (following - here) / period], axis=2)
    stacked = pairs.reshape(len(here), -1, here.shape[2])
    shared = all(s.ndim == 1 for s in signals)
    return np.ascontiguousarray(stacked[:, :, 0] if shared else stacked)


def law_of(axis: GeneratedAxis) -> ControlLaw:
    """The control law of an axis that is known to have one."""
    law = axis.control
    assert law is not None  # noqa: S101  # whoever asks has refused an axis without one
    return law


#: One lane, or several.
Chosen = int | slice | NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopInputs:
    """What loops of one stretch are simulated from: one loop, or lanes side by side.

    Attributes
    ----------
    reference : (M,) or (M, B) array
    period : float
        s
    start : LoopStart
        Of all lanes, or with a value for each.
    noise : (M,) or (M, B) array or None
        Added to the position that the law measures.
    injected : (M,) or (M, B) array or None
        Added to the control.
    signals : tuple of (M,) or (M, B) array
        The recorded signals that the axis declares, in its order.
    gains : (g,) or (B, g) array or None
        Of the law; None as declared.
    resolution : float
        Of the encoder; 0 for none.
    clocks : TwoClocks or None
        Where the law has another clock than the log, at whose samples the loops are given back.
    log : LoopInputs or None
        Then the same at the samples of the log.
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
        """What a log has at its samples, where the law is evaluated; itself without clocks."""
        if clocks is None:
            return self
        start, read = self.start, axis.sampled_signals
        return replace(
            self,
            reference=clocks.reference(self.reference),
            period=clocks.law_period,
            start=replace(start, position=start.position + start.velocity * clocks.first),
            noise=None if self.noise is None else clocks.held(self.noise),
            injected=None if self.injected is None else clocks.held(self.injected),
            # What is held from sample to sample of a log that is faster than the law enters by its
            # mean until the next evaluation, unless law or drive read it at the evaluation.
            signals=tuple(
                straight(clocks.times, values)
                if not declared.is_held
                else clocks.held(values)
                if declared.name in read
                else clocks.mean_held(values)
                for declared, values in zip(axis.signals, self.signals, strict=True)
            ),
            clocks=clocks,
            log=self,
        )

    @property
    def first_signals(self) -> tuple[Array, ...]:
        """The recorded signals at the first sample, () or (B,) each."""
        return tuple(values[0] for values in self.signals)

    def lanes(self, chosen: Chosen) -> "LoopInputs":
        """Those of some lanes, or of one, where the start has a value for each."""
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
    """The axis of one loop: its law with the gains of the inputs."""
    return axis if inputs.gains is None else _with_gains(axis, tuple(inputs.gains.tolist()))


# Most lanes of a batch have the same gains.
@lru_cache(maxsize=64)
def _with_gains(axis: GeneratedAxis, gains: tuple[float, ...]) -> GeneratedAxis:
    return axis.with_gains(dict(zip(law_of(axis).gains, gains, strict=True)))


def _of_lanes(values: Array, chosen: Chosen) -> Array:
    """A signal of some lanes; one that all share as it is."""
    return values if values.ndim == 1 else values[:, chosen]
