"""What loops are simulated from, at the samples of a log or at the evaluations of a law.

A loop runs away where it is farther from its reference than some multiple of what is asked of it:
the way of the reference, and from the start to it. Where that is next to nothing, other things move
the axis: noise and counts of the encoder, and the load at the start, to which the loop gives way
until its control holds it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.support.arrays import Array
from axisid.support.errors import UsageError, quoted

from .lane_arguments import checked_array
from .two_clocks import TwoClocks


def checked_signals(
    axis: GeneratedAxis, signals: Mapping[str, ArrayLike] | None, samples: int, lanes: int = 0
) -> tuple[Array, ...]:
    """The signals that an axis declares, in its order, (N,) each, or (N, B) in a batch.

    Raises
    ------
    UsageError
        One is missing, is not declared, or has another length.
    """
    if not (signals is None or isinstance(signals, Mapping)):
        raise UsageError(
            f"the signals are {quoted(signals)}; give arrays by name, such as "
            "{'pressure': values}. What is wanted of a batch is `wanted`.",
            code="simulation-input",
        )
    found, names = dict(signals or {}), [signal.name for signal in axis.axis.signals]
    if missing := [name for name in names if name not in found]:
        raise UsageError(
            f"axis {axis.axis.name!r} has the recorded signals {', '.join(names)}, of which "
            f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not given; give "
            f"signals={{{missing[0]!r}: values}}, one for each sample of the reference.",
            code="simulation-input",
        )
    if unknown := [name for name in found if name not in names]:
        listed = ", ".join(names) or "none"
        raise UsageError(
            f"axis {axis.axis.name!r} declares no signal {', '.join(map(str, unknown))}; its "
            f"signals are {listed}.",
            code="simulation-input",
        )
    shapes = [(samples,), *([(samples, lanes)] if lanes else [])]
    return tuple(checked_array(found[name], f"the signal {name!r}", shapes) for name in names)


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
    shape = np.broadcast_shapes(*(s.shape + (1,) * (2 - s.ndim) for s in signals))
    wide = max(s.ndim for s in signals) > 1
    columns = []
    for declared, values in zip(axis.axis.signals, signals, strict=True):
        here = np.broadcast_to(values if values.ndim > 1 else values[:, None], shape)
        following = here if declared.is_held else np.concatenate([here[1:], here[-1:]])
        columns += [here, (following - here) / period]
    stacked = np.stack(columns, axis=1)
    return np.ascontiguousarray(stacked if wide else stacked[:, :, 0])


def at_law(axis: GeneratedAxis, signals: Sequence[Array], clocks: TwoClocks) -> tuple[Array, ...]:
    """Signals of a log, (N,) each, where its law is evaluated, (M,) each.

    What is held from sample to sample of a log that is faster than the law enters by its mean until
    the next evaluation, unless law or drive read it at the evaluation.
    """
    read = axis.axis.sampled_signals
    return tuple(
        clocks.linear(values)
        if not declared.is_held
        else clocks.held(values)
        if declared.name in read
        else clocks.mean_held(values)
        for declared, values in zip(axis.axis.signals, signals, strict=True)
    )


def before(axis: GeneratedAxis, signals: Sequence[Array]) -> tuple[Array, ...]:
    """Signals just before each sample: what was held until then."""
    return tuple(
        np.concatenate([values[:1], values[:-1]]) if declared.is_held else values
        for declared, values in zip(axis.axis.signals, signals, strict=True)
    )


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
    resolution: float = 0.0
    clocks: TwoClocks | None = None
    log: "LoopInputs | None" = None

    def at_law(self, axis: GeneratedAxis, clocks: TwoClocks | None) -> "LoopInputs":
        """What a log has at its samples, where the law is evaluated; itself without clocks."""
        if clocks is None:
            return self
        start = self.start
        return LoopInputs(
            reference=clocks.reference(self.reference),
            period=clocks.law_period,
            start=replace(start, position=start.position + start.velocity * clocks.first),
            noise=None if self.noise is None else clocks.held(self.noise),
            injected=None if self.injected is None else clocks.held(self.injected),
            signals=at_law(axis, self.signals, clocks),
            resolution=self.resolution,
            clocks=clocks,
            log=self,
        )

    @property
    def logged(self) -> "LoopInputs":
        """The same at the samples at which the loops are given back."""
        return self.log or self

    @property
    def first_signals(self) -> tuple[Array, ...]:
        """The recorded signals at the first sample, () or (B,) each."""
        return tuple(values[0] for values in self.signals)

    def lanes(self, chosen: Chosen) -> "LoopInputs":
        """Those of some lanes, or of one, where the start has a value for each."""
        return replace(
            self,
            reference=_of_lanes(self.reference, chosen),
            start=_start_of(self.start, chosen),
            noise=None if self.noise is None else _of_lanes(self.noise, chosen),
            injected=None if self.injected is None else _of_lanes(self.injected, chosen),
            signals=tuple(_of_lanes(values, chosen) for values in self.signals),
            log=None if self.log is None else self.log.lanes(chosen),
        )


def _of_lanes(values: Array, chosen: Chosen) -> Array:
    """A signal of some lanes; one that all share as it is."""
    return values if values.ndim == 1 else values[:, chosen]


def _start_of(start: LoopStart, chosen: Chosen) -> LoopStart:
    memory = None if start.memory is None else np.ascontiguousarray(start.memory[chosen])
    return LoopStart(
        position=start.position[chosen], velocity=start.velocity[chosen], memory=memory
    )


_RUNAWAY_RATIO = 100.0  # distance from the reference, by what a loop is asked to move

_OFF = 1e-6  # of the reference from the position, for the loop's stiffness


def allowed_distance(span: float, away: float) -> float:
    """Distance from the reference beyond which the loop has run away.

    Parameters
    ----------
    span : float
        Of the reference.
    away : float
        From the start to the first reference.
    """
    return _RUNAWAY_RATIO * max(float(span), float(away)) or math.inf


def widened_distance(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> float:
    """The same for what moves one loop but its reference: load, noise, counts, test signals.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs
        Of one loop.
    """
    place, signals = float(inputs.start.position), [*map(float, inputs.first_signals)]
    noise = 0.0 if inputs.noise is None else float(np.ptp(inputs.noise))
    drive, controls = axis.axis.drive, _controls(axis, place, *signals)
    # Up to so much of a command is lost.
    added = drive.deadband + drive.quantisation / 2
    added += 0.0 if inputs.injected is None else float(np.abs(inputs.injected).max())
    force, dynamics = axis.functions["drive_force"], axis.functions["direct_dynamics"]
    still, behind = (float(force(control, place, 0.0, *signals)) for control in controls)
    loaded, free, pushed = (
        float(dynamics(place, 0.0, tau, 0.0, *signals, parameters)) for tau in (still, 0.0, 1.0)
    )
    # At rest on its reference the loop gives way to the load there.
    sag = _way(abs(loaded), abs((pushed - free) * (behind - still)))
    way = sag + _way(added, abs(controls[1] - controls[0]))
    return _RUNAWAY_RATIO * max(way, noise, inputs.resolution)


def _way(asked: float, answered: float) -> float:
    """Distance at which a loop answers what is asked of it; infinite where it does not.

    Parameters
    ----------
    asked, answered : float
        What moves it, and what it answers to `_OFF` from its reference.
    """
    if asked == 0:
        return 0.0
    found = asked * _OFF / answered if answered else math.inf
    return found if math.isfinite(found) else math.inf


def _controls(axis: GeneratedAxis, position: float, *recorded: float) -> tuple[float, float]:
    """Control of an axis at rest on its reference, and a little behind it, at its most."""
    law, begin = axis.functions["control_law"], axis.functions["control_start"]
    memory = begin(position, position, *recorded)[: law.size1_in("state")]
    answers = []
    for reference in (position, position + _OFF):
        state, controls = memory, []
        for _ in range(memory.numel() + 2):  # a delay answers late
            control, state = law(reference, position, 0.0, *recorded, state)
            controls.append(float(control))
        answers.append(controls)
    still, behind = (np.array(each) for each in answers)
    largest = int(np.argmax(np.abs(behind - still)))
    return float(still[largest]), float(behind[largest])
