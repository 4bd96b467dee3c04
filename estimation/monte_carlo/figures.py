"""Figures of many runs, each with its Monte-Carlo error."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.support.arrays import Array


@dataclass(frozen=True, slots=True)
class Share:
    """How often something happened.

    Attributes
    ----------
    count, of : int
        How often, of how many times that it could.
    """

    count: int
    of: int

    @classmethod
    def of_truths(cls, truths: NDArray[np.bool_]) -> "Share":
        """How often it is true."""
        return cls(int(np.count_nonzero(truths)), len(truths))

    @property
    def value(self) -> float:
        """The share; not a number of no time."""
        return self.count / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the probability; 0 to 1 of no time."""
        return self.interval_at(INTERVAL_LEVEL.value)

    def interval_at(self, level: float) -> tuple[float, float]:
        """Wilson's interval of a level; 0 to 1 of no time."""
        from scipy.stats import binomtest

        if not self.of:
            return 0.0, 1.0
        found = binomtest(self.count, self.of).proportion_ci(level, "wilson")
        return float(found.low), float(found.high)


@dataclass(frozen=True, slots=True)
class Mean:
    """A figure with its standard error over the runs.

    Attributes
    ----------
    value, error : float
        Not a number of too few runs.
    """

    value: float
    error: float

    @classmethod
    def of_values(cls, values: Array) -> "Mean":
        """The mean of independent values, (n,)."""
        n = len(values)
        error = float(values.std(ddof=1)) / math.sqrt(n) if n > 1 else math.nan
        return cls(float(values.mean()) if n else math.nan, error)

    @classmethod
    def of_scatter(cls, values: Array) -> "Mean":
        """Their standard deviation; its error allows for tails that are not the normal one's.

        By the variance of a sample's variance, ``(m4 - m2^2 (n - 3)/(n - 1))/n``, and the delta
        method.
        """
        n = len(values)
        if n < 2:
            return cls(math.nan, math.nan)
        away = values - values.mean()
        variance, fourth = float(away @ away) / (n - 1), float((away**4).mean())
        deviation = math.sqrt(variance)
        if n < 4 or not deviation:
            return cls(deviation, math.nan)
        spread = max(fourth - variance**2 * (n - 3) / (n - 1), 0.0) / n
        return cls(deviation, math.sqrt(spread) / (2 * deviation))

    @property
    def distance(self) -> float:
        """Of the value from 0, in its errors; 0 where one is not known."""
        if math.isnan(self.value) or math.isnan(self.error):
            return 0.0
        if not self.error:
            return math.inf if self.value else 0.0
        return abs(self.value) / self.error
