"""Covariance of an estimate whose residuals are an autoregression, the regressor taken as fixed.

A kernel adds up what scores show of each lag. Where a record holds few that are independent, that
is too little: the fit takes of the errors what is slow, as its regressor is, and so residuals, and
their scores, have less of it than the errors had. An autoregression of the residuals is one number
of all rows, and what the fit takes of it follows from the regressor. It knows nothing of residuals
whose variance changes, so that it is no more than a lower bound beside the kernel's: the larger of
a robust and a conventional deviation, as [AngristPischke2009]_ advise for small samples.
"""

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
    from scipy.optimize import brentq
    from scipy.signal import lfilter

    e, influence, order = solution.counted, solution.influence, solution.neighbours
    n, k = influence.shape
    nothing = CovarianceEstimate(
        matrix=np.zeros((k, k)), freedom=np.full(k, float(n - k)), description=_NAME
    )
    if not e @ e > 0:
        return nothing
    size = np.linalg.norm(influence, axis=0)  # columns may be of sizes far apart
    orthonormal, triangle = np.linalg.qr(influence / size)
    # Rows further apart than a residual is remembered count as just so far.
    reach = int(np.log(_FORGOTTEN) / np.log(_MAX_RESIDUAL_AUTOREGRESSION))
    # On the grid of places, where a row is missing 0.
    basis, there = (order.on_grid(each, reach) for each in (orthonormal, np.ones((n, 1))))
    rows, pairs = float(there.sum()), float(there[1:, 0] @ there[:-1, 0])

    def coloured(rho: float) -> Array:
        """The correlations of errors times the basis, (m, k)."""
        before = lfilter([1.0], [1.0, -rho], basis, axis=0)
        after = lfilter([1.0], [1.0, -rho], basis[::-1], axis=0)[::-1]
        return np.asarray((before + after - basis) * there, dtype=float)

    def of_parameters(taken: Array) -> Array:
        """Correlations of what the fit takes, as those of its parameters, (k, k)."""
        mixing = triangle * size
        return np.asarray(mixing.T @ taken @ mixing, dtype=float)

    def left(rho: float) -> float:
        """Autocorrelation at a row's distance that residuals are expected to show."""
        made = coloured(rho)
        taken, early, late = basis.T @ made, basis[:-1], basis[1:]
        crossed = np.sum(late * made[:-1]) + np.sum(made[1:] * early)
        products = rho * pairs - float(crossed) + float(np.sum((late @ taken) * early))
        return (products / max(pairs, 1.0)) / ((rows - float(np.trace(taken))) / rows)

    after, before = order.pairs(1)
    power, most = float(e @ e / len(e)), _MAX_RESIDUAL_AUTOREGRESSION
    shown = float(e[after] @ e[before] / max(len(e[after]), 1)) / power
    of_none, of_most = left(0.0), left(most)
    if shown < of_none - MAX_CHANCE_DEVIATION.value / np.sqrt(len(e)):
        return nothing
    rho = most if of_most <= shown else 0.0
    if of_none < shown < of_most:
        rho = float(brentq(lambda rho: left(rho) - shown, 0.0, most, xtol=_RESOLVED))
    taken = basis.T @ coloured(rho)
    variance = len(e) * power / (len(e) - float(np.trace(taken)))
    # Slopes of the logarithms of the variances by the coefficient. The innovations stay as they
    # are: the errors' variance is theirs by 1 - rho^2.
    at = max(rho - _RESOLVED, 0.0), min(rho + _RESOLVED, most)
    less, more = (np.log(np.diag(of_parameters(basis.T @ coloured(r))) / (1 - r**2)) for r in at)
    slopes = (more - less) / (at[1] - at[0])
    return CovarianceEstimate(
        matrix=np.asarray(variance * of_parameters(taken), dtype=float),
        freedom=np.clip(
            2 / ((2 + slopes**2 * (1 - rho**2)) / n), MIN_DEGREES_OF_FREEDOM.value, n - k
        ),
        description=_NAME,
    )
