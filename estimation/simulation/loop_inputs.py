"""What loops of a record are simulated from, where the law is evaluated."""

from dataclasses import dataclass, replace

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.support.arrays import Array

from .recorded import at_law
from .two_clocks import TwoClocks


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopInputs:
    """What loops of one stretch of a record are simulated from, at the law's evaluations.

    Attributes
    ----------
    reference : (M,) or (M, B) array
    period : float
        s
    start : LoopStart
        Of all lanes, or with a value for each.
    injected : (M,) or (M, B) array or None
        Added to the control.
    signals : tuple of array
        The recorded signals that the axis declares, in its order.
    clocks : TwoClocks or None
        Where the law has another clock than the log.
    """

    reference: Array
    period: float
    start: LoopStart
    injected: Array | None = None
    signals: tuple[Array, ...] = ()
    clocks: TwoClocks | None = None

    @classmethod
    def of_log(
        cls,
        axis: GeneratedAxis,
        reference: Array,
        period: float,
        start: LoopStart,
        injected: Array | None,
        signals: tuple[Array, ...],
        clocks: TwoClocks | None,
    ) -> "LoopInputs":
        """The same from what a log has at its samples, (N,) each."""
        if clocks is not None:
            reference, period = clocks.reference(reference), clocks.law_period
            injected = None if injected is None else clocks.held(injected)
            signals = at_law(axis, signals, clocks)
            start = replace(start, position=start.position + start.velocity * clocks.first)
        return cls(
            reference=reference,
            period=period,
            start=start,
            injected=injected,
            signals=signals,
            clocks=clocks,
        )
