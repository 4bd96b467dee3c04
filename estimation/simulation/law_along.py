"""The control law by itself, along recorded signals."""

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.runtime import by_sample
from axisid.modeling.declaration import ControlLaw
from axisid.modeling.quantities import MEASURED_VELOCITY
from axisid.support.arrays import Array


def takes_velocity(law: ControlLaw) -> bool:
    """Whether a law takes the velocity of a sensor of its own, which no record has."""
    following = [memory.following for memory in law.memory]
    return any(e.has(MEASURED_VELOCITY) for e in (law.output, *following))


def law_along(axis: GeneratedAxis, reference: Array, position: Array, velocity: Array) -> Array:
    """The control law's terms along recorded signals, (N, terms), when they are applied.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    reference, position, velocity : (N,) array
        What the law measured.
    """
    declared = axis.axis.control
    delay = 0 if declared is None else declared.delay
    law, terms = axis.functions["control_law"], axis.functions["control_terms"]
    start = axis.functions["control_start"](reference[0], position[0]).full()
    signals = [values[None, :] for values in (reference, position, velocity)]
    states = np.zeros((len(start), len(reference)))
    if len(start):
        # The state comes first in and first out, so that the function can be run along the samples.
        along = law.slice("law", [3, 0, 1, 2], [1]).mapaccum(len(reference))
        states = np.hstack([start, along(start, *signals).full()[:, :-1]])
    rows = by_sample(terms.call([*signals, states])[0].full(), len(reference))
    return np.concatenate([np.repeat(rows[:1], delay, axis=0), rows[: len(rows) - delay]])
