"""A measured column against what it should be, whatever the model: a factor, a delay, a constant.

Either may be noisy. The factor of a regression is then too small, and the inverse of the other
way's too large, so that the truth lies between the two [Frisch1934]_. A delay is found by moving
the computed column until the regression asks for no more: there noise has nothing to attenuate.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d, shift

from axisid.estimation.records import Record
from axisid.estimation.regression import Hac, Solution, factor, least_squares
from axisid.estimation.signals import Neighbours, Prefilter, SampledFilter
from axisid.estimation.tables import label_unit
from axisid.estimation.thresholds import (
    COMPARISON_CUTOFF,
    MAX_SCALE_ERROR,
    MIN_DISTANCE_FROM_NOISE,
)
from axisid.support.arrays import Array, covered
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing
from axisid.support.remedy import Remedy, Setting

# Hz, up to which columns are compared: far below any current loop's bandwidth
_MAX_CUTOFF = 30.0
# samples, by those in which the low-pass settles; fewer are not compared
_MIN_SETTLING_TIMES = 10
MAX_COLUMN_DELAY = 0.35  # samples: as much as the force may be misaligned
MAX_COLUMN_OFFSET = 0.01  # constant between the two, by the computed one's root mean square
# % of the computed one, left by factor, delay and constant; from there on the column is another
# signal, as noise in the band is far less
_MAX_DIFFERENCE = 30.0

_OFTEN = 4  # rows in a period of the highest frequency that is left
_STEPS, _STILL = 12, 1e-3  # of the search for the delay, samples
_TINY = 1e-300
_FARTHEST = 50.0  # samples of delay that are looked for
#: That a column may be in though nobody said so, the likelier before.
_UNITS = (
    *("bar", "mbar", "kPa", "MPa", "mV", "kV", "mA", "kN", "mm", "deg", "min"),
    *("mm/s", "cm/s", "m/min", "mm/min", "rpm", "deg/s", "rev/s"),
    *("mm/s^2", "cm/s^2", "g", "deg/s^2", "rev/s^2"),
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LowPassed:
    """Two columns of a record, low-passed alike, in the rows that tell all that is left of them.

    Attributes
    ----------
    computed, measured : (N,) array
    rows : (n,) array of int
        Which of the samples: what is slow needs no more.
    step : int
        From one to the next.
    """

    computed: Array
    measured: Array
    rows: NDArray[np.int64]
    step: int

    @classmethod
    def of(
        cls, record: Record, computed: Array, measured: Array, times: int = 0
    ) -> "LowPassed | Missing":
        """Of a record of one piece; the computed one is differentiated so many times."""
        period = record.period
        cutoff = min(COMPARISON_CUTOFF.value / period, _MAX_CUTOFF)
        settle = round(1 / (cutoff * period))
        used = minimum_filter1d(unmasked(record), 2 * settle + 1, mode="constant", cval=0)
        if used.sum() < _MIN_SETTLING_TIMES * settle:
            return Missing("too few samples that follow one another were measured for it")
        smooth = SampledFilter(Prefilter(cutoff=cutoff), period)
        computed, measured = smooth.low_passed(computed), smooth.low_passed(measured)
        for _ in range(times):
            computed = np.gradient(computed, period)
            # Means over the two samples that a central difference spans, by Simpson's rule.
            measured[1:-1] = (measured[:-2] + 4 * measured[1:-1] + measured[2:]) / 6
        step = max(settle // _OFTEN, 1)
        rows = np.flatnonzero(used).astype(np.int64)[::step]
        return cls(computed=computed, measured=measured, rows=rows, step=step)

    def fit(self, given: Array, target: Array) -> Solution:
        """The target by a factor of what is given, its change in a sample, and a constant."""
        columns = np.column_stack([given, np.gradient(given), np.ones_like(given)])[self.rows]
        order = Neighbours.of(self.rows, self.step)
        regressor = factor(columns, ("factor", "delay", "offset"), neighbours=order)
        return least_squares(target[self.rows], regressor)

    def in_step(self) -> tuple[float, Array, Solution]:
        """The delay that leaves none to be fitted, what is so moved, and the fit; else none.

        Two signals that have nothing to do with each other have no delay.
        """
        first = self.fit(self.computed, self.measured)
        delay, moved, fitted = 0.0, self.computed, first
        for _ in range(_STEPS):
            by_sample, gain = float(fitted.theta[1]), float(fitted.theta[0])
            change = -by_sample / gain if gain else np.inf
            delay += change
            if not abs(delay) < _FARTHEST:
                return 0.0, self.computed, first
            moved = np.asarray(shift(self.computed, delay, order=3, mode="nearest"), dtype=float)
            fitted = self.fit(moved, self.measured)
            if abs(change) < _STILL:
                break
        return delay, moved, fitted


def unmasked(record: Record) -> NDArray[np.bool_]:
    """Which samples are not masked, (N,)."""
    return ~covered(record.masked, len(record))


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnComparison:
    """A measured column against a computed one.

    Attributes
    ----------
    factor, factor_deviation : float
        Of the measured one, in the middle of what noise leaves open, with half of that.
    delay, delay_deviation : float
        Of the measured one, samples.
    offset, offset_deviation : float
        What is constant between the two, SI.
    size : float
        Root mean square of the computed one, SI.
    left_percent : float
        What remains of either beside the other, percent of it.
    """

    factor: float
    factor_deviation: float
    delay: float
    delay_deviation: float
    offset: float
    offset_deviation: float
    size: float
    left_percent: float

    @property
    def distances(self) -> dict[str, float]:
        """Of the factor from 1, of delay, constant and what is left, by what each may be."""
        far = MIN_DISTANCE_FROM_NOISE.value
        return {
            "factor": abs(self.factor - 1)
            / max(MAX_SCALE_ERROR.value, far * self.factor_deviation),
            "delay": abs(self.delay) / max(MAX_COLUMN_DELAY, far * self.delay_deviation),
            "offset": abs(self.offset)
            / max(MAX_COLUMN_OFFSET * self.size, far * self.offset_deviation),
            "left": self.left_percent / _MAX_DIFFERENCE,
        }

    @property
    def worst(self) -> float:
        """The largest of them; beyond 1 something is wrong."""
        return max(self.distances.values())

    @classmethod
    def of(cls, columns: LowPassed) -> "ColumnComparison | Missing":
        """Of two columns; missing where the axis hardly moves in them."""
        try:
            delay, moved, fitted = columns.in_step()
            back = columns.fit(columns.measured, moved)
        except EstimationError:
            return Missing("the axis hardly moves in what is compared")
        deviations = np.sqrt(np.diag(Hac(2 * _OFTEN).matrix(fitted)))
        low, high = sorted((float(fitted.theta[0]), 1 / (float(back.theta[0]) or _TINY)))
        gain = (low + high) / 2
        alike = float(fitted.theta[0] * back.theta[0])  # squared partial correlation
        return cls(
            factor=gain,
            factor_deviation=float(np.hypot(deviations[0], (high - low) / 2)),
            delay=delay,
            delay_deviation=float(deviations[1] / abs(gain)) if gain else float("inf"),
            offset=float(fitted.theta[2]),
            offset_deviation=float(deviations[2]),
            size=float(np.sqrt(np.mean(columns.computed[columns.rows] ** 2))),
            left_percent=100 * float(np.sqrt(max(1 - alike, 0.0))),
        )


def scale_remedy(
    role: str, column: str, declared: str, times: float, vague: float
) -> Remedy | None:
    """The usual unit of a column whose numbers are so many times those in the declared one.

    Parameters
    ----------
    role, column : str
    declared : str
    times : float
    vague : float
        Part of it, by which it may be another.

    Returns
    -------
    Remedy or None
        None for no usual unit.
    """
    own = label_unit(declared)
    for name in _UNITS:
        known = label_unit(name)
        if own is None or known is None or known[1] != own[1]:
            continue
        if abs(times * known[0] / own[0] - 1) <= vague < np.inf:
            return Remedy.of("it is in ", Setting("columns", f"{role}={column}:{name}"))
    return None
