"""What a log leaves open of a law that is evaluated between its samples.

There the position is taken by a cubic spline. What that misses is the noise that the law measured,
and a motion faster than the log: how much the control may differ by them is measured, with noise of
the same size added to the positions, and with every second sample left out of the spline.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import (
    between,
    control_along,
    law_ticks,
    position_noise,
    start_of_law,
    two_clocks,
)
from axisid.estimation.records import Record
from axisid.support.arrays import relative_error_percent

_COINCIDES = 1e-6  # of a sample


def left_open_percent(axis: GeneratedAxis, record: Record, used: NDArray[np.bool_]) -> float:
    """How far the control of a right law may be from the recorded one, percent of that.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        Of one piece, with a reference and a control.
    used : (N,) array of bool
        Samples that are compared.

    Returns
    -------
    float
        0 where law and log have one clock, or the law reads samples of the log alone.
    """
    whole = (0, len(record))
    clocks = two_clocks(axis, record, whole)
    if clocks is None:
        return 0.0
    ticks = law_ticks(axis, record, whole)
    start = start_of_law(axis, record, whole, ticks)
    if np.allclose(clocks.times, np.round(clocks.times), rtol=0, atol=_COINCIDES):
        return 0.0  # every position that the law read is in the log
    noise = position_noise(record.position) * np.random.default_rng(0).normal(size=len(ticks))
    undisturbed = control_along(axis, ticks, start)
    off = [
        control_along(axis, replace(ticks, position=position), start) - undisturbed
        for position in (ticks.position + noise, between(record.position[::2], clocks.times / 2))
    ]
    control = np.asarray(record.control)
    by_noise, by_spline = (relative_error_percent(each[used], control[used]) for each in off)
    return float(np.hypot(by_noise, by_spline))
