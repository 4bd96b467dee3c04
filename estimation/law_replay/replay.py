"""Replay of a control law along a record: its inputs, output, memory, and their derivatives."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from threading import get_ident
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis, build, law_over_block
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record, at_times, law_clock
from axisid.estimation.signals import (
    Prefilter,
    SampledFilter,
    as_logged,
    commands_as_logged,
    recorded_signals,
)
from axisid.estimation.simulation import LoopInputs, TwoClocks, law_of
from axisid.estimation.thresholds import COMPARISON_CUTOFF, MIN_PHASE_AGREEMENT
from axisid.support.arrays import Array
from axisid.support.caching import cached_while_alive

#: Name of the drive's limit among the terms of a law, where their values are estimated.
LIMIT = "drive's limit"


@lru_cache(maxsize=64)  # called for each segment of a record
def with_limit(axis: GeneratedAxis, limit: float, *, native: bool) -> GeneratedAxis:
    """Return the axis with another limit of its drive, in the unit of the control.

    The simulation of the axis is compiled if `native` is True.
    """
    return build(replace(axis.axis, drive=replace(axis.drive, limit=limit)), native=native)


@cached_while_alive
def two_clocks(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> TwoClocks | None:
    """Return the clocks of law and log along a segment; None if the law runs at each sample.

    Where the law is slower than the log, the first evaluation is found from the samples at which
    the recorded control changes.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with a control law.
    record : Record
    span : tuple of int
        The segment: first row and the one after the last.
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
    """Return the time of the last change of the control at or before the first sample, in samples.

    A law that is slower than the log changes the control periodically. The phase of the changes is
    the mean of their phases on the unit circle. The time is 0 or negative, and 0 if the changes are
    not periodic.

    Parameters
    ----------
    control : (N,) array
        Recorded control.
    samples : float
        Number of samples for which the law holds each value of the control.
    """
    changes = np.flatnonzero(np.diff(control)) + 1.0
    whole = math.isclose(samples, round(samples), rel_tol=1e-3)
    if not whole:
        changes -= 0.5  # on average, a change occurs half a sample before it is logged
    turns = np.exp(2j * np.pi * changes / samples)
    mean = turns.mean() if len(turns) else 0.0
    if abs(mean) < MIN_PHASE_AGREEMENT.value:
        return 0.0
    phase = float(np.angle(mean)) / (2 * np.pi) % 1.0 * samples
    phase = round(phase) % round(samples) if whole else phase
    return phase - samples if phase > 0 else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LawInputs:
    """Input signals of a control law at its M evaluations.

    Attributes
    ----------
    reference, position, velocity : (M,) array
        Values that the law reads.
    added : (M,) array
        Test signal that is added to the law's output.
    recorded : tuple of (M,) array
        Recorded signals in the order of the axis's declaration.
    held : (N,) array of int
        Index of the evaluation at or before each sample of the log.
    """

    reference: Array
    position: Array
    velocity: Array
    added: Array
    held: NDArray[np.intp]
    recorded: tuple[Array, ...] = ()

    @property
    def signals(self) -> tuple[Array, ...]:
        """Reference, position, velocity and recorded signals, (M,) each.

        They are the first arguments of a law's function, before its memory.
        """
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
        """Return the inputs of a law that is evaluated at each sample of a log.

        The arguments are the attributes of the class, (N,) each; `added` is None for no test
        signal.
        """
        if added is None:
            added = np.zeros(len(position))
        return cls(
            reference=reference,
            position=position,
            velocity=velocity,
            added=added,
            held=np.arange(len(position)),
            recorded=recorded,
        )

    def __len__(self) -> int:
        """Return the number M of evaluations."""
        return len(self.reference)

    def first(self, samples: int) -> "LawInputs":
        """Return the inputs of the evaluations during the first `samples` samples of the log."""
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
        """Return the added test signal at the samples of the log, (N,).

        It is delayed by `delay` evaluations of the law, and 0 before its start.
        """
        late = self.held - delay
        return np.where(late < 0, 0.0, self.added[np.maximum(late, 0)])


def recorded_inputs(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], start: LoopStart
) -> LoopInputs:
    """Return the inputs of the simulated loop for one segment of a record with a reference.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with a control law.
    record : Record
    span : tuple of int
        The segment: first row and the one after the last.
    start : LoopStart
        Initial state of the loop.
    """
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
    """Return the inputs of the axis's law along a segment of a record with a reference.

    Where the law is not evaluated at the samples, the signals of the log are interpolated at the
    evaluations. The velocity is 0 unless the law reads the velocity of an ideal sensor. As this
    velocity is not logged, it is computed as the derivative of the low-passed positions.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with a control law.
    record : Record
    span : tuple of int
        The segment: first row and the one after the last.
    noisy : bool
        True for the derivative of the recorded positions without a low-pass. A comparison that
        applies the low-pass itself needs it, as a second low-pass would distort the velocity at
        corners of the motion.
    """
    position = record.position[slice(*span)]
    # Velocity of an ideal sensor, at the samples.
    velocity = np.zeros_like(position)
    if law_of(axis).takes_velocity and noisy:
        from scipy.interpolate import CubicSpline

        samples = np.arange(len(position))
        velocity = np.asarray(CubicSpline(samples, position)(samples, 1)) / record.period
    elif law_of(axis).takes_velocity:
        velocity = measured_velocity(position, record.period)
    # All signals at the evaluations of the law.
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
    """Return the velocity, (N,), of recorded positions after a low-pass without delay.

    `period` is the sampling period, s.
    """
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / period)
    return SampledFilter(low_pass, period).motion(position)[1]


def state_at_rest(axis: GeneratedAxis, ticks: LawInputs) -> Array:
    """Return the declared memory of law and delay for an axis that starts at rest, (m,)."""
    read = ticks.reference[0], ticks.position[0], *(values[0] for values in ticks.recorded)
    return np.asarray(axis.functions["control_start"](*read).full().ravel()[: law_memory(axis)])


def law_memory(axis: GeneratedAxis) -> int:
    """Return the number m of memory elements of law and delay, without those of the drive."""
    return int(axis.functions["control_law"].size1_in("state"))


def law_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """Return the control of the law along recorded signals, as it is logged, (N,).

    The limit of the drive is not applied, unless the log has the control that acts on the axis.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with a control law.
    ticks : LawInputs
        Inputs of the law.
    start : (m,) array
        Memory at the first evaluation.
    """
    return commands_as_logged(axis, law_terms_along(axis, ticks, start).sum(axis=1))


def law_terms_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """Return each term of the law at the samples of the log, (N, terms).

    Their sum is the output of the law, in the unit of the control, before the drive and its limit.
    """
    (rows,) = axis.evaluate("control_terms", *ticks.signals, states_along(axis, ticks, start))
    # The control before the first evaluation is assumed to be that of the first.
    return np.asarray(rows[np.maximum(ticks.held - law_of(axis).delay, 0)])


def control_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """Return the control of the law within the drive's limit, as it is logged, (N,)."""
    return commands_as_logged(axis, np.asarray(control_at_ticks(axis, ticks, start)[ticks.held]))


def control_at_ticks(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """Return the control of the law within the drive's limit at each evaluation, (M,)."""
    return run_law(axis.functions["control_law"], start, ticks.signals)[1]


def slopes_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """Return the derivative of `control_along` by the memory at the start, (N, m).

    The Jacobians of single evaluations are multiplied along the evaluations of the law. The
    arguments are as in `law_along`.
    """
    law, size = axis.functions["control_law"], len(start)
    slopes = law.factory("slopes", law.name_in(), ["jac:control:state", "jac:next_state:state"])
    # CasADi returns the matrices of all evaluations side by side.
    read = (values[None, :] for values in ticks.signals)
    of_control, of_state = slopes.call([*read, states_along(axis, ticks, start).T])
    rows = of_control.full().reshape(len(ticks), size)
    steps = of_state.full().reshape(size, len(ticks), size)
    by_start = np.eye(size)  # derivative of the present memory by that at the start
    for k in range(len(ticks)):
        rows[k] = rows[k] @ by_start
        by_start = steps[:, k] @ by_start
    return as_logged(axis, np.asarray(rows[ticks.held]))


def states_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """Return the memory of law and delay before each evaluation, (M, m)."""
    after, _ = run_law(axis.functions["control_law"], start, ticks.signals)
    return np.vstack([start, after[:-1]])


_BLOCK = 400  # evaluations per function call, as a call takes longer than an evaluation


def run_law(step: Any, start: Array, read: Sequence[Array]) -> tuple[Array, Array]:
    """Return the memory of a law after each evaluation, (M, m), and its output, (M,).

    The law runs in blocks of `_BLOCK` evaluations; each block starts from the last memory of the
    block before.

    Parameters
    ----------
    step : casadi.Function
        One evaluation of the law. Its arguments are the inputs, the gains if any, and the memory;
        its results are the next memory and the output.
    start : (m,) array
        Memory at the first evaluation.
    read : sequence of (M,) array
        Inputs at M evaluations, and the gains, (1, g), if they are arguments.
    """
    count = len(read[0])
    columns = [np.reshape(values, (len(values), -1)) for values in read]
    states, output = np.empty((count, len(start))), np.empty((count, 1))
    (memory, *arguments), (memories, outputs), run, _ = _block_of(step, get_ident())
    memory[:] = start
    for first in range(0, count, _BLOCK):
        part = slice(first, first + _BLOCK)
        for argument, values in zip(arguments, columns, strict=True):
            argument[: len(values[part])] = values[part]
        run()
        states[part], output[part] = (found[: count - first] for found in (memories, outputs))
        memory[:] = memories[-1]
    return states, output[:, 0]


# One law runs along many records many times; creating such a function takes as long as a few runs,
# creating one for a whole record as long as many.
@lru_cache(maxsize=64)
def _block_of(step: Any, _thread: int) -> tuple[list[Array], list[Array], Callable[[], None], Any]:
    """Return arrays and a function that evaluate a law at `_BLOCK` successive times in one call.

    They are cached for each thread (`_thread` is its number), because the arrays contain the values
    of one run.

    Returns
    -------
    arguments, results : list of array
        Arrays of the arguments and of the results, to be filled before and read after the call.
    run : callable
        Function without arguments that evaluates the block.
    buffer : object
        CasADi's buffer, which must exist as long as the call is used.
    """
    block = law_over_block(step, _BLOCK)
    # Converting arrays to CasADi matrices takes much longer than a run.
    buffer, run = block.buffer()
    arguments = [np.zeros(block.size_in(i)[::-1]) for i in range(block.n_in())]
    results = [np.zeros(block.size_out(i)[::-1]) for i in range(block.n_out())]
    for i, argument in enumerate(arguments):
        buffer.set_arg(i, argument.data)
    for i, result in enumerate(results):
        buffer.set_res(i, result.data)
    return arguments, results, run, buffer
