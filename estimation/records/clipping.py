"""Clipped samples of a control or a force: by the limit of the drive or of a recorder.

A clipped signal keeps its largest or smallest value, and enters and leaves it by steps. A signal
that is not clipped may keep its largest value as well: a smooth or quantised one approaches it
smoothly, an axis at standstill holds its control, a commanded profile follows straight ramps from
one set value to another, and a control that is written less often than the position keeps every
value for a while.
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

# smallest number of equal samples at an extreme of a clipped signal
_MIN_FLAT_SAMPLES = 3


def clipped(
    columns: RoleColumns, axis: Axis | None, *, masked: bool
) -> tuple[RoleColumns, list[str]]:
    """Return columns with clipped samples masked, and notes on clipped samples.

    The force is searched, or the control if there is no force. Samples are clipped at the extremes
    of the column or at the drive's limit. If clipped samples are masked, a repair reports them.
    Otherwise a note reports them, except for a control at the limit.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, each with its times.
    axis : Axis or None
        Axis with the drive's limit; None for an unlimited control.
    masked : bool
        True if clipped samples are masked.
    """
    role = "force" if "force" in columns.samples else "control"
    driven = columns.samples.get(role)
    values, cut = np.empty(0), np.zeros(0, dtype=bool)
    if driven is not None:
        values, cut = driven.values, _flat_tops(driven, columns.samples.get("position"))
    limit = axis.drive.limit if role == "control" and axis is not None else math.inf
    if masked:
        cut |= np.abs(values) >= limit * (1 - LIMIT_TOLERANCE.value)
    else:  # A flat top at the limit differs from it by the noise of a converter at most.
        cut &= np.abs(values) < 0.98 * limit
    count, extremes = int(cut.sum()), np.unique(values[cut])
    at = ""
    if 0 < len(extremes) < 3:
        at = f" (at {' and '.join(f'{each:.6g}' for each in extremes)})"
    if not masked:
        note = (
            f"the {role} is clipped in {count} samples{at}, perhaps by a recorder or a converter. "
            f"Unless the drive clips the {role}, leave these samples out with "
            'mask = "clipped" in run.toml'
        )
        return columns, [note] if count else []
    which = "none" if driven is None else f"{role} {count}{at}"
    repair = Repair(
        kind="clipped",
        count=count,
        text=f"clipped samples are masked, with the rows whose filters reach the samples: {which}",
    )
    masks = dict(columns.masks)
    if driven is not None:
        masks[role] = cut | masks.get(role, np.zeros_like(cut))
    return replace(columns.repaired({}, repair), masks=masks), []


def _flat_tops(driven: Samples, position: Samples | None) -> Mask:
    """Return True for samples of a control or a force that are clipped at an extreme, (N,).

    `position` are the samples of the position, with which standstill is excluded; None without a
    position.
    """
    signal = _Signal(driven.values)
    # Position at the samples of the signal, whose times may differ.
    moved = None if position is None else np.interp(driven.times, position.times, position.values)
    cut = [extreme for extreme in (signal.least, signal.most) if _is_cut(signal, extreme, moved)]
    # A signal that is clipped on one side is also clipped at the opposite value, even for a sample.
    opposite = [extreme for extreme in (signal.least, signal.most) if -extreme in cut]
    return np.isin(driven.values, [*cut, *opposite])


def _is_cut(signal: "_Signal", extreme: float, position: Array | None) -> bool:
    """Return True if a signal is clipped at its extreme, by the runs of samples with that value.

    Counted are runs of several samples that begin and end with a step while the axis moves. The
    signal is clipped if more than half of these runs are not the tops of commanded ramps.
    `position`, (N,), is the position of the axis at the samples of the signal; None without a
    position.
    """
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
    """A control or force, with the quantities by which clipping is recognised.

    Attributes
    ----------
    values : (N,) array
        Values of the signal, SI.
    kept_for : int
        Number of samples for which each value is held.
    quantum : float
        Quantisation step, or rounding if there is none.
    least, most : float
        Smallest and largest value.
    turns : (k,) array of int
        Samples at which the signal changes between rising, constant and falling.
    """

    def __init__(self, values: Array) -> None:
        self.values, self.kept_for = values, _samples_kept(values)
        self.quantum = quantisation_step(values) or rounding(values)
        self.least, self.most = float(values.min()), float(values.max())
        # Samples between steps of different signs, of which 0 is one.
        self.turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1

    def is_steep(self, start: int, stop: int) -> bool:
        """Return True if the signal steps before sample `start` and before sample `stop`.

        Both steps must be larger than those of a smooth signal, which are due to quantisation.
        """
        ends = [k for k in (start, stop) if 0 < k < len(self.values)]
        least = min((abs(self.values[k] - self.values[k - 1]) for k in ends), default=0.0)
        return float(least) > MAX_SMOOTH_STEP.value * self.quantum

    def is_set(self, start: int, stop: int) -> bool:
        """Return True if samples from `start` to before `stop` are the top of a commanded ramp.

        The samples are constant at an extreme. A ramp has straight lines before and after its top;
        a line is not needed on a side on which the log ends.
        """
        last = len(self.values) - 1
        before = int(self.turns[self.turns < start].max(initial=0))
        after = int(self.turns[self.turns >= stop].min(initial=last))
        rises = not start or self._is_straight(start, before, -1)
        return rises and (stop > last or self._is_straight(stop - 1, after, 1))

    def _is_straight(self, top: int, end: int, way: int) -> bool:
        """Return True if a straight line leads from a sample at an extreme to another held value.

        A short line of a few samples must end between the extremes; a longer ramp may end at any
        value. The corners of a ramp are at unknown places within its first and last sample.

        Parameters
        ----------
        top : int
            Sample at the extreme.
        end : int
            Sample at which the line ends.
        way : {-1, 1}
            Direction from the top to the end in time: -1 for earlier samples, 1 for later ones.
        """
        # The value must be constant beyond the end of the line.
        beyond = np.arange(end, end + way * _MIN_FLAT_SAMPLES * self.kept_for, way)
        kept = self.values[beyond[(beyond >= 0) & (beyond < len(self.values))]]
        if np.any(kept != kept[0]):
            return False
        inner = self.values[min(top, end) + 1 : max(top, end)]
        if len(inner) < 4:  # too few to show that they are straight
            return bool(self.least < self.values[end] < self.most)
        deviation = inner - np.linspace(inner[0], inner[-1], len(inner))
        return float(np.abs(deviation).max()) <= MAX_SMOOTH_STEP.value * self.quantum


def _samples_kept(values: Array) -> int:
    """Return the number of samples for which a value between the extremes is held; usually 1."""
    # Lengths of the runs of equal values, without the runs at the ends of the log.
    edges = np.flatnonzero(np.diff(values)) + 1
    inner = values[edges[:-1]]
    lengths = np.diff(edges)[(inner > values.min()) & (inner < values.max())]
    # A tenth of the values may be kept for fewer samples.
    return max(int(np.quantile(lengths, 0.1)), 1) if len(lengths) else 1


def _rests(position: Array | None, start: int, stop: int) -> bool:
    """Return True if the axis does not move from sample `start` to before sample `stop`.

    False without a position, or for fewer than 20 samples.
    """
    if position is None or stop - start < 20:
        return False
    quantum = quantisation_step(position) or rounding(position)
    return float(np.ptp(position[start:stop])) <= MAX_SMOOTH_STEP.value * quantum
