"""Functions of the parameters of a fit: what the delta method takes."""

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtridf

from axisid.codegen.artefacts import Quantity
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.support.arrays import Array, Exact
from axisid.support.errors import UsageError

from .value import Value


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FittedParameters(Exact):
    """Parameters of a fit with what functions of them are told by.

    Attributes
    ----------
    quantities : tuple of Quantity
        Length P.
    values : mapping of str to Value
        By name, in that order.
    covariances : mapping of str to (P, P) array
        By name; infinite variances of what nothing shows.
    chosen : str
        Of `covariances`.
    at_bound : container of str
        Names of what is at a bound.
    """

    quantities: tuple[Quantity, ...]
    values: Mapping[str, Value]
    covariances: Mapping[str, Array]
    chosen: str
    at_bound: Container[str]

    @property
    def physical(self) -> Array:
        """Their values, (P,)."""
        return np.array([value.value for value in self.values.values()])

    @property
    def filter_bias(self) -> None:
        """A fit has no filter."""
        return

    @property
    def freedom(self) -> dict[str, Array]:
        """Degrees of freedom of the variances, (P,), as the intervals say; of the chosen one."""
        return {self.chosen: np.array([_freedom(value) for value in self.values.values()])}

    def bend(self, gradient: Array, hessian: Array) -> float:
        """Second-order part of a function's deviation against the first.

        Raises
        ------
        UsageError
            The function is of a parameter at a bound, whose errors go to one side.
        """
        pairs = zip(self.values, gradient, strict=True)
        held = [name for name, slope in pairs if slope and name in self.at_bound]
        if held:
            raise UsageError(
                f"{held[0]} is at a bound, so that its errors go to one side and the delta method "
                "tells nothing of functions of it; take its own interval, or fit with other "
                "bounds.",
                code="derive-at-bound",
            )
        used = np.flatnonzero((gradient != 0) | hessian.any(axis=0))
        covariance = self.covariances[self.chosen][np.ix_(used, used)]
        if not np.isfinite(covariance).all():
            return 0.0  # its deviation is infinite
        slopes, scaled = gradient[used], hessian[np.ix_(used, used)] @ covariance
        first = math.sqrt(max(float(slopes @ covariance @ slopes), 0.0))
        second = math.sqrt(max(float(np.trace(scaled @ scaled)), 0.0) / 2)
        return second / first if first else math.inf if second else 0.0


def _freedom(value: Value) -> float:
    """Of Student's distribution, by how many deviations the 95 % interval reaches."""
    low, high = value.interval
    if not 0 < value.deviation < math.inf:
        return math.inf
    found = float(stdtridf((1 + INTERVAL_LEVEL.value) / 2, (high - low) / 2 / value.deviation))
    return found if math.isfinite(found) else math.inf
