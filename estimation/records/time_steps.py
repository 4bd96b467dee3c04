"""Steps of a time column: which are gaps, where the clock goes back, how far the period drifts."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array
from axisid.support.errors import DataError

#: A longer step is a gap, in sampling periods.
LARGEST_GAP = 1.5
#: The same in median steps where time may be uneven: that is bridged, missing time is not.
UNEVEN_GAP = 3.0
#: Steps over which jitter averages out: even a quarter of a period to half a percent.
WINDOW = 100
_RARE = 0.01  # share of the steps that may be gaps; more are jitter
_UNEVEN = 0.02  # mean step against the median one, and of any window against that of all
_DRIFTS = 0.005  # range of the mean steps of windows
_EVEN = 0.02  # range of the steps, in periods, below which nothing is said
_ON = 4.0  # periods after which a clock that was set back is counted on: more than any gap needs
_SHOWN = 3

Places = NDArray[np.int64]


def odd_steps(steps: Array, typical: float) -> NDArray[np.bool_]:
    """Which steps are not about the typical one."""
    return (steps > LARGEST_GAP * typical) | (steps * LARGEST_GAP < typical)


def is_rare(count: int, steps: int) -> bool:
    """Whether so many steps of all may be faults of single samples, and no jitter."""
    return count <= max(_RARE * steps, 1)


def advice_on_uneven(steps: Array, typical: float) -> str:
    """What to do about steps of which some are odd.

    Parameters
    ----------
    steps : (n,) array
        All of them, s, positive.
    typical : float
        Their median, s.
    """
    odd = steps[odd_steps(steps, typical)]
    lost = bool(np.any(odd > UNEVEN_GAP * typical))
    if not is_rare(len(odd), len(steps)):
        how = "--resample auto --gaps split" if lost else "--resample auto"
        cut = ", cut where samples are missing" if lost else ""
        return f"That is jitter, no gaps: resample the log evenly{cut} ({how})."
    if lost or np.any(odd < typical):
        return "Cut the log there (--gaps split)."
    return "Cut the log there (--gaps split) or resample it evenly (--resample auto)."


def advice_on_backward(time: Array, *, split: bool = False) -> str:
    """What to do about times, (N,), that do not increase; `split` where that was asked for."""
    steps = np.diff(time)
    back = int(np.sum(steps <= 0))
    if is_coarse(time):
        return (
            "The stamps are too coarse: export them with more digits, or give --sample-period to "
            f"count by ({(time[-1] - time[0]) / len(steps):.6g} s in their mean)."
        )
    in_order = np.diff(np.sort(time))
    if np.all(in_order > 0) and not np.any(odd_steps(in_order, float(np.median(in_order)))):
        return "Sort the rows by their time."
    if not is_rare(back, len(steps)):
        return "Sort the rows and remove repeated ones."
    if split:
        return "The columns have clocks of their own: cut the file there, and read one piece."
    twice = " Remove rows that are repeated." if np.any(steps == 0) else ""
    return (
        "Where the clock was set back or another log was joined on, cut the log there (--gaps "
        f"split).{twice}"
    )


def is_coarse(time: Array) -> bool:
    """Whether times stand still too often to be a fault of single rows: too few digits."""
    steps = np.diff(time)
    return bool(np.all(steps >= 0)) and not is_rare(int(np.sum(steps == 0)), len(steps))


def counted_by(time: Array, period: float) -> tuple[Array, str]:
    """Coarse times replaced by a count of the period, s, and what is said of it.

    They must be those times but for their digits; what is not coarse stays as it is.
    """
    if not (np.all(np.isfinite(time)) and is_coarse(time)):
        return time, ""
    counted = time[0] + period * np.arange(len(time), dtype=np.float64)
    tick = float(np.diff(time).max())
    if np.any(np.abs(time - counted) > tick + period):
        return time, ""
    return counted, (
        f"time stamps that step by 0 to {1e3 * tick:.6g} ms replaced by a count of the sampling "
        "period that was given"
    )


def counted_on(time: Array, *, uneven: bool) -> tuple[Array, int, str]:
    """Times that go on where the clock was set back, how often that was, and what is said of it.

    There a gap is made of a few periods, so that the log is cut; how much time passed is not known.
    Steps back that are no faults of single places are left, for whoever needs time to increase.

    Parameters
    ----------
    time : (N,) array
        s; what is not finite is passed over.
    uneven : bool
        Whether short steps may be jitter; else a rare one is a clock that was set back a little.
    """
    rows = np.flatnonzero(np.isfinite(time))
    known = time[rows]
    steps = np.diff(known)
    typical = float(np.median(steps)) if len(steps) else 0.0
    back = steps <= 0 if uneven else steps * LARGEST_GAP < typical
    places = np.flatnonzero(back)
    if not places.size or not typical > 0 or not is_rare(len(places), len(steps)):
        return time, 0, ""
    shifts = np.zeros(len(time))
    shifts[rows[places + 1]] = _ON * typical - steps[places]
    shown = [
        f"before data row {rows[k + 1] + 1}, from {known[k]:.9g} s to {known[k + 1]:.9g} s"
        for k in places[:_SHOWN]
    ]
    more = [f"{len(places) - _SHOWN} more"] if len(places) > _SHOWN else []
    times = "once" if len(places) == 1 else f"{len(places)} times"
    text = f"the clock is set back {times} ({'; '.join(shown + more)}): cut there, and counted on"
    return time + np.cumsum(shifts), len(places), text


def open_end(pieces: Sequence[Array]) -> float:
    """What jitter leaves open of the mean step of segments, the times of each (n,), relative."""
    steps = np.concatenate([np.diff(piece) for piece in pieces])
    total = float(np.sum(steps)) if len(steps) else 0.0
    return len(pieces) * float(np.ptp(steps)) / total if total > 0 else 0.0


class Drift:
    """Mean steps of windows of 100 samples, of segments read whole or block by block."""

    def __init__(self) -> None:
        self.least, self.most = np.inf, 0.0
        self._last: float | None = None
        self._seen = 0

    def add(self, time: Array) -> None:
        """Take the next samples of a segment."""
        ends = time[-self._seen % WINDOW :: WINDOW]
        self._seen += len(time)
        if not len(ends):
            return
        before = [] if self._last is None else [self._last]
        means = np.diff(np.concatenate([before, ends])) / WINDOW
        self._last = float(ends[-1])
        self.least = min(self.least, float(means.min(initial=np.inf)))
        self.most = max(self.most, float(means.max(initial=0.0)))

    def end(self) -> None:
        """The segment ends."""
        self._last, self._seen = None, 0

    def check(self, source: str, mean: float, advice: str) -> None:
        """Refuse a period, s, that is not that of every part of the log."""
        if self.most > mean * (1 + _UNEVEN) or self.least < mean * (1 - _UNEVEN):
            raise DataError(f"{source}: {self._found()}, which cannot be taken as even. {advice}")

    def told(self, mean: float, spread: float) -> str:
        """What is said of a period that drifts a little; empty where it does not.

        Jitter moves the ends of a window by a part of the `spread` of the steps, s.
        """
        if self.most - self.least <= _DRIFTS * mean + spread / WINDOW:
            return ""
        return f"{self._found()} and is taken as even: resample the log evenly (--resample auto)"

    def _found(self) -> str:
        return (
            f"the sampling period drifts from {1e3 * self.least:.6g} to {1e3 * self.most:.6g} ms "
            f"(means over {WINDOW} samples)"
        )


def steps_told(least: float, most: float, mean: float, drift: Drift) -> tuple[str, ...]:
    """What is said of time steps that are taken as even but are not quite; empty if they are."""
    if said := drift.told(mean, most - least):
        return (said,)
    if most - least <= _EVEN * abs(mean):
        return ()
    steps = f"{1e3 * least:.6g} to {1e3 * most:.6g} ms"
    return (f"time steps of {steps} taken as even, {1e3 * mean:.6g} ms each",)


def drift_of(pieces: Sequence[Array]) -> Drift:
    """Drift over segments, the times of each (n,)."""
    drift = Drift()
    for piece in pieces:
        drift.add(piece)
        drift.end()
    return drift
