"""A control law run along recorded signals: its output, its terms and states, and their slopes."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from threading import get_ident
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, law_over_block
from axisid.estimation.signals import as_logged, commands_as_logged
from axisid.estimation.simulation import law_of
from axisid.support.arrays import Array

from .law_inputs import LawInputs


def state_at_rest(axis: GeneratedAxis, ticks: LawInputs) -> Array:
    """What the drive remembers of an axis at rest at the first evaluation, (m,)."""
    read = ticks.reference[0], ticks.position[0], *(values[0] for values in ticks.recorded)
    return np.asarray(axis.functions["control_start"](*read).full().ravel()[: law_memory(axis)])


def law_memory(axis: GeneratedAxis) -> int:
    """How many numbers the law remembers, and its delay line; the drive's come after them."""
    return int(axis.functions["control_law"].size1_in("state"))


def law_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """What the control law gives along recorded signals, as the log has it, (N,).

    Before the drive's limit, but of a log that hides the commands.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    ticks : LawInputs
        What the law measured.
    start : (m,) array
        What it remembered at the first evaluation.
    """
    return commands_as_logged(axis, law_terms_along(axis, ticks, start).sum(axis=1))


def law_terms_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """The terms of the law as it gives them, before the drive, (N, terms)."""
    (rows,) = axis.evaluate("control_terms", *ticks.signals, states_along(axis, ticks, start))
    # What was computed before the first evaluation is taken for that of the first.
    return np.asarray(rows[np.maximum(ticks.held - law_of(axis).delay, 0)])


def control_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """The control that the law gives within the drive's limit, (N,)."""
    return commands_as_logged(axis, np.asarray(control_at_ticks(axis, ticks, start)[ticks.held]))


def control_at_ticks(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """The same at each evaluation, (M,)."""
    return run_law(axis.functions["control_law"], start, ticks.signals)[1]


def slopes_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """How that control changes with what is remembered at the start, (N, m)."""
    law, size = axis.functions["control_law"], len(start)
    slopes = law.factory("slopes", law.name_in(), ["jac:control:state", "jac:next_state:state"])
    # Side by side as matrices, one for each evaluation.
    read = (values[None, :] for values in ticks.signals)
    by_state, onward = slopes.call([*read, states_along(axis, ticks, start).T])
    rows = by_state.full().reshape(len(ticks), size)
    steps = onward.full().reshape(size, len(ticks), size)
    change = np.eye(size)
    for k in range(len(ticks)):
        rows[k] = rows[k] @ change
        change = steps[:, k] @ change
    return as_logged(axis, np.asarray(rows[ticks.held]))


def states_along(axis: GeneratedAxis, ticks: LawInputs, start: Array) -> Array:
    """What the drive remembers at each evaluation, (M, m)."""
    after, _ = run_law(axis.functions["control_law"], start, ticks.signals)
    return np.vstack([start, after[:-1]])


_BLOCK = 400  # evaluations that are one function: to call one takes longer than to evaluate it


def run_law(step: Any, start: Array, read: Sequence[Array]) -> tuple[Array, Array]:
    """What a law remembers after each evaluation, (M, m), and its output there, (M,).

    Parameters
    ----------
    step : casadi.Function
        From what is read at an evaluation, the gains if any, and the memory.
    start : (m,) array
        What it remembers at the first.
    read : sequence of (M,) array
        The gains, which stay, are (1, g).
    """
    count = len(read[0])
    columns = [np.reshape(values, (len(values), -1)) for values in read]
    states, output = np.empty((count, len(start))), np.empty((count, 1))
    (memory, *places), (after, given), run, _ = _block_of(step, get_ident())
    memory[:] = start
    for first in range(0, count, _BLOCK):
        part = slice(first, first + _BLOCK)
        for place, values in zip(places, columns, strict=True):
            place[: len(values[part])] = values[part]
        run()
        states[part], output[part] = (found[: count - first] for found in (after, given))
        memory[:] = after[-1]
    return states, output[:, 0]


# One law runs along many records many times; to make such a function takes as long as some runs,
# and one of a whole record as long as many.
@lru_cache(maxsize=64)
def _block_of(step: Any, _thread: int) -> tuple[list[Array], list[Array], Callable[[], None], Any]:
    """Places of arguments and of results, what runs a law over a block of evaluations, its buffer.

    One for each thread, by its number: what is in the places is of one run.
    """
    block = law_over_block(step, _BLOCK)
    # To make CasADi's matrices of arrays takes much longer than a run, to set a place as long.
    buffer, run = block.buffer()
    arguments = [np.zeros(block.size_in(i)[::-1]) for i in range(block.n_in())]
    results = [np.zeros(block.size_out(i)[::-1]) for i in range(block.n_out())]
    for i, place in enumerate(arguments):
        buffer.set_arg(i, place.data)
    for i, place in enumerate(results):
        buffer.set_res(i, place.data)
    return arguments, results, run, buffer
