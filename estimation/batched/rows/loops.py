"""Closed loops of a block of lanes, in arrays that serve one simulation after the other."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import SIGNALS, LoopSettings, LoopStart
from axisid.estimation.simulation import (
    allowed_distance,
    has_constant_substeps,
    has_inertia,
    most_substeps,
    simulate_batch,
    substeps_at_start,
)
from axisid.support.arrays import Array

from .lanes import RecordLanes
from .workspace import spaces

_BEFORE = "direction_before"  # as a batch calls it
_WANTED = (*SIGNALS[:-1], _BEFORE)


def simulated_lanes(
    axis: GeneratedAxis,
    physical: Array,
    lanes: RecordLanes,
    start: LoopStart,
) -> tuple[dict[str, Array], NDArray[np.bool_]]:
    """Signals by name, (N, B) each, of loops with parameters (B, p), and which of them went well.

    The signals are there until the next loops of the thread are simulated.
    """
    nothing = np.zeros(0)  # of recorded signals
    well = has_inertia(axis, physical, start.position, nothing)
    if not well.any():
        return _nowhere(len(lanes.reference), len(physical)), well
    # What cannot be simulated repeats a lane that can.
    physical = np.where(well[:, None], physical, physical[np.argmax(well)])
    counts = substeps_at_start(axis, physical, start.position, lanes.period, nothing)
    library, alike = axis.native.library(), bool(np.all(counts == counts[0]))
    if library is None or not (
        has_constant_substeps(axis) and alike and counts[0] <= most_substeps(len(lanes.reference))
    ):
        signals, fine = _apart(axis, physical, lanes, start)
        return signals, well & fine
    reach = float(np.ptp(lanes.reference))
    away = np.abs(start.position - lanes.reference[0])
    settings = LoopSettings(
        period=lanes.period,
        resolution=0.0,
        allowed=np.array([allowed_distance(reach, each) for each in away]),
        substeps=int(counts[0]),
    )
    shape = (len(lanes.reference), len(physical))
    status, _, signals = library.simulate_batch(
        lanes.reference,
        None,
        None,
        np.ascontiguousarray(physical),
        replace(start, position=np.ascontiguousarray(start.position)),
        settings,
        SIGNALS,
        1,
        into=spaces("loop", len(SIGNALS), *shape),
    )
    signals[_BEFORE] = signals.pop(SIGNALS[-1])
    return signals, well & (status == 0)


def _nowhere(samples: int, lanes: int) -> dict[str, Array]:
    """Signals of loops that cannot be simulated."""
    return {name: np.full((samples, lanes), np.nan) for name in _WANTED}


def _apart(
    axis: GeneratedAxis,
    physical: Array,
    lanes: RecordLanes,
    start: LoopStart,
) -> tuple[dict[str, Array], NDArray[np.bool_]]:
    """The same where lanes take steps of their own, or fail before they begin."""
    batch = simulate_batch(
        axis,
        physical,
        lanes.reference,
        lanes.period,
        start=start.position,
        start_velocity=start.velocity,
        wanted=_WANTED,
        threads=1,
    )
    return dict(batch.signals), np.array([i not in batch.failures for i in range(len(physical))])
