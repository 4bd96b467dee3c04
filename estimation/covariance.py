"""Covariance of an estimate, and its way through a nonlinear map.

An estimate is linear in the residuals to first order: ``theta_hat - theta = A' e``, with the
influence A, ``X (X'X)^-1`` for least squares and ``Z (X'Z)^-1`` for instruments. The estimators
differ in what they assume of e.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from axisid.modeling import UsageError

from .arrays import Array
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

    Attributes
    ----------
    lags : int or None
        How many neighbours of a row are correlated with it; None takes the plug-in rule of
        [NeweyWest1994]_.
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
        scores = _scores(solution)
        total = scores.T @ scores
        lags = self.chosen_lags(solution)
        for lag in range(1, lags + 1):
            shifted = scores[lag:].T @ scores[:-lag]
            total = total + (1 - lag / (lags + 1)) * (shifted + shifted.T)
        return _correction(solution, corrected=self.corrected) * total

    def chosen_lags(self, solution: Solution) -> int:
        """The lags that are used: those given, or the plug-in rule's."""
        n = len(solution.residuals)
        if self.lags is not None:
            return int(min(self.lags, n - 1))
        # Where neighbours cancel, the rule knows no bound; [Schwert1989]_ gives a common one.
        most = min(12 * (n / 100) ** 0.25, n - 1)
        # Units of the parameters must not weigh the scores; the rule has one weight for each.
        scores = _scores(solution)
        size = np.sqrt(np.sum(scores**2, axis=0))
        weighted = (scores / np.where(size > 0, size, 1.0)).sum(axis=1)
        return int(min(plug_in_lags(weighted), most))

    def describe(self, solution: Solution) -> str:
        """See `Covariance.describe`."""
        rule = "plug-in rule" if self.lags is None else "as given"
        return (
            f"HAC, Bartlett kernel, {self.chosen_lags(solution)} lags ({rule})"
            f"{_named_correction(corrected=self.corrected)}"
        )


def plug_in_lags(series: Array) -> int:
    """Lags for the Bartlett kernel by the plug-in rule of [NeweyWest1994]_.

    Parameters
    ----------
    series : (n,) array
        A weighted sum of the scores.
    """
    n = len(series)
    first = int(min(np.ceil(4 * (n / 100) ** (2 / 9)), n - 1))
    sums = [float(series[lag:] @ series[: n - lag]) / n for lag in range(first + 1)]
    if not np.all(np.isfinite(sums)):
        return first
    level = sums[0] + 2 * sum(sums[1:])
    slope = 2 * sum(lag * value for lag, value in enumerate(sums))
    if level == 0:
        return first
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
