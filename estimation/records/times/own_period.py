"""The sampling period of a log whose times are uneven: jitter, and samples that were lost."""

import numpy as np

from axisid.estimation.thresholds import MAX_UNEVEN_STEP
from axisid.support.arrays import Array

# sum of the stamps' unit phases, by that of as many random ones, from which a rate is the
# clock's: measured, the largest of a thousand such sums of random phases
_MIN_PHASE_SUM = 3.5
# of a mean time step, where nothing tells how many samples were lost
_LOST_PERIOD_UNCERTAINTY = 0.1

_FIRST, _MORE, _MOST = 1024, 4, 65_536  # samples that are looked at, at once, times, at most
_NEAR = 0.25  # of the guess: how far the rate may be from it
_FINE = 0.25  # of a turn over all samples: the step of the rates that are tried


def own_period(clock: Array) -> tuple[float, float]:
    """Sampling period of an uneven clock, s, and what is open of it, relative.

    It is the one at which the times of the longest piece have one phase, whatever was lost of it.
    Where jitter leaves none, it is the mean step.
    """
    steps = np.diff(clock)
    typical = float(np.median(steps))
    longest_step = MAX_UNEVEN_STEP.value * typical
    edges = np.concatenate([[0], np.flatnonzero(steps > longest_step) + 1, [len(clock)]])
    longest = int(np.argmax(np.diff(edges)))
    piece = clock[edges[longest] : edges[longest + 1]]
    period = _in_phase(piece, typical)
    if period is not None:
        off = np.diff(piece) / period
        return period, float(np.ptp(off - np.round(off))) * period / float(piece[-1] - piece[0])
    return float(np.mean(steps[steps <= longest_step])), _LOST_PERIOD_UNCERTAINTY


def _in_phase(time: Array, guess: float) -> float | None:
    """Period near a guess at which times have about one phase, s; None where there is none."""
    time, count = time - time[0], min(_FIRST, len(time))
    rate, reach = 1 / guess, _NEAR / guess
    while True:
        some = time[:count]
        step = _FINE / float(some[-1])
        rates = rate + step * np.arange(-np.ceil(reach / step), np.ceil(reach / step) + 1)
        sums = np.abs([np.exp(2j * np.pi * r * some).sum() for r in rates])
        if sums.max() < _MIN_PHASE_SUM * np.sqrt(count):
            return None
        rate, reach = float(rates[np.argmax(sums)]), 2 * step
        if count == len(time) or count >= _MOST:
            return 1 / (rate + _slope(some, rate))
        count = min(_MORE * count, len(time))


def _slope(time: Array, rate: float) -> float:
    """How the phase of times at a rate grows, turns/s: by how much the rate is too low."""
    turns = rate * time
    middle = float(np.angle(np.exp(2j * np.pi * turns).sum())) / (2 * np.pi)
    phase = turns - middle - np.round(turns - middle)
    from_mean = time - time.mean()
    return -float(from_mean @ phase / (from_mean @ from_mean))
