"""What loops are simulated from: at the samples of a log, or at the evaluations of a law."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array

from .multirate import TwoClocks, straight


def law_of(axis: GeneratedAxis) -> ControlLaw:
    """The control law of an axis that is known to have one."""
    law = axis.axis.control
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
        start, read = self.start, axis.axis.sampled_signals
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
                for declared, values in zip(axis.axis.signals, self.signals, strict=True)
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
