"""Spikes: samples that leave a signal for a moment and come back, with where and how large.

They are looked for against the median of their neighbours, which steps, kinks and slow motion leave
where it is; what counts as large is told by how the signal bends elsewhere.
"""

from collections.abc import Mapping

import numpy as np

from axisid.estimation.tables import Samples
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.remedy import Note, Remedy, Setting

# times the second difference that is seldom exceeded, from the median about a sample
_MIN_SPIKE = 10.0
_SELDOM_EXCEEDED = 0.995  # quantile of the second differences
# windows of a spike's median; fewer do not tell how the signal bends elsewhere
_MIN_SPIKE_WINDOWS = 10
_MIN_SPIKE_TIP = 0.25  # of the least spike, in second difference at its tip
# of the signal's range: where hardly anything moves nothing else is a measure
_MIN_SPIKE_SHARE = 1e-3
_MAX_STEP_BESIDE_SPIKE = 0.2  # of a spike, for the steps beside it: the signal is quiet there
_MAX_STEP_ACROSS_SPIKE = 0.5  # of a spike, between its two sides: it is no step

_REACH = 3  # samples to each side that a spike's median is of; it is shorter than that
_BEYOND = 2  # samples beyond them, over which the signal is to be quiet
_SHOWN = 3


def spike_notes(samples: Mapping[str, Samples], axis: Axis | None, *, numbered: bool) -> list[Note]:
    """What is said of spikes in the measured columns of a log.

    Parameters
    ----------
    samples : mapping of str to Samples
        By role, SI, each with its clock.
    axis : Axis, optional
        For the units.
    numbered : bool
        Whether the samples are the log's rows, so that these can be named.
    """
    units = {
        "position": "m or rad" if axis is None else axis.coordinate.unit,
        "velocity": "" if axis is None else str(axis.coordinate.velocity_unit),
        "control": "" if axis is None else axis.drive.unit,
        "force": "" if axis is None else axis.coordinate.force_unit,
    }
    sentences = []
    for role, unit in units.items():
        found = spikes(samples[role].values) if role in samples else []
        if not found:
            continue
        clock = samples[role].clock
        shown = [
            f"by {size:+.4g} {unit}".rstrip()
            + (f" in data row {place + 1}" if numbered else "")
            + ("" if clock is None else f" at {clock[place]:.9g} s")
            for place, size in found[:_SHOWN]
        ]
        more = f" and {len(found) - _SHOWN} more times" if len(found) > _SHOWN else ""
        sentences.append(
            Note(
                f"the {role} leaves its course for a moment, {', '.join(shown)}{more}: if that is "
                "no motion, ",
                Remedy.of("empty such cells and add ", Setting("resample", "auto")),
            )
        )
    return sentences


def spikes(values: Array) -> list[tuple[int, float]]:
    """Samples at which spikes of (N,) values are largest, and by how much, the largest first."""
    around = 2 * _REACH + 1
    if len(values) < _MIN_SPIKE_WINDOWS * around:
        return []
    bends = np.abs(np.diff(values, 2))
    least = max(
        _MIN_SPIKE * float(np.quantile(bends, _SELDOM_EXCEEDED)),
        _MIN_SPIKE_SHARE * float(np.ptp(values)),
    )
    # A spike bends at its tip by as much as it is large, or nearly.
    tips = np.flatnonzero(bends > _MIN_SPIKE_TIP * least) + 1
    places = np.unique((tips[:, None] + np.arange(-_REACH, _REACH + 1)).ravel())
    places = places[(places >= _REACH) & (places < len(values) - _REACH)]
    windows = np.lib.stride_tricks.sliding_window_view(values, around)
    middles = np.median(windows[places - _REACH], axis=1)
    off = dict(zip(places, values[places] - middles, strict=True))
    found = [
        (int(place), float(values[place] - (values[place - _REACH] + values[place + _REACH]) / 2))
        for place, size in off.items()
        if abs(size) > least
        and all(abs(size) >= abs(off.get(place + k, 0.0)) for k in range(-_REACH, _REACH + 1))
        and _is_quiet(values, int(place), abs(float(size)))
    ]
    return sorted(found, key=lambda spike: -abs(spike[1]))


def _is_quiet(values: Array, place: int, size: float) -> bool:
    """Whether the signal goes on after a spike as before it, but for a part of its size."""
    before = values[max(place - _REACH - _BEYOND, 0) : place - _REACH + 1]
    after = values[place + _REACH : place + _REACH + _BEYOND + 1]
    if len(before) < 2 or len(after) < 2:
        return False
    steps = np.concatenate([np.diff(before), np.diff(after)])
    slope = float(steps.mean())
    across = float(after[0] - before[-1]) - 2 * _REACH * slope
    return (
        float(np.abs(steps - slope).max()) <= _MAX_STEP_BESIDE_SPIKE * size
        and abs(across) <= _MAX_STEP_ACROSS_SPIKE * size
    )
