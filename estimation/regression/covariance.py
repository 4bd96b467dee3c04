"""Covariance of an estimate, and its way through a nonlinear map.

An estimate is linear in the residuals to first order: ``theta_hat - theta = A' e``, with the
influence A, ``X (X'X)^-1`` for least squares and ``Z (X'Z)^-1`` for instruments. The estimators
differ in what they assume of e.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.signals import Neighbours
from axisid.support.arrays import Array
from axisid.support.errors import UsageError

from .linear import Solution


class Covariance(ABC):
    """How sure an estimate is, under what is assumed of the residuals."""

    @abstractmethod
    def matrix(self, solution: Solution) -> Array:
        """Covariance of the estimate, (k, k)."""

    @abstractmethod
    def describe(self, solution: Solution) -> str:
        """Name with lags and small-sample correction, for notes."""


@dataclass(frozen=True, slots=True)
class Published(Covariance):
    """``sigma^2 (W'W)^-1`` as in the published tables: independent residuals of equal variance.

    W is the regressor of least squares; with instruments it is Z, as [Young2011]_ has it for
    noise-free instruments at convergence. The variance is the sample variance with ``n - 1``, as
    the tables of [Janot2019]_ have it.
    """

    def matrix(self, solution: Solution) -> Array:
        """See `Covariance.matrix`."""
        e, factor = solution.residuals, solution.inverse_factor
        return float(e @ e) / (len(e) - 1) * (factor @ factor.T)

    def describe(self, solution: Solution) -> str:
        """See `Covariance.describe`."""
        return f"i.i.d., residual variance with n - 1 = {len(solution.residuals) - 1}"


@dataclass(frozen=True, slots=True)
class Classical(Covariance):
    """``sigma^2 A'A`` for independent residuals of equal variance.

    Attributes
    ----------
    unbiased : bool
        Divide the residuals' sum of squares by ``n - k``, not by n.
    """

    unbiased: bool = True

    def matrix(self, solution: Solution) -> Array:
        """See `Covariance.matrix`."""
        e, A = solution.residuals, solution.influence
        n, k = A.shape
        variance = float(e @ e) / (n - k if self.unbiased else n)
        return np.asarray(variance * (A.T @ A), dtype=float)

    def describe(self, solution: Solution) -> str:  # noqa: ARG002
        """See `Covariance.describe`."""
        return f"i.i.d., residual variance with {'n - k' if self.unbiased else 'n'}"


@dataclass(frozen=True, slots=True)
class Robust(Covariance):
    """``A' diag(e^2) A``: independent residuals of any variance (White).

    Attributes
    ----------
    corrected : bool
        Multiply by ``n/(n - k)`` (HC1), for small samples.
    """

    corrected: bool = True

    def matrix(self, solution: Solution) -> Array:
        """See `Covariance.matrix`."""
        scores = _scores(solution)
        return _correction(solution, corrected=self.corrected) * (scores.T @ scores)

    def describe(self, solution: Solution) -> str:  # noqa: ARG002
        """See `Covariance.describe`."""
        return f"heteroscedasticity-robust{_named_correction(corrected=self.corrected)}"


@dataclass(frozen=True, slots=True)
class Hac(Covariance):
    """Heteroscedasticity- and autocorrelation-consistent: Bartlett kernel [NeweyWest1987]_.

    Rows count as neighbours by their distance in time, as in [Parzen1963]_: scores of rows that are
    missing are zero.

    Attributes
    ----------
    lags : int or None
        How many neighbours of a row are correlated with it; None takes the plug-in rule of
        [NeweyWest1994]_ for the parameter that asks for most, at most the root of the rows.
    corrected : bool
        Multiply by ``n/(n - k)``, for small samples.
    """

    lags: int | None = None
    corrected: bool = True

    def __post_init__(self) -> None:
        whole = isinstance(self.lags, (int, np.integer))
        if self.lags is not None and not (whole and self.lags >= 0):
            raise UsageError(f"the lags are {self.lags!r}; give a whole number, or None to choose.")

    def matrix(self, solution: Solution) -> Array:
        """See `Covariance.matrix`."""
        scores, lags = _scores(solution), self.chosen_lags(solution)
        pairs = (solution.neighbours.pairs(lag) for lag in range(lags + 1))
        products = [scores[late].T @ scores[early] for late, early in pairs]
        return _correction(solution, corrected=self.corrected) * bartlett(products)

    def chosen_lags(self, solution: Solution) -> int:
        """The lags that are used: those given, or the plug-in rule's."""
        n = len(solution.residuals)
        if self.lags is not None and self.lags > n // 4:
            raise UsageError(f"{self.lags} lags are too many for {n} rows; give {n // 4} or fewer.")
        if self.lags is not None:
            return int(self.lags)
        # Each parameter's scores by themselves, so that neither units nor signs enter.
        return int(min(plug_in_lags(_scores(solution), solution.neighbours), most_lags(n)))

    def describe(self, solution: Solution) -> str:
        """See `Covariance.describe`."""
        most = most_lags(len(solution.residuals))
        capped = self.lags is None and self.chosen_lags(solution) == most
        rule = "as given" if self.lags is not None else f"plug-in rule{', capped' * capped}"
        return (
            f"HAC, Bartlett kernel, {self.chosen_lags(solution)} lags ({rule})"
            f"{_named_correction(corrected=self.corrected)}"
        )


def bartlett(products: Sequence[Array]) -> Array:
    """Long-run covariance of scores from their products ``sum s_t s_(t-lag)'``, lag 0 first."""
    total = products[0]
    for lag, product in enumerate(products[1:], 1):
        total = total + (1 - lag / len(products)) * (product + product.T)
    return total


def most_lags(n: int) -> int:
    """Where neighbours cancel, the rule knows no bound; the root keeps the estimate consistent."""
    return int(n**0.5)


def first_lags(n: int) -> int:
    """How many lags the plug-in rule looks at."""
    return int(min(np.ceil(4 * (n / 100) ** (2 / 9)), n - 1))


def plug_in_lags(series: Array, neighbours: Neighbours) -> int:
    """Lags for the Bartlett kernel by the plug-in rule of [NeweyWest1994]_.

    Parameters
    ----------
    series : (n,) or (n, k) array
        Scores of one parameter, or of several, of which the one counts that asks for most.
    neighbours : Neighbours
        Of the rows.
    """
    n = len(series)
    columns = series.reshape(n, -1)
    pairs = (neighbours.pairs(lag) for lag in range(first_lags(n) + 1))
    products = (np.einsum("ij,ij->j", columns[late], columns[early]) for late, early in pairs)
    sums = np.array([*products]) / n
    return max(lags_of(list(of_one), n) for of_one in sums.T)


def lags_of(sums: Sequence[float], n: int) -> int:
    """The plug-in rule for n rows, from the autocovariances of one parameter's scores."""
    if not np.all(np.isfinite(sums)):
        return len(sums) - 1
    level = sums[0] + 2 * sum(sums[1:])
    slope = 2 * sum(lag * value for lag, value in enumerate(sums))
    if level == 0:
        return len(sums) - 1
    return int(1.1447 * abs(slope / level) ** (2 / 3) * n ** (1 / 3))


def delta_method(covariance: Array, jacobian: Array) -> Array:
    """``J Sigma J'``: first-order covariance of a mapped estimate, symmetric to the last bit."""
    mapped = jacobian @ covariance @ jacobian.T
    return np.asarray((mapped + mapped.T) / 2, dtype=float)


def correlation(covariance: Array) -> Array:
    """Correlation matrix of a covariance, (k, k)."""
    deviations = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(deviations, deviations), dtype=float)


def _scores(solution: Solution) -> Array:
    return solution.influence * solution.residuals[:, None]


def _correction(solution: Solution, *, corrected: bool) -> float:
    n, k = solution.influence.shape
    return float(n / (n - k)) if corrected else 1.0


def _named_correction(*, corrected: bool) -> str:
    return ", times n/(n - k)" if corrected else ""
