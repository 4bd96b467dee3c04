"""How far from its reference a simulated loop may be before it counts as running away.

As far as some multiple of what is asked of it: the way of the reference, and from the start to it.
Where that is next to nothing, other things move the axis: noise and counts of the encoder, and the
load at the start, to which the loop gives way until its control holds it.
"""

import math

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.support.arrays import Array

from .inputs import LoopInputs

_RUNAWAY_RATIO = 100.0  # distance from the reference, by what a loop is asked to move

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


def widened_distance(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> float:
    """The same for what moves one loop but its reference: load, noise, counts, test signals.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs
        Of one loop.
    """
    place, signals = float(inputs.start.position), [*map(float, inputs.first_signals)]
    noise = 0.0 if inputs.noise is None else float(np.ptp(inputs.noise))
    drive, controls = axis.axis.drive, _controls(axis, place, *signals)
    # Up to so much of a command is lost.
    added = drive.deadband + drive.quantisation / 2
    added += 0.0 if inputs.injected is None else float(np.abs(inputs.injected).max())
    force, dynamics = axis.functions["drive_force"], axis.functions["direct_dynamics"]
    still, behind = (float(force(control, place, 0.0, *signals)) for control in controls)
    loaded, free, pushed = (
        float(dynamics(place, 0.0, tau, 0.0, *signals, parameters)) for tau in (still, 0.0, 1.0)
    )
    # At rest on its reference the loop gives way to the load there.
    sag = _way(abs(loaded), abs((pushed - free) * (behind - still)))
    way = sag + _way(added, abs(controls[1] - controls[0]))
    return _RUNAWAY_RATIO * max(way, noise, inputs.resolution)


def _way(asked: float, answered: float) -> float:
    """Distance at which a loop answers what is asked of it; infinite where it does not.

    Parameters
    ----------
    asked, answered : float
        What moves it, and what it answers to `_OFF` from its reference.
    """
    if asked == 0:
        return 0.0
    found = asked * _OFF / answered if answered else math.inf
    return found if math.isfinite(found) else math.inf


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
