"""Estimated values with unit, standard errors and interval, and functions of them."""

import warnings
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from pkgutil import resolve_name

import numpy as np
from scipy.special import stdtridf, stdtrit

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.choices import COVARIANCE_ROWS, CovarianceRow
from axisid.estimation.regression import Covariance, covariance_root, curvature, delta_method
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.modeling.parsing import FunctionLike, parameter_function
from axisid.support.arrays import Array, Exact
from axisid.support.checks import is_among
from axisid.support.errors import EstimationError, UsageError
from axisid.support.mappings import FrozenMapping
from axisid.support.wording import quoted, range_text

#: Covariances by name, for residuals that are: autocorrelated with any variance; independent with
#: any variance; independent with equal variance.
COVARIANCES: dict[str, CovarianceRow] = {row.name: row for row in COVARIANCE_ROWS}


def covariance_of(name: str, lags: int | None) -> Covariance:
    """Return the covariance estimator of a name in `COVARIANCES`.

    `lags` are those of an autocorrelation-consistent covariance; with None, they are chosen from
    the data. Other covariances ignore them.
    """
    row = COVARIANCES[name]
    made: Callable[..., Covariance] = resolve_name(row.covariance)
    return made(lags) if row.takes_lags else made()


_MIN_PRINTED_FILTER_BIAS = 0.5  # standard errors, from which the value without bias is printed

#: Name of `Value.corrected` next to a value.
CORRECTED = "without bias"


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """An estimated number with its unit, standard errors and interval.

    Attributes
    ----------
    value : float
    unit : str
    deviations : mapping of str to float
        Standard error by each of `COVARIANCES`.
    interval : (float, float)
        95 % interval about `corrected`, by `deviation` and Student's distribution with the degrees
        of freedom of the chosen covariance.
    sd_gain : float
        Standard error by the declared standard deviation of the drive gain. The other members do
        not include it.
    filter_bias : float or None
        Bias by filter and noise, found with simulated replicas of the record. The value contains
        it, the interval does not. None without replicas.
    chosen : str
        Covariance of `deviation` and `interval`, one of `COVARIANCES`.
    """

    value: float
    unit: str
    deviations: Mapping[str, float]
    interval: tuple[float, float]
    sd_gain: float = 0.0
    filter_bias: float | None = None
    chosen: str = "hac"

    def __post_init__(self) -> None:
        """Make the mapping of standard errors read-only."""
        object.__setattr__(self, "deviations", FrozenMapping(self.deviations))

    def __str__(self) -> str:
        """Return value, standard error, unit and 95 % interval on one line."""
        # The centre of the interval first, as on the screen.
        biased = f" ({self.value:.6g} with bias)" if self.is_shifted else ""
        return (
            f"{self.corrected:.6g} +- {self.deviation:.2g} {self.unit}{biased}, "
            f"95 %: {range_text(*self.interval, ' to ', digits=6)} {self.unit}"
        )

    @property
    def deviation(self) -> float:
        """Standard error by the chosen covariance."""
        return self.deviations[self.chosen]

    @property
    def sd(self) -> float:
        """Standard error for independent residuals, as in the published tables."""
        return self.deviations["iid"]

    @property
    def sd_robust(self) -> float:
        """Standard error for heteroscedastic residuals."""
        return self.deviations["robust"]

    @property
    def sd_hac(self) -> float:
        """Standard error for heteroscedastic and autocorrelated residuals."""
        return self.deviations["hac"]

    @property
    def corrected(self) -> float:
        """The value minus the bias of filter and noise, where it is known."""
        return self.value - (self.filter_bias or 0.0)

    @property
    def shift(self) -> float:
        """Size of the bias by filter and noise, in standard errors of the value.

        0 without a known bias; infinite where the standard error is 0.
        """
        if not self.filter_bias:
            return 0.0
        return abs(self.filter_bias) / self.deviation if self.deviation > 0 else np.inf

    @property
    def is_shifted(self) -> bool:
        """True if the centre of the interval differs noticeably from the value."""
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
    """Values by name of the parameter; an unknown name is refused with a list of the names."""

    def __getitem__(self, name: str) -> Value:
        """Return the value of that name; UsageError for an unknown name."""
        if not is_among(name, self):
            raise UsageError(
                f"there is no parameter {quoted(name)}. Choose from {', '.join(self)}.",
                code="result",
            )
        return super().__getitem__(name)

    def listed(self) -> str:
        """Return every value with its standard error and unit, on one line."""
        values = (f"{n} = {v.value:.6g} +- {v.deviation:.2g} {v.unit}" for n, v in self.items())
        return ", ".join(values)


def student_interval(centre: float, deviation: float, freedom: float) -> tuple[float, float]:
    """Return the 95 % confidence interval of an estimate, by Student's distribution.

    Parameters
    ----------
    centre : float
        Estimate minus its bias.
    deviation : float
        Standard error.
    freedom : float
        Degrees of freedom of the standard error.
    """
    reach = float(stdtrit(freedom, (1 + INTERVAL_LEVEL.value) / 2)) * deviation
    return centre - reach, centre + reach


def degrees_of_freedom_of(value: Value) -> float:
    """Return the degrees of freedom of Student's distribution that a value's interval implies.

    They follow from the half width of the interval in standard errors. Infinite where the standard
    error is 0 or not finite, and where no finite number gives that width.
    """
    low, high = value.interval
    if not 0 < value.deviation < np.inf:
        return np.inf
    dof = float(stdtridf((1 + INTERVAL_LEVEL.value) / 2, (high - low) / 2 / value.deviation))
    return dof if np.isfinite(dof) else np.inf


# second-order part of a standard error relative to the first; beyond, the delta method is inexact
_MAX_CURVATURE = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SamplingDistribution(Exact):
    """Sampling distribution of estimated parameters, from which their values are made.

    Attributes
    ----------
    quantities : tuple of Quantity
        Length p.
    theta : (p,) array
        Estimate of the parameters.
    covariances : mapping of str to (p, p) array
        Covariances by name; infinite variances of parameters that nothing identifies.
    freedom : mapping of str to (p,) array
        Degrees of freedom of the variances, by name of the covariance; at least of the chosen one.
    chosen : str
        Name of the covariance that intervals use.
    bias : (p,) array or None
        Bias of the parameters by filter and noise, where it is known.
    by_gain : (p,) array or None
        Change of the parameters by a standard deviation of the drive gain; None for an exact gain.
    at_bound : container of str
        Names of the parameters at a bound.
    """

    quantities: tuple[Quantity, ...]
    theta: Array
    covariances: Mapping[str, Array]
    freedom: Mapping[str, Array]
    chosen: str
    bias: Array | None = None
    by_gain: Array | None = None
    at_bound: Container[str] = ()

    @property
    def corrected(self) -> Array:
        """The estimate minus its bias, where it is known, (p,)."""
        return self.theta if self.bias is None else self.theta - self.bias

    @property
    def values(self) -> NamedValues:
        """Parameters by name, with units, standard errors, intervals and bias."""
        return NamedValues((q.name, self._value(i, q.unit)) for i, q in enumerate(self.quantities))

    def _value(self, i: int, unit: str) -> Value:
        """Return parameter `i` with its unit, standard errors, interval and bias."""
        # Rounding may make a zero variance slightly negative.
        deviations = {
            name: float(np.sqrt(max(c[i, i], 0.0))) for name, c in self.covariances.items()
        }
        dof = float(self.freedom[self.chosen][i])
        return Value(
            value=float(self.theta[i]),
            unit=unit,
            deviations=deviations,
            interval=student_interval(float(self.corrected[i]), deviations[self.chosen], dof),
            sd_gain=0.0 if self.by_gain is None else abs(float(self.by_gain[i])),
            filter_bias=None if self.bias is None else float(self.bias[i]),
            chosen=self.chosen,
        )

    def through(
        self, quantities: tuple[Quantity, ...], theta: Array, slopes: Array
    ) -> "SamplingDistribution":
        """Return the sampling distribution of r functions of the parameters, to first order.

        Parameters
        ----------
        quantities : tuple of Quantity
            Names and units of the functions, length r.
        theta : (r,) array
            Values of the functions at the estimate.
        slopes : (r, p) array
            Derivatives of the functions by the parameters.
        """
        # An infinite variance only counts for functions of its parameter: it is 0 in the covariance
        # if no function depends on the parameter.
        has_slope = np.any(slopes != 0, axis=0)
        is_used = np.outer(has_slope, has_slope)
        return SamplingDistribution(
            quantities=quantities,
            theta=theta,
            covariances={
                name: delta_method(np.where(is_used | np.isfinite(c), c, 0.0), slopes)
                for name, c in self.covariances.items()
            },
            freedom={
                name: least_freedom(freedom, slopes) for name, freedom in self.freedom.items()
            },
            chosen=self.chosen,
            bias=None if self.bias is None else slopes @ self.bias,
            by_gain=None if self.by_gain is None else slopes @ self.by_gain,
        )

    def curvature(self, gradient: Array, hessian: Array) -> float:
        """Return the second-order part of a function's standard error, relative to the first.

        Parameters
        ----------
        gradient, hessian : (p,) and (p, p) arrays
            First and second derivatives of the function by the parameters.
        """
        # Only the parameters that the function depends on, as others may have infinite variances.
        used = np.flatnonzero((gradient != 0) | hessian.any(axis=0))
        block = np.ix_(used, used)
        root = covariance_root(self.covariances[self.chosen][block])  # NaN if one is infinite
        return curvature(root, np.zeros((len(used),) * 3), gradient[used], hessian[block])

    def derived(
        self,
        function: FunctionLike,
        advice: str,
        curvature: Callable[[Array, Array], float] | None = None,
    ) -> Value:
        """Return a function of the parameters with standard errors by the delta method.

        Public methods named ``derive`` call this method.

        Parameters
        ----------
        function : str or SymPy expression
        advice : str
            Advice of the warning where the function is too nonlinear for the delta method: an
            instruction that begins with a verb, without a full stop.
        curvature : callable, optional
            Replacement of the method `curvature`, for parameters that are not linear functions of
            the regression's own parameters.

        Raises
        ------
        UsageError
            The function cannot be read, its units do not fit, or it depends on a parameter at a
            bound, whose errors go to one side.
        EstimationError
            The function or one of its derivatives has no finite value at the estimate.

        Warns
        -----
        RuntimeWarning
            The function is nonlinear within the uncertainty.
        """
        # The function with its unit, and its value and derivatives at the estimate.
        read = parameter_function(function, {q.name: q.unit for q in self.quantities})
        value, slopes, bends = read.at([float(x) for x in self.theta])
        gradient, hessian = np.array(slopes), np.array(bends)
        if not np.all(np.isfinite([value, *gradient, *hessian.ravel()])):
            raise EstimationError(
                f"{function} must be a finite real number with finite derivatives at the estimate, "
                f"but its value there is {value:g}. Give a function that is smooth at the estimate."
            )
        # Refuse parameters at a bound, and warn where a linearisation is not accurate.
        names = [q.name for q, slope in zip(self.quantities, gradient, strict=True) if slope]
        names_at_bound = [name for name in names if name in self.at_bound]
        if names_at_bound:
            name = names_at_bound[0]
            raise UsageError(
                f"{name} is at a bound, so its errors are one-sided and the delta method does not "
                f"apply to functions of {name}. Use the interval of {name}, or fit with other "
                "bounds.",
                code="bounds",
            )
        second_order = (curvature or self.curvature)(gradient, hessian)
        if second_order > _MAX_CURVATURE:
            warnings.warn(
                f"{function} is nonlinear within the uncertainty: the second-order part of its "
                f"standard error is about {second_order:.2g} times the first-order part. "
                f"{advice[:1].upper()}{advice[1:]}",
                RuntimeWarning,
                stacklevel=3,  # the caller of `derive`
            )
        quantity = Quantity(name=str(function), unit=str(read.unit))
        derived = self.through((quantity,), np.array([value]), gradient[None, :])
        return derived.values[quantity.name]


def least_freedom(freedom: Array, slopes: Array) -> Array:
    """Return the degrees of freedom of r functions of p parameters, (r,).

    The degrees of freedom of a function are the smallest of those of its parameters, `freedom`,
    (p,). Its parameters are those with a nonzero derivative in `slopes`, (r, p). Infinite for a
    function without parameters.
    """
    return np.asarray(np.min(np.where(slopes != 0, freedom, np.inf), axis=1), dtype=float)
