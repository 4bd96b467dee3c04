"""Samples of a control or a force that were cut off: by the drive's limit or by a recorder.

A signal that is cut off keeps one value, its largest or smallest, and goes into and out of it by
steps. A right one may keep its largest value too: a smooth or quantised one glides into it, an axis
at rest holds its control, a commanded profile goes along straight ramps from one set value to
another, and a control that is written less often than the position keeps every value for a while.
"""

import math
from dataclasses import replace

import numpy as np

from axisid.estimation.raw_tables import Repair, Samples
from axisid.estimation.records.columns import Mask, RoleColumns
from axisid.estimation.thresholds import LIMIT_TOLERANCE, MAX_SMOOTH_STEP
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, runs

from .quantisation import quantisation_step, rounding

# equal samples at an extreme, from which a signal may have been cut off there
_MIN_FLAT_SAMPLES = 3


def clipped(
    columns: RoleColumns, axis: Axis | None, *, masked: bool
) -> tuple[RoleColumns, list[str]]:
    """Columns with a mask of the samples of a measured force, or of the control, that are cut off.

    At its extreme or limit. Where none is asked for, what is said of those that are cut off, but
    for a control at the limit.

    Parameters
    ----------
    columns : RoleColumns
        Each with its clock.
    axis : Axis or None
        With the drive's limit.
    masked : bool
        Whether they are left out.
    """
    role = "force" if "force" in columns.samples else "control"
    driven = columns.samples.get(role)
    values, cut = np.empty(0), np.zeros(0, dtype=bool)
    if driven is not None:
        values, cut = driven.values, _flat_tops(driven, columns.samples.get("position"))
    limit = axis.drive.limit if role == "control" and axis is not None else math.inf
    if masked:
        cut |= np.abs(values) >= limit * (1 - LIMIT_TOLERANCE.value)
    else:  # A flat top that is at the limit is off it by a converter's noise at most.
        cut &= np.abs(values) < 0.98 * limit
    count, extremes = int(cut.sum()), np.unique(values[cut])
    at = (
        f" (at {' and '.join(f'{each:.6g}' for each in extremes)})" if 0 < len(extremes) < 3 else ""
    )
    if not masked:
        note = (
            f"the {role} is clipped in {count} samples{at}, perhaps by a recorder or a converter. "
            'Unless the drive clips it, leave the samples out with mask = "clipped" in run.toml'
        )
        return columns, [note] if count else []
    which = "none" if driven is None else f"{role} {count}{at}"
    repair = Repair(
        kind="clipped",
        count=count,
        text=f"clipped samples masked, with the rows whose filters reach them: {which}",
    )
    masks = dict(columns.masks)
    if driven is not None:
        masks[role] = cut | masks.get(role, np.zeros_like(cut))
    return replace(columns.repaired({}, repair), masks=masks), []


def _flat_tops(driven: Samples, position: Samples | None) -> Mask:
    """Samples at an extreme at which a control or a force is cut off, (N,)."""
    signal = _Signal(driven.values)
    there = None if position is None else np.interp(driven.times, position.times, position.values)
    cut = [extreme for extreme in (signal.least, signal.most) if _is_cut(signal, extreme, there)]
    # What is cut off on one side is so on the other at the same value, be it for a sample.
    opposite = [extreme for extreme in (signal.least, signal.most) if -extreme in cut]
    return np.isin(driven.values, [*cut, *opposite])


def _is_cut(signal: "_Signal", extreme: float, position: Array | None) -> bool:
    flat = [
        (start, stop)
        for start, stop in runs(signal.values == extreme)
        if stop - start >= _MIN_FLAT_SAMPLES * signal.kept_for
        and not _rests(position, start, stop)
        and signal.is_steep(start, stop)
    ]
    commanded = sum(signal.is_set(start, stop) for start, stop in flat)
    return 2 * commanded < len(flat)


class _Signal:
    """A signal around the runs at its extremes."""

    def __init__(self, values: Array) -> None:
        self.values, self.kept_for = values, _samples_kept(values)
        self.quantum = quantisation_step(values) or rounding(values)
        self.least, self.most = float(values.min()), float(values.max())
        # Samples between steps of other signs.
        self.turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1

    def is_steep(self, start: int, stop: int) -> bool:
        """Return whether a run begins and ends by more than a smooth signal's rounding."""
        ends = [k for k in (start, stop) if 0 < k < len(self.values)]
        least = min((abs(self.values[k] - self.values[k - 1]) for k in ends), default=0.0)
        return float(least) > MAX_SMOOTH_STEP.value * self.quantum

    def is_set(self, start: int, stop: int) -> bool:
        """Return whether a run belongs to a commanded profile, straight between values."""
        last = len(self.values) - 1
        before = int(self.turns[self.turns < start].max(initial=0))
        after = int(self.turns[self.turns >= stop].min(initial=last))
        rises = not start or self._is_straight(start, before, -1)
        return rises and (stop > last or self._is_straight(stop - 1, after, 1))

    def _is_straight(self, top: int, end: int, way: int) -> bool:
        """Whether the signal goes straight from a sample at an extreme to another value it keeps.

        In a few samples to one between the extremes, or along a ramp of more to any. Where in its
        first and last sample a ramp has its corners is not known.
        """
        beyond = np.arange(end, end + way * _MIN_FLAT_SAMPLES * self.kept_for, way)
        kept = self.values[beyond[(beyond >= 0) & (beyond < len(self.values))]]
        if np.any(kept != kept[0]):
            return False
        inner = self.values[min(top, end) + 1 : max(top, end)]
        if len(inner) < 4:  # too few to show that they are straight
            return bool(self.least < self.values[end] < self.most)
        off = inner - np.linspace(inner[0], inner[-1], len(inner))
        return float(np.abs(off).max()) <= MAX_SMOOTH_STEP.value * self.quantum


def _samples_kept(values: Array) -> int:
    """Samples for which each value is kept, between the extremes; one of a control of every row."""
    edges = np.flatnonzero(np.diff(values)) + 1
    inner = values[edges[:-1]]
    lengths = np.diff(edges)[(inner > values.min()) & (inner < values.max())]
    # A tenth of the values may be kept for less long.
    return max(int(np.quantile(lengths, 0.1)), 1) if len(lengths) else 1


def _rests(position: Array | None, start: int, stop: int) -> bool:
    """Return whether the axis does not move during a run of samples."""
    if position is None or stop - start < 20:
        return False
    quantum = quantisation_step(position) or rounding(position)
    return float(np.ptp(position[start:stop])) <= MAX_SMOOTH_STEP.value * quantum
