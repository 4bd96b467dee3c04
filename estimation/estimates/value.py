"""An estimated number, with unit, deviations and interval, and functions of such numbers."""

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import stdtrit

from axisid.codegen.artefacts import Quantity
from axisid.estimation.thresholds import INTERVAL_LEVEL, MIN_ROWS_PER_PARAMETER
from axisid.modeling.text import FunctionLike, parameter_function
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, UsageError
from axisid.support.frozen_mapping import FrozenMapping
from axisid.support.number_text import range_text
from axisid.support.user_values import is_among, quoted

_MIN_PRINTED_FILTER_BIAS = 0.5  # deviations, from which the value without that bias is printed
# second-order part of a deviation by the first; beyond, the delta method is not enough
_MAX_CURVATURE = 0.1

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
        # The interval is about another number then, which it would else seem to leave to one side.
        corrected = f" ({self.corrected:.6g} {CORRECTED})" * self.is_shifted
        return (
            f"{self.value:.6g} +- {self.deviation:.2g} {self.unit}{corrected}, "
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
        return abs(self.filter_bias) / self.deviation if self.deviation > 0 else math.inf

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
                f"there is no {quoted(name)}; choose from {', '.join(self)}.", code="no-such-value"
            )
        return super().__getitem__(name)

    def listed(self) -> str:
        """Every value with its deviation and unit, on one line."""
        values = (f"{n} = {v.value:.6g} +- {v.deviation:.2g} {v.unit}" for n, v in self.items())
        return ", ".join(values)


class EstimateLike(Protocol):
    """Parameters with their covariances: what values are made of, see `Estimate`."""

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Parameters, length p."""

    @property
    def physical(self) -> Array:
        """Their values, (p,)."""

    @property
    def covariances(self) -> Mapping[str, Array]:
        """Of these, (p, p), by name."""

    @property
    def filter_bias(self) -> Array | None:
        """What filter and noise move them by, (p,), as twins tell."""

    @property
    def chosen(self) -> str:
        """Of `covariances`, what intervals are of."""

    @property
    def freedom(self) -> Mapping[str, Array]:
        """Degrees of freedom of their variances, (p,), by name of the covariance."""


def few_rows(rows: int, parameters: int) -> str | None:
    """What is to be said of rows that are too few for the deviations of so many parameters."""
    if rows >= MIN_ROWS_PER_PARAMETER.value * parameters:
        return None
    return (
        f"{rows} rows for {parameters} parameters are few: standard deviations cannot be believed"
    )


def student_interval(centre: float, deviation: float, freedom: float) -> tuple[float, float]:
    """The 95 % interval about an estimate, by Student's distribution."""
    reach = float(stdtrit(freedom, (1 + INTERVAL_LEVEL.value) / 2)) * deviation
    return centre - reach, centre + reach


def value_with_interval(
    estimate: EstimateLike,
    value: float,
    unit: str,
    variances: Mapping[str, float],
    sd_gain: float,
    filter_bias: float | None,
    freedom: float,
) -> Value:
    """A value from its variance under each covariance; `freedom` is that of the chosen one."""
    # Rounding may leave a variance of nothing a little below zero.
    sds = {name: 0.0 if v < 0 else math.sqrt(v) for name, v in variances.items()}
    corrected = value - (filter_bias or 0.0)
    return Value(
        value=value,
        unit=unit,
        deviations=sds,
        interval=student_interval(corrected, sds[estimate.chosen], freedom),
        sd_gain=sd_gain,
        filter_bias=filter_bias,
        chosen=estimate.chosen,
    )


def derived_value(
    function: FunctionLike,
    estimate: EstimateLike,
    *,
    curvature: Callable[[Array, Array], float],
    moved_by_gain: Array,
    advice: str,
) -> Value:
    """A function of an estimate's parameters by the delta method, for a method ``derive``.

    Parameters
    ----------
    function : str or SymPy expression
    estimate : EstimateLike
    curvature : callable
        Takes gradient (p,) and Hessian (p, p), gives the second-order part of the deviation against
        the first.
    moved_by_gain : (p,) array
        What a deviation of the drive gain moves the parameters by.
    advice : str
        What to do where the function bends too much.

    Raises
    ------
    UsageError
        The function cannot be read, or its units do not fit.
    EstimationError
        It has no finite value at the estimate.
    """
    read = parameter_function(function, {q.name: q.unit for q in estimate.quantities})
    value, slopes, bends = read.at([float(x) for x in estimate.physical])
    gradient, hessian = np.array(slopes), np.array(bends)
    if not np.all(np.isfinite([value, *gradient, *hessian.ravel()])):
        raise EstimationError(
            f"{function} is not a finite real number with finite derivatives at the estimate; "
            f"its value is {value:g}."
        )
    second_order = curvature(gradient, hessian)
    if second_order > _MAX_CURVATURE:
        warnings.warn(
            f"{function} bends within the uncertainty: the second-order part of its standard "
            f"deviation is about {second_order:.2g} of the first; {advice}",
            RuntimeWarning,
            stacklevel=3,  # whoever called `derive`
        )
    bias = estimate.filter_bias
    return value_with_interval(
        estimate,
        value,
        str(read.unit),
        {name: _variance(gradient, c) for name, c in estimate.covariances.items()},
        abs(float(gradient @ moved_by_gain)),
        None if bias is None else float(gradient @ bias),
        float(np.min(estimate.freedom[estimate.chosen], where=gradient != 0, initial=np.inf)),
    )


def _variance(gradient: Array, covariance: Array) -> float:
    """Of a function; what nothing shows has an infinite variance, and counts where it is used."""
    used = (gradient[:, None] != 0) & (gradient != 0)
    return float(gradient @ np.where(used | np.isfinite(covariance), covariance, 0.0) @ gradient)
