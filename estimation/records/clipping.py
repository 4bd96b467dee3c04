"""Samples of a control or a force that were cut off: by the drive's limit or by a recorder.

A signal that is cut off keeps one value, its largest or smallest, and goes into and out of it by
steps. A right one may keep its largest value too: a smooth or quantised one glides into it, an axis
at rest holds its control, a commanded profile goes along straight ramps from one set value to
another, and a control that is written less often than the position keeps every value for a while.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from axisid.estimation.records.columns import Mask, RoleColumns
from axisid.estimation.tables import Repair, Samples
from axisid.estimation.thresholds import LIMIT_TOLERANCE, MAX_SMOOTH_STEP
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, runs

# equal samples at an extreme, from which a signal may have been cut off there
_MIN_FLAT_SAMPLES = 3


def clipped(columns: RoleColumns, axis: Axis | None) -> RoleColumns:
    """Columns with a mask of the samples of the control, or of a measured force, that are cut off.

    At its extreme or limit.

    Parameters
    ----------
    columns : RoleColumns
        Each with its clock.
    axis : Axis or None
        With the drive's limit.
    """
    samples, role = columns.samples, _driven(columns.samples)
    masks, count, said = {}, 0, "none"
    if role in samples:
        cut = _flat_tops(samples, role)
        cut |= np.abs(samples[role].values) >= _limit(role, axis) * (1 - LIMIT_TOLERANCE.value)
        masks, count = {role: cut}, int(cut.sum())
        said = f"{role} {count}{_at(samples[role].values, cut)}"
    text = f"clipped samples masked, with the rows whose filters reach them: {said}"
    made = columns.repaired({}, Repair(kind="clipped", count=count, text=text))
    return replace(made, masks=masks)


def clipping_notes(samples: Mapping[str, Samples], axis: Axis | None) -> list[str]:
    """What is said of a control or a force that is cut off, but for a control at the limit."""
    role = _driven(samples)
    if role not in samples:
        return []
    values, cut = samples[role].values, _flat_tops(samples, role)
    # A flat top that is at the limit is off it by a converter's noise at most.
    cut &= np.abs(values) < 0.98 * _limit(role, axis)
    if not cut.any():
        return []
    return [
        f"the {role} is cut off in {int(cut.sum())} samples{_at(values, cut)}, as by a recorder or "
        'a converter: if the drive did not, leave them out with mask = "clipped" in run.toml'
    ]


def _at(values: Array, mask: Mask) -> str:
    """The values that were masked, where these are few."""
    kept = np.unique(values[mask])
    return f" (at {' and '.join(f'{value:.6g}' for value in kept)})" if 0 < len(kept) <= 2 else ""


def _driven(samples: Mapping[str, Samples]) -> str:
    return "force" if "force" in samples else "control"


def _limit(role: str, axis: Axis | None) -> float:
    """The drive's limit of a role's values; infinite where there is none."""
    return axis.drive.limit if role == "control" and axis is not None else math.inf


def _flat_tops(samples: Mapping[str, Samples], role: str) -> Mask:
    """Samples at an extreme at which a role's signal is cut off, (N,)."""
    own, position = samples[role], samples.get("position")
    values, signal = own.values, _Signal(own.values)
    there = None
    if position is not None:
        there = np.interp(own.times, position.times, position.values)
    cut = [extreme for extreme in (signal.least, signal.most) if _is_cut(signal, extreme, there)]
    # What is cut off on one side is so on the other at the same value, be it for a sample.
    either = [side for side in (signal.least, signal.most) if -side in cut]
    return np.isin(values, [*cut, *either])


def _is_cut(signal: "_Signal", extreme: float, position: Array | None) -> bool:
    flat = [
        (start, stop)
        for start, stop in runs(signal.values == extreme)
        if stop - start >= _MIN_FLAT_SAMPLES * signal.held
        and not _rests(position, start, stop)
        and signal.is_steep(start, stop)
    ]
    commanded = sum(signal.is_set(start, stop) for start, stop in flat)
    return 2 * commanded < len(flat)


class _Signal:
    """A signal around the runs at its extremes."""

    def __init__(self, values: Array) -> None:
        self.values, self.quantum, self.held = values, _finest(values), _held(values)
        self.least, self.most = float(values.min()), float(values.max())
        signs = np.sign(np.diff(values))
        self.turns = np.flatnonzero(np.diff(signs)) + 1  # samples between steps of other signs

    def is_steep(self, start: int, stop: int) -> bool:
        """Whether a run begins and ends by more than a smooth signal's rounding."""
        ends = [
            abs(self.values[k] - self.values[k - 1])
            for k in (start, stop)
            if 0 < k < len(self.values)
        ]
        return min(ends, default=0.0) > MAX_SMOOTH_STEP.value * self.quantum

    def is_set(self, start: int, stop: int) -> bool:
        """Whether a run is one of a commanded profile, which goes straight from value to value."""
        last = len(self.values) - 1
        before = int(self.turns[self.turns < start].max(initial=0))
        after = int(self.turns[self.turns >= stop].min(initial=last))
        ramps = [(start, before, -1)] if start else []
        ramps += [(stop - 1, after, 1)] if stop <= last else []
        return all(self._is_straight(*ramp) for ramp in ramps)

    def _is_straight(self, top: int, end: int, way: int) -> bool:
        """Whether the signal goes straight from a sample at an extreme to another value it keeps.

        In a few samples to one between the extremes, or along a ramp of more to any. Where in its
        first and last sample a ramp has its corners is not known.
        """
        beyond = np.arange(end, end + way * _MIN_FLAT_SAMPLES * self.held, way)
        kept = self.values[beyond[(beyond >= 0) & (beyond < len(self.values))]]
        if np.any(kept != kept[0]):
            return False
        inner = self.values[min(top, end) + 1 : max(top, end)]
        if len(inner) < 4:  # too few to show that they are straight
            return bool(self.least < self.values[end] < self.most)
        off = inner - np.linspace(inner[0], inner[-1], len(inner))
        return float(np.abs(off).max()) <= MAX_SMOOTH_STEP.value * self.quantum


def _finest(values: Array) -> float:
    """What the values are rounded to, if only as floating point numbers are."""
    return quantisation_step(values) or _rounding(values)


def _rounding(values: Array) -> float:
    return 8 * float(np.finfo(float).eps * np.abs(values).max(initial=0.0))


def quantisation_step(values: Array, fewest: int = 1) -> float:
    """What the values are rounded to: the least difference of two, if others are multiples of it.

    Else 0, as where fewer than so many differences tell it.
    """
    apart = np.diff(np.unique(values))
    apart = apart[apart > _rounding(values)]
    least = float(apart.min(initial=np.inf))
    few = apart[apart < 5 * least] / least  # larger ones do not tell
    whole = np.abs(few - np.round(few)) < 0.15  # as decimals leave them
    enough = np.isfinite(least) and len(few) >= fewest
    return least if enough and np.mean(whole) > 0.9 else 0.0


def _held(values: Array) -> int:
    """Samples for which each value is kept, between the extremes; one of a control of every row."""
    edges = np.flatnonzero(np.diff(values)) + 1
    inner = values[edges[:-1]]
    lengths = np.diff(edges)[(inner > values.min()) & (inner < values.max())]
    # A tenth of the values may be kept for less long.
    return max(int(np.quantile(lengths, 0.1)), 1) if len(lengths) else 1


def _rests(position: Array | None, start: int, stop: int) -> bool:
    """Whether the axis does not move during a run of samples."""
    if position is None or stop - start < 20:
        return False
    return float(np.ptp(position[start:stop])) <= MAX_SMOOTH_STEP.value * _finest(position)
