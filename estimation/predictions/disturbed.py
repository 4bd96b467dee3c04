"""What is wrong with the measured position, and what that changes in a loop's output."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import moved_start
from axisid.estimation.simulation import simulate_lanes
from axisid.support.arrays import Array, in_few_digits

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
    """What errors of the measured position change in the loop, (n, B), in so many twins.

    An encoder's are those of its steps, which begin anywhere: they are silent at rest, and shake
    nothing there, as white noise of their size would. What a record has besides is white.

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
        Of the noise, and of where the steps begin.
    """
    inputs, step = stretch.inputs, stretch.step
    declared = stretch.axis.axis.parameters
    # Rounding may lead a parameter at a bound beyond it, with which nothing is simulated.
    own = np.clip(in_few_digits(own), [p.lower for p in declared], [p.upper for p in declared])
    alone = partial(simulate_lanes, stretch.axis, substeps=substeps, wanted=stretch.outputs)
    quiet = alone(own[None, :], inputs)
    white = float(in_few_digits(math.sqrt(max(stretch.noise**2 - step**2 / 12, 0.0))))
    noise = factor * random.normal(scale=white, size=(stretch.samples, count))
    away = factor * step * random.uniform(-0.5, 0.5, size=count)
    first = [float(values[0]) for values in inputs.signals]
    starts = [
        moved_start(stretch.axis, inputs.start, float(inputs.reference[0]), first, float(each))
        for each in away
    ]
    start = LoopStart(
        position=float(inputs.start.position) - noise[0],
        velocity=inputs.start.velocity,
        memory=None if inputs.start.memory is None else np.array([s.memory for s in starts]),
    )
    batch = alone(
        np.tile(own, (count, 1)),
        replace(inputs, reference=inputs.reference[:, None] + away, start=start),
        position_noise=away + (noise if inputs.clocks is None else inputs.clocks.held(noise)),
        resolution=step,
    )

    def changed(name: str) -> Array:
        out = batch[name]
        if name == "position":
            out = out + noise
            if step:
                out = np.floor((out + away) / step + 0.5) * step - away
        return out - quiet[name]

    return np.where(stretch.counted[:, None], stretch.rows(changed), 0.0)


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
