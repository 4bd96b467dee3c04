"""What loops are simulated from, at the samples of a log or at the evaluations of a law."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.support.arrays import Array

from .recorded import at_law
from .two_clocks import TwoClocks

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
