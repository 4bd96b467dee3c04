"""Whether a recorded signal is in time with the force that it makes, and of its size.

What the model makes of a signal that is moved or scaled, less what it makes of the signal as it is
recorded, is a column beside the model's own: if the signal was logged late, or in another unit, the
residuals hold that column. A factor shows where the signal's coefficient is known; one that is
estimated takes whatever the signal is scaled by.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.signals import FilteredRecord, about_samples
from axisid.estimation.thresholds.lacking import (
    FALSE_DISCOVERY_RATE,
    MAX_SCORE_CHANCE,
    MAX_SHARE_TO_DOUBT,
    MAX_SIGNAL_DELAY,
    MIN_EXPLAINED_SHARE,
    MIN_MISSING_FORCE,
    MIN_OWN_PART,
)
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .examined_rows import ExaminedRows, examined
from .search import Factors, factors

_GRID = 14  # delays of either sign
_STEP = 1e-3  # of a factor
_TOLERANCE = 1e-3  # samples, of a delay


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalApart:
    """A recorded signal beside the force that it makes.

    Attributes
    ----------
    name : str
    fault : {"", "delay", "factor"}
        What is wrong with it.
    delay, delay_deviation : float
        By how much the column is late, samples; NaN where the record does not tell.
    factor, factor_deviation : float
        Times the recorded one that the model needs; NaN where its coefficient is estimated, or it
        makes no force.
    share : float
        Of the force that the fault makes, root mean square.
    explained : float
        Share of the residuals' sum of squares that it takes.
    p_value : float
        Allowed for all delays that are tried.
    """

    name: str
    fault: Literal["", "delay", "factor"]
    delay: float
    delay_deviation: float
    factor: float
    factor_deviation: float
    share: float = 0.0
    explained: float = 0.0
    p_value: float = 1.0


def signals_apart(data: FilteredRecord, preferred: Estimate) -> tuple[SignalApart, ...] | Missing:
    """Each recorded signal that makes a force, beside it."""
    x = examined(data, preferred)
    if isinstance(x, Missing):
        return x
    read = data.axis.axis.signals
    if not read:
        return ()
    rows = _SignalRows(data, preferred, x)
    return tuple(found for j in range(len(read)) if (found := rows.apart(j, len(read))) is not None)


class _SignalRows:
    """What the judged model makes of its signals, on the rows that are examined."""

    def __init__(self, data: FilteredRecord, preferred: Estimate, x: ExaminedRows) -> None:
        self._data, self._preferred, self._x = data, preferred, x
        own = np.column_stack([x.regressor, x.weights])
        self._basis = np.linalg.qr(own / np.linalg.norm(own, axis=0))[0]
        self._residuals = self._beside(x.residuals)
        self._made = self._of(x.signals.recorded)

    def apart(self, index: int, signals: int) -> SignalApart | None:
        """One signal; None for one that makes no force."""
        delays = self._delays()
        columns = np.column_stack([self._moved(index, delay) for delay in delays])
        scaled = self._scaled(index)
        if not (np.any(columns) or np.any(scaled)):
            return None
        gains = np.array([self._gain(column) for column in columns.T])
        best = int(np.argmax(gains))
        late = self._finest(index, delays, best) if gains[best] > 0 else 0.0
        tests = signals * (len(delays) + 1)
        faults = [
            self._fault("delay", self._moved(index, late), tests),
            self._fault("factor", scaled, tests),
        ]
        told = max((f for f in faults if f.fault), key=lambda f: f.explained, default=None)
        delay, delay_deviation = self._timed(index, 0.0 if told is None else late)
        factor, factor_deviation = self._factor(scaled)
        return SignalApart(
            name=self._data.axis.axis.signals[index].name,
            fault="" if told is None else told.fault,
            delay=delay,
            delay_deviation=delay_deviation,
            factor=factor,
            factor_deviation=factor_deviation,
            share=0.0 if told is None else told.share,
            explained=0.0 if told is None else told.explained,
            p_value=1.0 if told is None else told.p_value,
        )

    def _delays(self) -> Array:
        """Delays that are tried, samples, from one to the longest, of either sign."""
        longest = MAX_SIGNAL_DELAY.value / self._data.record.period
        longest = min(longest, 0.1 * len(self._data))
        one = np.unique(np.round(np.geomspace(1.0, max(longest, 2.0), _GRID)))
        return np.concatenate([-one[::-1], one])

    def _finest(self, index: int, delays: Array, best: int) -> float:
        """The delay between the neighbours of the best of those that are tried."""
        from scipy.optimize import minimize_scalar

        low, high = delays[max(best - 1, 0)], delays[min(best + 1, len(delays) - 1)]
        found = minimize_scalar(
            lambda late: -self._gain(self._moved(index, late)),
            bounds=(low, high),
            method="bounded",
            options={"xatol": _TOLERANCE},
        )
        return float(found.x)

    def _timed(self, index: int, late: float) -> tuple[float, float]:
        """The delay and its deviation, about one that is nearly right."""
        change = self._moved(index, late + 0.5) - self._moved(index, late - 0.5)
        others = self._basis
        if late:
            here = self._beside(self._moved(index, late))
            size = float(np.linalg.norm(here))
            if not size:
                return np.nan, np.nan
            others = np.column_stack([self._basis, here / size])
            change = change * float(here @ self._residuals) / size**2
        own = change - others @ (others.T @ change)
        if not self._is_apart(own, change):
            return np.nan, np.nan
        left = self._residuals - others @ (others.T @ self._residuals)
        found = self._factors(own, left)
        return late + float(found.values[0]), float(found.deviations[0])

    def _factor(self, scaled: Array) -> tuple[float, float]:
        """The factor that the model needs, and its deviation."""
        own = self._beside(scaled)
        if not self._is_apart(own, scaled):
            return np.nan, np.nan
        found = self._factors(own, self._residuals)
        return 1 + float(found.values[0]), float(found.deviations[0])

    def _fault(self, kind: Literal["delay", "factor"], column: Array, tests: int) -> SignalApart:
        """What a column takes of the residuals; no fault where that is chance or too little."""
        own = self._beside(column)
        nothing = SignalApart(
            name="",
            fault="",
            delay=np.nan,
            delay_deviation=np.nan,
            factor=np.nan,
            factor_deviation=np.nan,
        )
        if not self._is_apart(own, column):
            return nothing
        found = self._factors(own, self._residuals)
        value = float(found.values[0])
        power = float(self._residuals @ self._residuals)
        explained = float(np.sum((own * value) ** 2)) / power
        share = float(np.linalg.norm(column * value) / np.linalg.norm(self._x.left))
        p_value = min(1.0, tests * found.wald_p)
        confirmed = found.score_p <= MAX_SCORE_CHANCE.value or explained > MAX_SHARE_TO_DOUBT.value
        matters = share >= MIN_MISSING_FORCE.value and explained >= MIN_EXPLAINED_SHARE.value
        if not (confirmed and matters and p_value <= FALSE_DISCOVERY_RATE.value):
            return nothing
        return replace(nothing, fault=kind, share=share, explained=explained, p_value=p_value)

    def _factors(self, own: Array, left: Array) -> Factors:
        return factors(own[:, None], left, self._x.neighbours)

    def _gain(self, column: Array) -> float:
        """Sum of squares that a column takes."""
        own = self._beside(column)
        if not self._is_apart(own, column):
            return 0.0
        return float(own @ self._residuals) ** 2 / float(own @ own)

    @staticmethod
    def _is_apart(own: Array, column: Array) -> bool:
        size = float(np.linalg.norm(column))
        return size > 0 and float(np.linalg.norm(own)) > MIN_OWN_PART.value * size

    def _beside(self, column: Array) -> Array:
        return np.asarray(column - self._basis @ (self._basis.T @ column), dtype=float)

    def _moved(self, index: int, late: float) -> Array:
        """What a column lacks that was logged so many samples late; it belongs earlier."""
        return self._changed(index, lambda values, at: np.interp(at + late, at, values))

    def _scaled(self, index: int) -> Array:
        return self._changed(index, lambda values, _: (1 + _STEP) * values) / _STEP

    def _changed(self, index: int, change: Callable[[Array, Array], Array]) -> Array:
        """Rows of what the model makes of a changed signal, less what it makes of it as it is."""
        recorded = list(self._x.signals.recorded)
        values = recorded[index].copy()
        for first, last in self._data.record.spans:
            at = np.arange(first, last, dtype=float)
            values[first:last] = change(values[first:last], at)
        recorded[index] = values
        return self._x.sampling.reduce(self._of(tuple(recorded)) - self._made)

    def _of(self, recorded: tuple[Array, ...]) -> Array:
        """What the model leaves to the force, less the drive's own, at each sample, (N,)."""
        signals = replace(self._x.signals, recorded=recorded)
        made = self._preferred.form.equations(signals)
        needed = made.intercept + made.regressor @ self._preferred.theta
        return np.asarray(needed - self._driven(recorded), dtype=float)

    def _driven(self, recorded: tuple[Array, ...]) -> Array:
        """The force of the recorded control, (N,), where that is what was recorded."""
        data, s = self._data, self._x.signals
        if data.record.force is not None or data.acting_control is None:
            return np.zeros(len(s.position))
        motion = s.position, s.velocity, s.acceleration
        force = data.drive.force(data.acting_control, motion, recorded)
        if data.prefilter.hold != "zoh":
            return force
        return about_samples(force, [first for first, _ in data.record.spans])
