"""How the output of a simulated loop changes with what is added to its control.

A force that a model lacks acts as a control that is added does, but that the law does not give it:
so such slopes are those by forces of any shape along the simulated motion.
"""

from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.simulation import simulate_lanes
from axisid.support.arrays import Array

from .stretch import Stretch

#: Of what is to be added: by how much it is added and taken away for a slope.
ADDED_SHARE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A simulated motion at the rows of a stretch, or of windows of one, (N,) each.

    Attributes
    ----------
    record : int
        Of the records, from 0.
    time : array
        s, from the record's first sample.
    velocity, control : array
    windows : int
        Of one length, that it is of one after the other; the velocity jumps between them.
    """

    record: int
    time: Array
    velocity: Array
    control: Array
    windows: int = 1


def motion_of(stretch: Stretch, own: Array, time: Array, substeps: int | None) -> Motion | None:
    """The motion of a stretch with parameters (p,); None where it cannot be simulated."""
    wanted = ("velocity", "control")
    loop = simulate_lanes(
        stretch.axis, own[None, :], stretch.inputs, substeps=substeps, wanted=wanted
    )
    if loop.failures or stretch.inputs.clocks is not None:
        return None
    velocity, control = (loop[name][:, 0] for name in wanted)
    return Motion(
        record=stretch.record,
        time=time,
        velocity=velocity,
        control=control,
    )


def slopes_by_added(
    stretch: Stretch, own: Array, substeps: int | None, added: Array
) -> Array | None:
    """Slopes of a stretch's outputs by factors of what acts with its control, (n, k).

    Parameters
    ----------
    stretch, substeps
        As in `slopes_by_law`.
    own : (p,) array
    added : (N, k) array
        In the control's unit, and of its size.

    Returns
    -------
    (n, k) array or None
        None where a loop cannot be simulated.
    """
    slopes = injected_slopes(stretch, own, substeps, added)
    if slopes is None:
        return None
    for place, name in enumerate(stretch.outputs):
        if alone := own_part(stretch, name):
            counted = stretch.counted[place :: len(stretch.outputs), None]
            slopes[place :: len(stretch.outputs)] -= np.where(counted, alone * added, 0.0)
    return slopes


def injected_slopes(
    stretch: Stretch, own: Array, substeps: int | None, added: Array
) -> Array | None:
    """Slopes as the loop has them, with what is added in its control; None without a loop."""
    inputs, count = stretch.inputs, added.shape[1]
    # Of many columns what is copied costs more than the loops.
    lanes = np.empty((len(added), 2 * count))
    np.multiply(added, ADDED_SHARE, out=lanes[:, :count])
    np.negative(lanes[:, :count], out=lanes[:, count:])
    if inputs.injected is not None:
        lanes += inputs.injected[:, None]
    found = simulate_lanes(
        stretch.axis,
        np.tile(own, (lanes.shape[1], 1)),
        replace(inputs, injected=lanes),
        substeps=substeps,
        wanted=stretch.outputs,
    )
    if found.failures:
        return None
    more, less = np.split(stretch.rows(found.__getitem__), 2, axis=1)
    slopes = more - less
    slopes /= 2 * ADDED_SHARE
    slopes[~stretch.counted] = 0.0
    return np.asarray(slopes)


def own_part(stretch: Stretch, signal: str) -> float:
    """What of an added control a signal has in it without any motion."""
    gain = float(stretch.axis.axis.drive.gain)
    return {"control": 1.0, "force": gain}.get(signal, 0.0)
