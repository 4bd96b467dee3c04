"""Loops of a record with many parameter sets side by side, as `simulate_estimate` runs one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import SIGNALS, LoopStart
from axisid.support.arrays import Array

from .batch import BatchSimulation, simulate_batch
from .between import at_log_samples
from .recorded import at_law, lines
from .steps import (
    has_constant_substeps,
    most_substeps,
    substeps_along,
    substeps_at_start,
    visited_signals,
)
from .two_clocks import TwoClocks

#: What a batch calls the signals of the generated code.
_GIVEN = {name: "direction_before" if name == "before" else name for name in SIGNALS}


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


def simulate_lanes(
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    *,
    substeps: int | None = None,
    wanted: Sequence[str],
    position_noise: Array | None = None,
    resolution: float = 0.0,
    gains: Mapping[str, Array] | None = None,
) -> BatchSimulation:
    """Loops with parameters (B, p), the signals that are wanted at the samples of the log.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (B, p) array
    inputs : LoopInputs
    substeps : int, optional
        As in `simulate`.
    wanted : sequence of str
    position_noise : (M, B) array, optional
        At the law's evaluations.
    resolution : float
        Of the encoder.
    gains : mapping of str to (B,) array, optional
        Of the law, by lane; others are as declared.
    """
    count, start, clocks = len(parameters), inputs.start, inputs.clocks
    names = [signal.name for signal in axis.axis.signals]
    memory = start.memory
    batch = simulate_batch(
        axis,
        parameters,
        inputs.reference,
        inputs.period,
        start=np.broadcast_to(start.position, count),
        start_velocity=np.broadcast_to(start.velocity, count),
        memory=None if memory is None else np.broadcast_to(memory, (count, memory.shape[-1])),
        position_noise=position_noise,
        resolution=resolution,
        injected=inputs.injected,
        signals=dict(zip(names, inputs.signals, strict=True)),
        gains=gains,
        substeps=substeps,
        wanted=wanted if clocks is None else [*_GIVEN.values()],
    )
    if clocks is None:
        return batch
    recorded = lines(axis, inputs.signals, inputs.period)
    lanes = [
        at_log_samples(axis, own, _of_lane(batch, lane), clocks, recorded)
        for lane, own in enumerate(parameters)
    ]
    columns = {name: np.column_stack([lane[name] for lane in lanes]) for name in wanted}
    return replace(batch, signals=columns)


def _of_lane(batch: BatchSimulation, lane: int) -> dict[str, Array]:
    return {own: np.ascontiguousarray(batch[given][:, lane]) for own, given in _GIVEN.items()}


def settled_substeps(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> int | None:
    """Steps in a sample that parameters (p,) ask for, so that others near them take as many.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs

    Returns
    -------
    int or None
        None where the loop cannot be simulated with them.
    """
    first = np.array([values[0] for values in inputs.signals])
    position = np.ravel(inputs.start.position)[:1]
    (steps,) = substeps_at_start(axis, parameters[None, :], position, inputs.period, first)
    if not has_constant_substeps(axis):
        alone = replace(inputs, clocks=None)
        batch = simulate_lanes(axis, parameters[None, :], alone, wanted=visited_signals(axis))
        if batch.failures:
            return None
        visited = {name: values[:, 0] for name, values in batch.signals.items()}
        along = substeps_along(axis, parameters, visited, inputs.period, inputs.signals)
        steps = max(int(steps), along)
    return min(int(steps), most_substeps(len(inputs.reference)))
