"""A control law along recorded signals."""

from functools import lru_cache
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.runtime import along_samples
from axisid.estimation.simulation import law_of
from axisid.support.arrays import Array

from .as_logged import as_logged, commands_as_logged, hides_command
from .law_ticks import LawTicks

_EVALUATIONS = 1 << 16  # of a law in one call; making a function of more takes longer than they do


def state_at_rest(axis: GeneratedAxis, ticks: LawTicks) -> Array:
    """What the drive remembers of an axis at rest at the first evaluation, (m,)."""
    first = (values[0] for values in (ticks.reference, ticks.position, *ticks.recorded))
    start = axis.functions["control_start"](*first)
    return np.asarray(start.full().ravel()[: law_memory(axis)])


def law_memory(axis: GeneratedAxis) -> int:
    """How many numbers the law remembers, and its delay line; the drive's come after them."""
    return int(axis.functions["control_law"].size1_in("state"))


def terms_along(axis: GeneratedAxis, ticks: LawTicks, start: Array) -> Array:
    """The control law's terms along recorded signals, when they are applied, (N, terms).

    Of a log that hides the commands only their sum is known there: the first column has it.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    ticks : LawTicks
        What the law measured.
    start : (m,) array
        What it remembered at the first evaluation.
    """
    terms = applied_terms(axis, ticks, start)
    if not hides_command(axis):
        return as_logged(axis, terms)
    made = np.zeros_like(terms)
    made[:, 0] = commands_as_logged(axis, terms.sum(axis=1))
    return made


def applied_terms(axis: GeneratedAxis, ticks: LawTicks, start: Array) -> Array:
    """The same as the law gives them, before the drive, (N, terms)."""
    read = (values[0] for values in ticks.signals)
    (rows,) = axis.evaluate("control_terms", *read, states_along(axis, ticks, start).T)
    # What was computed before the first evaluation is taken for that of the first.
    return np.asarray(rows[np.maximum(ticks.held - law_of(axis).delay, 0)])


def control_along(axis: GeneratedAxis, ticks: LawTicks, start: Array) -> Array:
    """The control that the law gives within the drive's limit, (N,)."""
    return commands_as_logged(axis, np.asarray(control_at_ticks(axis, ticks, start)[ticks.held]))


def control_at_ticks(axis: GeneratedAxis, ticks: LawTicks, start: Array) -> Array:
    """The same at each evaluation, (M,)."""
    arguments = (*ticks.signals, states_along(axis, ticks, start))
    return np.asarray(axis.functions["control_law"].call(arguments)[0].full().ravel())


def slopes_along(axis: GeneratedAxis, ticks: LawTicks, start: Array) -> Array:
    """How that control changes with what is remembered at the start, (N, m)."""
    law, size = axis.functions["control_law"], len(start)
    slopes = law.factory("slopes", law.name_in(), ["jac:control:state", "jac:next_state:state"])
    by_state, onward = slopes.call([*ticks.signals, states_along(axis, ticks, start)])
    # Side by side as matrices, one for each evaluation.
    rows = by_state.full().reshape(len(ticks), size)
    steps = onward.full().reshape(size, len(ticks), size)
    change = np.eye(size)
    for k in range(len(ticks)):
        rows[k] = rows[k] @ change
        change = steps[:, k] @ change
    return as_logged(axis, np.asarray(rows[ticks.held]))


def states_along(axis: GeneratedAxis, ticks: LawTicks, start: Array) -> Array:
    """What the drive remembers at each evaluation, (m, M)."""
    if not len(start):
        return np.zeros((0, len(ticks)))
    pieces = [start[:, None]]
    for begin in range(0, len(ticks), _EVALUATIONS):
        part = [values[:, begin : begin + _EVALUATIONS] for values in ticks.signals]
        along = _run_along(axis, part[0].shape[1])
        pieces.append(along(pieces[-1][:, -1], *part).full())
    return np.hstack(pieces)[:, :-1]


# A check runs one law along one record many times; to make such a function takes as long as a run.
@lru_cache(maxsize=16)
def _run_along(axis: GeneratedAxis, evaluations: int) -> Any:
    """What the drive remembers after each of so many evaluations, from what it did before."""
    return along_samples(axis.functions["control_law"], evaluations)


def least_step(columns: Array, off: Array, least: float) -> tuple[Array, int]:
    """Least squares by unit columns, and in how many directions they show.

    Parameters
    ----------
    columns : (n, k) array
    off : (n,) array
    least : float
        Of the largest singular value; what the record shows by less is left alone.
    """
    columns = np.where(np.isfinite(columns).all(axis=0), columns, 0.0)
    sizes = np.linalg.norm(columns, axis=0)
    scale = np.where(sizes > 0, sizes, 1.0)
    # The triangle has the singular values of the columns, and is small.
    whole = np.column_stack([columns / scale, off])
    triangle = np.asarray(np.linalg.qr(whole, mode="r"))[: len(scale)]
    u, effect, v = np.linalg.svd(triangle[:, :-1], full_matrices=False)
    clear = effect > least * effect.max(initial=0.0)
    step = (v[clear].T @ ((u.T @ triangle[:, -1])[clear] / effect[clear])) / scale
    return np.asarray(step), int(clear.sum())
