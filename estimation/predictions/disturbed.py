"""What is wrong with the measured position, and what that changes in a loop's output."""

from dataclasses import replace

import numpy as np

from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import moved_start
from axisid.estimation.regression import STEP_SHARES
from axisid.estimation.simulation import simulate_lanes
from axisid.support.arrays import Array

from .stretch import Stretch


def changed_by_noise(
    stretch: Stretch,
    own: Array,
    *,
    count: int,
    random: np.random.Generator,
    signal: str,
    substeps: int | None,
) -> Array:
    """What white noise in the loop changes, (N, B), in so many twins.

    Parameters
    ----------
    stretch : Stretch
    own : (p,) array
        Parameters of its axis.
    count : int
    random : Generator
    signal : str
        The output.
    substeps : int or None
    """
    noise = random.normal(scale=stretch.noise, size=(len(stretch.measured), count + 1))
    noise[:, -1] = 0.0
    clocks = stretch.inputs.clocks
    batch = simulate_lanes(
        stretch.axis,
        np.tile(own, (count + 1, 1)),
        stretch.inputs,
        substeps=substeps,
        wanted=[signal],
        position_noise=noise if clocks is None else clocks.held(noise),
    )
    out = batch[signal] + (noise if signal == "position" else 0.0)
    return np.where(stretch.counted[:, None], out[:, :-1] - out[:, -1:], 0.0)


def changed_by_steps(stretch: Stretch, own: Array, *, signal: str, substeps: int | None) -> Array:
    """What the encoder's steps change, (N, B), begun at so many shares of one.

    Parameters
    ----------
    stretch, own, signal, substeps
        As in `changed_by_noise`.
    """
    step, inputs = stretch.step, stretch.inputs
    wanted = [*dict.fromkeys([signal, "position"])]
    quiet = simulate_lanes(stretch.axis, own[None, :], inputs, substeps=substeps, wanted=wanted)
    if not step:
        return np.zeros((len(stretch.measured), len(STEP_SHARES)))
    away = step * np.array(STEP_SHARES)
    first = [float(values[0]) for values in inputs.signals]
    starts = [
        moved_start(stretch.axis, inputs.start, float(inputs.reference[0]), first, float(each))
        for each in away
    ]
    memory = None if inputs.start.memory is None else np.array([s.memory for s in starts])
    start = LoopStart(position=inputs.start.position, velocity=inputs.start.velocity, memory=memory)
    batch = simulate_lanes(
        stretch.axis,
        np.tile(own, (len(away), 1)),
        replace(inputs, reference=inputs.reference[:, None] + away, start=start),
        substeps=substeps,
        wanted=wanted,
        position_noise=np.tile(away, (len(inputs.reference), 1)),
        resolution=step,
    )
    out = batch[signal]
    if signal == "position":
        out = np.floor((out + away) / step + 0.5) * step - away
    return np.where(stretch.counted[:, None], out - quiet[signal], 0.0)
