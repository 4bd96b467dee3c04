"""How far from its reference a simulated loop may be before it counts as running away.

As far as some multiple of what is asked of it: the way of the reference, and from the start to it.
Where that is next to nothing, other things move the axis: noise and counts of the encoder, and the
load at the start, to which the loop gives way until its control holds it.
"""

import math
from collections.abc import Sequence

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.support.arrays import Array

_RUNAWAY_RATIO = 100.0  # distance from the reference, by what a loop is asked to move

Recorded = Sequence[Array] | Array

_OFF = 1e-6  # of the reference from the position, for the loop's stiffness


def allowed_distance(span: float, away: float) -> float:
    """Distance from the reference beyond which the loop has run away.

    Parameters
    ----------
    span : float
        Of the reference.
    away : float
        From the start to the first reference.
    """
    return _RUNAWAY_RATIO * max(float(span), float(away)) or math.inf


def widened_distance(
    axis: GeneratedAxis,
    parameters: Array,
    start: Array,
    noise: Array | None,
    injected: Array | None,
    resolution: float,
    recorded: Recorded = (),
) -> Array:
    """The same for what moves the axis but its reference, (B,): load, noise, counts, test signals.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (B, p) array
    start : (B,) array
    noise : (N,) or (N, B) array, optional
    injected : (N,) or (N, B) array, optional
        Added to the control.
    resolution : float
    recorded : (s,) or (s, B) array
        The first of the recorded signals.
    """
    measured = resolution if noise is None else np.maximum(np.ptp(noise, axis=0), resolution)
    drive, controls, pushed = axis.axis.drive, _by_lane(axis, start, recorded), np.zeros(1)
    if injected is not None or drive.deadband or drive.quantisation:
        # Up to so much of a command is lost.
        lost = drive.deadband + drive.quantisation / 2
        added = np.asarray(lost + (0.0 if injected is None else np.abs(injected).max(axis=0)))
        with np.errstate(all="ignore"):
            way = np.where(added == 0, 0.0, added * _OFF / np.abs(controls[1] - controls[0]))
        pushed = np.where(np.isfinite(way), way, np.inf)
    sag = _sag(axis, parameters, start, recorded, controls)
    return np.asarray(_RUNAWAY_RATIO * np.maximum(sag + pushed, measured))


def _by_lane(axis: GeneratedAxis, start: Array, recorded: Recorded) -> Array:
    """Controls at rest on the reference and a little behind it, (2, B)."""
    signals = [np.broadcast_to(values, len(start)) for values in recorded]
    lanes = zip(start, *signals, strict=True)
    return np.array([_controls(axis, *map(float, each)) for each in lanes]).T


def _sag(
    axis: GeneratedAxis, parameters: Array, start: Array, recorded: Recorded, controls: Array
) -> Array:
    """Way on which the loop, at rest on its reference, gives way to the load there, (B,).

    Infinite where the control does not answer to the distance from the reference.
    """
    drive = axis.functions["drive_force"]
    signals = [np.broadcast_to(values, len(start)) for values in recorded]
    twice = [np.vstack([values, values]) for values in (start, *signals)]
    forces = drive.call([controls, twice[0], 0.0, *twice[1:]])[0].full()
    stiffness = np.abs(forces[1] - forces[0]) / _OFF
    dynamics = axis.functions["direct_dynamics"]
    loaded, free, pushed = (
        dynamics.call(
            [start[None, :], 0.0, tau, 0.0, *(values[None, :] for values in signals), parameters.T]
        )[0].full()[0]
        for tau in (forces[0][None, :], 0.0, 1.0)
    )
    with np.errstate(all="ignore"):
        sag = np.abs(loaded / ((pushed - free) * stiffness))
    return np.where(np.isfinite(sag), sag, np.where(loaded == 0, 0.0, np.inf))


def _controls(axis: GeneratedAxis, position: float, *recorded: float) -> tuple[float, float]:
    """Control of an axis at rest on its reference, and a little behind it, at its most."""
    law, begin = axis.functions["control_law"], axis.functions["control_start"]
    memory = begin(position, position, *recorded)[: law.size1_in("state")]
    answers = []
    for reference in (position, position + _OFF):
        state, controls = memory, []
        for _ in range(memory.numel() + 2):  # a delay answers late
            control, state = law(reference, position, 0.0, *recorded, state)
            controls.append(float(control))
        answers.append(controls)
    still, behind = (np.array(each) for each in answers)
    largest = int(np.argmax(np.abs(behind - still)))
    return float(still[largest]), float(behind[largest])
