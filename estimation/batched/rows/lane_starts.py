"""Where the loops of many records of one reference start, side by side."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import (
    START_SAMPLES,
    at_rest_misses,
    below_limit,
    first_velocities,
    law_memory,
    loop_starts,
)
from axisid.estimation.records import Record
from axisid.support.arrays import Array


def lane_starts(
    axis: GeneratedAxis,
    reference: Array,
    position: Array,
    control: Array,
    period: float,
    record: Callable[[int], Record],
) -> tuple[LoopStart, NDArray[np.bool_]]:
    """Starts as `loop_starts` has them of each, and of which lanes that is so.

    Lanes begin with what the law declares for an axis at rest; those whose first controls say
    otherwise are the others.

    Parameters
    ----------
    axis : GeneratedAxis
        With a sampled law, whose drive acts at once.
    reference : (N,) array
    position, control : (N, L) array
    period : float
        s
    record : callable
        Gives a lane as a record.
    """
    velocity = first_velocities(position, period)
    start = LoopStart(position=position[0].copy(), velocity=velocity, memory=None)
    rests = np.ones(len(velocity), dtype=bool)
    law = axis.axis.control
    if law is None or not law_memory(axis):
        return start, rests
    if law.balanced or law.takes_velocity:
        found = [loop_starts(axis, record(lane))[0].memory for lane in range(len(velocity))]
        return start, np.array([memory is None for memory in found])
    first = control[:START_SAMPLES]
    off = first - _at_rest(axis, reference, position, len(first))
    power = np.mean(control**2, axis=0)
    return start, np.asarray(~at_rest_misses(off, below_limit(axis, first), power))


def _at_rest(axis: GeneratedAxis, reference: Array, position: Array, samples: int) -> Array:
    """The first controls of the law of an axis that rested before, (samples, L)."""
    lanes = position.shape[1]
    commanded = np.broadcast_to(reference[:samples, None], (samples, lanes)).copy()
    (state,) = axis.evaluate("control_start", commanded[0], position[0])
    made = np.empty((samples, lanes))
    for k in range(samples):
        read = (commanded[k], position[k], np.zeros(lanes))
        control, state = axis.evaluate("control_law", *read, state)
        made[k] = control[:, 0]
    return made
