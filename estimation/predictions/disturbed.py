"""What is wrong with the measured position, and what that changes in a loop's output."""

from dataclasses import replace

import numpy as np

from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import moved_start
from axisid.estimation.regression import STEP_SHARES
from axisid.estimation.simulation import simulate_lanes
from axisid.support.arrays import Array

from .slopes import STEP
from .stretch import Stretch


def changed_by_noise(
    stretch: Stretch,
    own: Array,
    *,
    count: int,
    random: np.random.Generator,
    substeps: int | None,
    factor: float = 1.0,
) -> Array:
    """What white noise in the loop changes, (n, B), in so many twins.

    A simulation begins at the first position as it was measured: a twin's axis is as far from there
    as its noise says, and its law reads that position.

    Parameters
    ----------
    stretch : Stretch
    own : (p,) array
        Parameters of its axis.
    count : int
    random : Generator
    substeps : int or None
    factor : float
        Of the noise.
    """
    noise = factor * random.normal(scale=stretch.noise, size=(stretch.samples, count + 1))
    noise[:, -1] = 0.0
    inputs, clocks = stretch.inputs, stretch.inputs.clocks
    start = replace(inputs.start, position=float(inputs.start.position) - noise[0])
    batch = simulate_lanes(
        stretch.axis,
        np.tile(own, (count + 1, 1)),
        replace(inputs, start=start),
        substeps=substeps,
        wanted=stretch.outputs,
        position_noise=noise if clocks is None else clocks.held(noise),
    )
    out = stretch.rows(lambda name: batch[name] + (noise if name == "position" else 0.0))
    return np.where(stretch.counted[:, None], out[:, :-1] - out[:, -1:], 0.0)


def slopes_by_start(stretch: Stretch, own: Array, sizes: Array, *, substeps: int | None) -> Array:
    """What a first position and velocity change, by themselves, (n, 2); NaN where they cannot.

    Parameters
    ----------
    stretch, own, substeps
        As in `changed_by_noise`.
    sizes : (2,) array
        Of both, from which steps are taken.
    """
    start, step = stretch.inputs.start, STEP * sizes
    there = np.array([[float(start.position)], [float(start.velocity)]])
    moved = there + step[:, None] * np.array([[1, -1, 0, 0], [0, 0, 1, -1]])
    batch = simulate_lanes(
        stretch.axis,
        np.tile(own, (4, 1)),
        replace(stretch.inputs, start=replace(start, position=moved[0], velocity=moved[1])),
        substeps=substeps,
        wanted=stretch.outputs,
    )
    out = stretch.rows(batch.__getitem__)
    out[:, [*batch.failures]] = np.nan
    slopes = (out[:, ::2] - out[:, 1::2]) / (2 * step)
    return np.where(stretch.counted[:, None], slopes, 0.0)


def changed_by_steps(stretch: Stretch, own: Array, *, substeps: int | None) -> Array:
    """What the encoder's steps change, (n, B), begun at so many shares of one.

    Parameters
    ----------
    stretch, own, substeps
        As in `changed_by_noise`.
    """
    step, inputs = stretch.step, stretch.inputs
    if not step:
        return np.zeros((len(stretch.measured), len(STEP_SHARES)))
    quiet = simulate_lanes(
        stretch.axis, own[None, :], inputs, substeps=substeps, wanted=stretch.outputs
    )
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
        wanted=stretch.outputs,
        position_noise=np.tile(away, (len(inputs.reference), 1)),
        resolution=step,
    )

    def changed(name: str) -> Array:
        out = batch[name]
        if name == "position":
            out = np.floor((out + away) / step + 0.5) * step - away
        return out - quiet[name]

    return np.where(stretch.counted[:, None], stretch.rows(changed), 0.0)
