"""How far from its reference a loop may go before it is said to run away.

That is some multiple of what is asked of it: the way of the reference, and from the start to it.
Where that is next to nothing, other things move the axis: noise and counts of the encoder, and the
load at the start, to which the loop gives way until its control holds it.
"""

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopSettings
from axisid.support.arrays import Array

from .inputs import LoopInputs

_RUNAWAY_RATIO = 100.0  # distance from the reference, by what a loop is asked to move
_OFF = 1e-6  # of the reference from the position, for the loop's stiffness


def loop_settings(inputs: LoopInputs, substeps: int) -> LoopSettings:
    """How loops are run: beyond 100 times of what they are asked to move, they run away."""
    away = np.abs(inputs.start.position - inputs.reference[0])
    most = _RUNAWAY_RATIO * np.maximum(np.ptp(inputs.reference, axis=0), away)
    return LoopSettings(
        period=inputs.period,
        resolution=inputs.resolution,
        allowed=np.where(most > 0, most, np.inf),
        substeps=substeps,
    )


def widened_distance(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> float:
    """Where one loop runs away that more than its reference moves: load, noise, test signals.

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
    # At rest on its reference the loop gives way to the load there, and then to what is added: by
    # nothing where nothing is asked of it, without end where it answers nothing.
    asked = np.array([abs(loaded), added])
    answered = np.abs([(pushed - free) * (behind - still), controls[1] - controls[0]])
    with np.errstate(all="ignore"):
        ways = np.where(asked > 0, asked * _OFF / answered, 0.0)
    return _RUNAWAY_RATIO * max(float(ways.sum()), noise, inputs.resolution)


def _controls(axis: GeneratedAxis, position: float, *recorded: float) -> tuple[float, float]:
    """Control of an axis at rest on its reference, and a little behind it, at its most."""
    size = axis.functions["control_law"].size1_in("state")
    begin = axis.functions["control_start"](position, position, *recorded).full().ravel()
    read = position + np.array([[0.0, _OFF], [0.0, 0.0]])
    signals = np.repeat([[0.0], *([value] for value in recorded)], 2, axis=1)  # velocity first
    memory, answers = np.tile(begin[:size], (2, 1)), list[Array]()
    for _ in range(size + 2):  # a delay answers late
        control, memory = axis.evaluate("control_law", *read, *signals, memory)
        answers.append(control[:, 0])
    still, behind = max(answers, key=lambda pair: float(abs(pair[1] - pair[0])))
    return float(still), float(behind)
