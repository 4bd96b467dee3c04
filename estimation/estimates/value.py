"""An estimated number, with unit, deviations by covariance, and interval."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pkgutil import resolve_name

import numpy as np
from scipy.special import stdtridf, stdtrit

from axisid.estimation.choices import COVARIANCE_ROWS, CovarianceRow
from axisid.estimation.regression import Covariance
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.support.errors import UsageError, is_among, quoted, range_text
from axisid.support.mappings import FrozenMapping

#: By name: residuals that are autocorrelated; of any variance; alike and independent.
COVARIANCES: dict[str, CovarianceRow] = {row.name: row for row in COVARIANCE_ROWS}


def covariance_of(name: str, lags: int | None) -> Covariance:
    """The covariance of an estimate that is so called; None for lags lets the data choose."""
    row = COVARIANCES[name]
    made: Callable[..., Covariance] = resolve_name(row.covariance)
    return made(lags) if row.takes_lags else made()


_MIN_PRINTED_FILTER_BIAS = 0.5  # deviations, from which the value without that bias is printed

#: What `Value.corrected` is called beside a value.
CORRECTED = "without bias"


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """A number that leaves the program: with unit, standard deviations and interval.

    Attributes
    ----------
    value : float
    unit : str
    deviations : mapping of str to float
        Standard deviation under each of `COVARIANCES`.
    interval : (float, float)
        95 %, about `corrected`, from `deviation` and Student's distribution with the degrees of
        freedom that the chosen covariance has.
    sd_gain : float
        What the declared deviation of the drive gain adds, in no other figure.
    filter_bias : float or None
        What filter and noise move the value by, as twins of the record tell. The value contains
        it, the interval does not. None without twins.
    chosen : str
        Of `COVARIANCES`: the one that `deviation` and `interval` are of.
    """

    value: float
    unit: str
    deviations: Mapping[str, float]
    interval: tuple[float, float]
    sd_gain: float = 0.0
    filter_bias: float | None = None
    chosen: str = "hac"

    def __post_init__(self) -> None:
        object.__setattr__(self, "deviations", FrozenMapping(self.deviations))

    def __str__(self) -> str:
        # The centre of the interval first, as on the screen.
        biased = f" ({self.value:.6g} with bias)" * self.is_shifted
        return (
            f"{self.corrected:.6g} +- {self.deviation:.2g} {self.unit}{biased}, "
            f"95 %: {range_text(*self.interval, ' to ', digits=6)} {self.unit}"
        )

    @property
    def deviation(self) -> float:
        """Standard deviation under the covariance that was chosen."""
        return self.deviations[self.chosen]

    @property
    def sd(self) -> float:
        """For independent residuals, as in the published tables."""
        return self.deviations["iid"]

    @property
    def sd_robust(self) -> float:
        """For residuals of any variance."""
        return self.deviations["robust"]

    @property
    def sd_hac(self) -> float:
        """For autocorrelated residuals too."""
        return self.deviations["hac"]

    @property
    def corrected(self) -> float:
        """The value less the bias of filter and noise, where that is known."""
        return self.value - (self.filter_bias or 0.0)

    @property
    def shift(self) -> float:
        """Size of the bias of filter and noise in deviations; infinite for a bias without one."""
        if not self.filter_bias:
            return 0.0
        return abs(self.filter_bias) / self.deviation if self.deviation > 0 else np.inf

    @property
    def is_shifted(self) -> bool:
        """Whether the interval's centre is noticeably not the value, which is then said with it."""
        return self.shift > _MIN_PRINTED_FILTER_BIAS

    @property
    def relative_sd_percent(self) -> float:
        """``100 sd / |value|``; infinite for a value of 0."""
        return 100.0 * self.sd / abs(self.value) if self.value else float("inf")

    @property
    def relative_deviation_percent(self) -> float:
        """``100 deviation / |value|``; infinite for a value of 0."""
        return 100.0 * self.deviation / abs(self.value) if self.value else float("inf")


class NamedValues(dict[str, Value]):
    """Values by name; a name that is not among them is told with those that are."""

    def __getitem__(self, name: str) -> Value:
        if not is_among(name, self):
            raise UsageError(
                f"there is no {quoted(name)}; choose from {', '.join(self)}.", code="result"
            )
        return super().__getitem__(name)

    def listed(self) -> str:
        """Every value with its deviation and unit, on one line."""
        values = (f"{n} = {v.value:.6g} +- {v.deviation:.2g} {v.unit}" for n, v in self.items())
        return ", ".join(values)


def student_interval(centre: float, deviation: float, freedom: float) -> tuple[float, float]:
    """The 95 % interval about an estimate, by Student's distribution."""
    reach = float(stdtrit(freedom, (1 + INTERVAL_LEVEL.value) / 2)) * deviation
    return centre - reach, centre + reach


def degrees_of_freedom_of(value: Value) -> float:
    """Of Student's distribution, by how many deviations the 95 % interval reaches."""
    low, high = value.interval
    if not 0 < value.deviation < np.inf:
        return np.inf
    dof = float(stdtridf((1 + INTERVAL_LEVEL.value) / 2, (high - low) / 2 / value.deviation))
    return dof if np.isfinite(dof) else np.inf
