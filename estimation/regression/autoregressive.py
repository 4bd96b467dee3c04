"""Covariance of an estimate whose residuals are an autoregression, the regressor taken as fixed.

A kernel adds up what scores show of each lag. Where a record holds few that are independent, that
is too little: the fit takes of the errors what is slow, as its regressor is, and so residuals, and
their scores, have less of it than the errors had. An autoregression of the residuals is one number
of all rows, and what the fit takes of it follows from the regressor. It knows nothing of residuals
whose variance changes, so that it is no more than a lower bound beside the kernel's: the larger of
a robust and a conventional deviation, as [AngristPischke2009]_ advise for small samples.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from axisid.estimation.thresholds import MAX_CHANCE_DEVIATION, MIN_DEGREES_OF_FREEDOM
from axisid.support.arrays import Array

from .linear import CovarianceEstimate, Solution

# a hundred rows, beyond which a short record cannot tell it from a drift
_MAX_RESIDUAL_AUTOREGRESSION = 0.99

_NAME = "AR(1) of the residuals"
_RESOLVED = 1e-3  # of the autoregression, far finer than a short record shows it
_FORGOTTEN = 0.05  # of a residual, after which rows are as far apart as any


def autoregressive_covariance(solution: Solution) -> CovarianceEstimate:
    """``A' Omega A`` for the influence A and residuals that are an AR(1).

    Its coefficient is the one with which residuals, as the fit leaves them, would show the
    autocorrelation that they show, 0 at least. Nothing where residuals are zero, or where they are
    less alike from row to row than independent errors would leave them but for chance: as noise of
    a position is differentiated, there is nothing slow that the fit could take.

    Its degrees of freedom are by the delta method: the innovations' variance has the relative
    variance ``2/n``, the coefficient, apart from it, ``(1 - rho^2)/n``.
    """
    e, (n, k) = solution.counted, solution.influence.shape
    nothing = CovarianceEstimate(
        matrix=np.zeros((k, k)), freedom=np.full(k, float(n - k)), description=_NAME
    )
    if not e @ e > 0:
        return nothing
    fitted = _Fitted.of(solution)
    late, early = solution.neighbours.pairs(1)
    power = float(e @ e / len(e))
    shown = float(e[late] @ e[early] / max(len(e[late]), 1)) / power
    if shown < fitted.left(0.0) - MAX_CHANCE_DEVIATION.value / np.sqrt(len(e)):
        return nothing
    rho = _matched(fitted, shown)
    taken = fitted.basis.T @ fitted.coloured(rho)
    variance = len(e) * power / (len(e) - float(np.trace(taken)))
    relative = (2 + fitted.slopes(rho) ** 2 * (1 - rho**2)) / n
    return CovarianceEstimate(
        matrix=np.asarray(variance * fitted.of_parameters(taken), dtype=float),
        freedom=np.clip(2 / relative, MIN_DEGREES_OF_FREEDOM.value, n - k),
        description=_NAME,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Fitted:
    """What a fit takes of its rows: all that its influence spans.

    Attributes
    ----------
    basis : (m, k) array
        Orthonormal, on the grid of places; zero where a row is missing.
    there : (m,) array
        1 where there is a row, 0 where one is missing.
    mixing : (k, k) array
        The influence is the basis times this.
    """

    basis: Array
    there: Array
    mixing: Array

    @classmethod
    def of(cls, solution: Solution) -> Self:
        """Of a solution; rows further apart than a residual is remembered count as just so far."""
        influence, order = solution.influence, solution.neighbours
        size = np.linalg.norm(influence, axis=0)  # columns may be of sizes far apart
        basis, triangle = np.linalg.qr(influence / size)
        reach = int(np.log(_FORGOTTEN) / np.log(_MAX_RESIDUAL_AUTOREGRESSION))
        return cls(
            basis=order.on_grid(basis, reach),
            there=order.on_grid(np.ones((len(basis), 1)), reach)[:, 0],
            mixing=triangle * size,
        )

    def coloured(self, rho: float) -> Array:
        """The correlations of errors times the basis, (m, k)."""
        from scipy.signal import lfilter

        before = lfilter([1.0], [1.0, -rho], self.basis, axis=0)
        after = lfilter([1.0], [1.0, -rho], self.basis[::-1], axis=0)[::-1]
        return np.asarray((before + after - self.basis) * self.there[:, None], dtype=float)

    def of_parameters(self, taken: Array) -> Array:
        """Correlations of what the fit takes, as those of its parameters, (k, k)."""
        return np.asarray(self.mixing.T @ taken @ self.mixing, dtype=float)

    def slopes(self, rho: float) -> Array:
        """Of the logarithms of the parameters' variances, by the coefficient, (k,).

        The innovations stay as they are: the errors' variance is theirs by ``1 - rho^2``.
        """
        at = (max(rho - _RESOLVED, 0.0), min(rho + _RESOLVED, _MAX_RESIDUAL_AUTOREGRESSION))
        early, late = (
            np.log(np.diag(self.of_parameters(self.basis.T @ self.coloured(r))) / (1 - r**2))
            for r in at
        )
        return np.asarray((late - early) / (at[1] - at[0]), dtype=float)

    def left(self, rho: float) -> float:
        """Autocorrelation at a row's distance that residuals are expected to show."""
        coloured = self.coloured(rho)
        taken = self.basis.T @ coloured
        power = float(self.there.sum() - np.trace(taken))
        early, late = self.basis[:-1], self.basis[1:]
        pairs = float(self.there[1:] @ self.there[:-1])
        crossed = np.sum(late * coloured[:-1]) + np.sum(coloured[1:] * early)
        products = rho * pairs - float(crossed) + float(np.sum((late @ taken) * early))
        return (products / max(pairs, 1.0)) / (power / float(self.there.sum()))


def _matched(fitted: _Fitted, shown: float) -> float:
    """The autoregression, from 0 to short of one, that leaves the autocorrelation shown."""
    most = _MAX_RESIDUAL_AUTOREGRESSION
    if fitted.left(most) <= shown:
        return most
    if fitted.left(0.0) >= shown:
        return 0.0
    from scipy.optimize import brentq

    return float(brentq(lambda rho: fitted.left(rho) - shown, 0.0, most, xtol=_RESOLVED))
