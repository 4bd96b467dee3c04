"""Estimators of the covariance of an estimate, its way through a nonlinear map, and Wald's test.

An estimate is linear in the residuals to first order: ``theta_hat - theta = A' e``, with the
influence A, ``X (X'X)^-1`` for least squares and ``Z (X'Z)^-1`` for instruments. The estimators
differ in what they assume of e.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.special import fdtrc

from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import (
    FEW_SCORES,
    MAX_AUTOREGRESSION,
    MAX_CHANCE_DEVIATION,
    MIN_DEGREES_OF_FREEDOM,
)
from axisid.support.arrays import Array
from axisid.support.errors import UsageError

from .coloured_errors import widened
from .covariance_note import CovarianceNote, LagRule
from .linear import CovarianceEstimate, Solution


class Covariance(ABC):
    """How sure an estimate is, under what is assumed of the residuals."""

    #: Whether one variance is all that is estimated; else it is the whole matrix.
    has_one_variance: ClassVar[bool] = False

    @abstractmethod
    def applied(self, solution: Solution) -> CovarianceEstimate:
        """Covariance of the estimate, its degrees of freedom, and what it is called."""

    def matrix(self, solution: Solution) -> Array:
        """Covariance of the estimate, (k, k)."""
        return self.applied(solution).matrix


def applied_covariance(
    matrix: Array,
    shape: tuple[int, ...],
    note: CovarianceNote | str,
    *,
    is_corrected: bool = False,
) -> CovarianceEstimate:
    """A matrix with n - k degrees of freedom, of so many rows and parameters (n, k).

    For small samples it is corrected: times ``n/(n - k)``. A covariance of your own is named by a
    text.
    """
    n, k = shape
    if isinstance(note, str):
        note = CovarianceNote(kind="other", label=note)
    if is_corrected:
        matrix, note = n / (n - k) * matrix, replace(note, is_corrected=True)
    return CovarianceEstimate(matrix=matrix, freedom=np.full(k, float(n - k)), note=note)


@dataclass(frozen=True, slots=True)
class PublishedCovariance(Covariance):
    """``sigma^2 (W'W)^-1`` as in the published tables: independent residuals of equal variance.

    W is the regressor of least squares; with instruments it is Z, as [Young2011]_ has it for
    noise-free instruments at convergence. The variance is the sample variance with ``n - 1``, as
    the tables of [Janot2019]_ have it.
    """

    has_one_variance = True

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """See `Covariance.applied`."""
        e, factor = solution.counted, solution.inverse_factor
        matrix = float(e @ e) / (len(e) - 1) * (factor @ factor.T)
        note = CovarianceNote(kind="published", degrees=len(e) - 1)
        return applied_covariance(matrix, solution.influence.shape, note)


@dataclass(frozen=True, slots=True)
class Classical(Covariance):
    """``sigma^2 A'A``, with ``n - k``, for independent residuals of equal variance."""

    has_one_variance = True

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """See `Covariance.applied`."""
        e, A = solution.counted, solution.influence
        n, k = A.shape
        matrix = float(e @ e) / (n - k) * (A.T @ A)
        return applied_covariance(matrix, A.shape, CovarianceNote(kind="classical"))


@dataclass(frozen=True, slots=True)
class Robust(Covariance):
    """``A' diag(e^2) A``, times ``n/(n - k)`` (HC1): independent residuals of any variance."""

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """See `Covariance.applied`."""
        scores = _scores(solution)
        note = CovarianceNote(kind="robust")
        return applied_covariance(scores.T @ scores, scores.shape, note, is_corrected=True)


@dataclass(frozen=True, slots=True)
class Hac(Covariance):
    """Heteroscedasticity- and autocorrelation-consistent: Bartlett kernel [NeweyWest1987]_.

    Where the lags are not given the scores of each parameter are whitened by an autoregression of
    first order, and the long-run covariance is recoloured, as in [AndrewsMonahan1992]_. It is times
    ``n/(n - k)``, for small samples. Rows count as neighbours by their
    distance in time, as in [Parzen1963]_: scores of rows that are missing are zero.

    Attributes
    ----------
    lags : int or None
        How many neighbours of a row are correlated with it; None takes the plug-in rule of
        [NeweyWest1994]_ for the parameter that asks for most, at most the root of the rows.
    widened : bool or None
        Where few scores are independent, make no deviation smaller than `covariance_of_ar1`
        has it; None does so where the lags are not given. That is for what the fit took, whose
        residuals are asked: parameters, and restrictions of them. A direction that it did not take,
        as of a term that is not in the model, or between two estimators, has lost nothing, and the
        kernel alone has the right size there.
    """

    lags: int | None = None
    widened: bool | None = None

    def __post_init__(self) -> None:
        whole = isinstance(self.lags, (int, np.integer))
        if self.lags is not None and not (whole and self.lags >= 0):
            raise UsageError(
                f"the lags are {self.lags!r}; give a whole number, or None to choose.",
                code="result",
            )

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """See `Covariance.applied`; fewer degrees for many lags, or sluggish scores."""
        applied = self.of_scores(_scores(solution), solution.neighbours)
        widens = self.lags is None if self.widened is None else self.widened
        if not (widens and float(applied.freedom.min()) < FEW_SCORES.value):
            return applied
        other, variances = covariance_of_ar1(solution), np.diag(applied.matrix)
        least = np.diag(other.matrix)
        wider = (variances > 0) & (least > variances)
        return replace(
            applied,
            matrix=widened(applied.matrix, least),
            freedom=np.where(wider, other.freedom, applied.freedom),
            note=replace(applied.note, is_at_least_ar1=bool(wider.any())),
        )

    def of_scores(self, scores: Array, neighbours: RowTimes) -> CovarianceEstimate:
        """Of scores, (n, k), of an estimate; never widened."""
        kernel = self.long_run(scores, neighbours)
        applied = applied_covariance(kernel.matrix, scores.shape, kernel.note, is_corrected=True)
        return replace(applied, freedom=np.minimum(kernel.freedom, applied.freedom))

    def long_run(self, scores: Array, neighbours: RowTimes) -> CovarianceEstimate:
        """The long-run covariance of scores, (n, k).

        Its degrees of freedom are by the relative variance of the kernel, ``2/n sum w^2``, and by
        the delta method of the autoregression, whose own variance is ``(1 - rho^2)/n``.

        Raises
        ------
        UsageError
            The lags that were given are too many for the rows.
        """
        white, colour = self.whitened(scores, neighbours)
        rows, lags = len(scores), len(white) - 1
        gain, weights = 1 / (1 - colour), 1 - np.arange(1, lags + 1) / (lags + 1)  # Bartlett's
        kernel = 1 + 2 * float(np.sum(weights**2))
        whitens = self.lags is None
        coloured = 2 * (1 + colour) / (1 - colour) if whitens else 0.0
        rule: LagRule = "plug-in"
        if not whitens:
            rule = "given"
        elif lags == most_lags(rows):
            rule = "plug-in, capped"
        ahead = white[1:]
        both = weights[:, None, None] * (ahead + ahead.transpose(0, 2, 1))
        summed = np.concatenate([white[:1], both]).sum(axis=0)
        return CovarianceEstimate(
            matrix=np.asarray(summed * np.outer(gain, gain), dtype=float),
            freedom=np.asarray(rows / (kernel + coloured) * np.ones_like(colour), dtype=float),
            note=CovarianceNote(kind="hac", lags=lags, lag_rule=rule, is_prewhitened=whitens),
        )

    def whitened(self, scores: Array, neighbours: RowTimes) -> tuple[Array, Array]:
        """Products of whitened scores at the lags that count, and their autoregression, (k,).

        The latter is 0 where the lags are given, which are those of the scores themselves.
        """
        rows = len(scores)
        if self.lags is not None:
            if self.lags > rows // 4:
                raise UsageError(
                    f"{self.lags} lags are too many for {rows} rows; give {rows // 4} or fewer.",
                    code="result",
                )
            plain = neighbours.autocovariances(scores, int(self.lags))
            return plain, np.zeros(plain.shape[1])
        # The plug-in rule looks at so many lags.
        looked_at = int(min(np.ceil(4 * (rows / 100) ** (2 / 9)), rows - 1))
        raw = neighbours.autocovariances(scores, looked_at + 1)
        # Of first order, of each parameter's scores, kept from a root of one.
        power, next_to = (np.diagonal(raw[lag]) for lag in (0, 1))
        slope = np.divide(next_to, power, out=np.zeros_like(power), where=power > 0)
        most = MAX_AUTOREGRESSION.value
        colour = np.clip(np.where(np.isfinite(slope), slope, 0.0), -most, most)
        white = _whitened(raw, colour)
        # Each parameter's scores by themselves, so that neither units nor signs enter.
        sums = np.diagonal(white, axis1=1, axis2=2) / rows
        lags = min(max(lags_of(list(of_one), rows) for of_one in sums.T), most_lags(rows))
        if lags > looked_at:
            white = _whitened(neighbours.autocovariances(scores, lags + 1), colour)
        return white[: lags + 1], colour


def _whitened(products: Array, colour: Array) -> Array:
    """Products of ``s_t - rho s_(t-1)`` from those of the scores, at one lag less.

    Scores are zero before the first row and after the last, so that this is exact.
    """
    left, right = colour[:, None], colour[None, :]
    before = np.concatenate([products[1].T[None], products[:-2]])
    here, after = products[:-1], products[1:]
    return np.asarray(here + left * here * right - left * before - after * right, dtype=float)


def most_lags(n: int) -> int:
    """Where neighbours cancel, the rule knows no bound; the root keeps the estimate consistent."""
    return int(n**0.5)


def lags_of(sums: Sequence[float], n: int) -> int:
    """The plug-in rule for n rows, from the autocovariances of one parameter's scores."""
    level = sums[0] + 2 * sum(sums[1:])
    slope = 2 * sum(lag * value for lag, value in enumerate(sums))
    if level == 0 or not np.all(np.isfinite(sums)):
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
    return solution.influence * solution.counted[:, None]


# a hundred rows, beyond which a short record cannot tell it from a drift
_MAX_RESIDUAL_AUTOREGRESSION = 0.99

_RESOLVED = 1e-3  # of the autoregression, far finer than a short record shows it
_FORGOTTEN = 0.05  # of a residual, after which rows are as far apart as any


def covariance_of_ar1(solution: Solution) -> CovarianceEstimate:
    """``A' Omega A`` for the influence A and residuals that are an AR(1), the regressor as fixed.

    A kernel adds up what scores show of each lag. Where a record holds few that are independent,
    that is too little: the fit takes of the errors what is slow, as its regressor is, and so
    residuals, and their scores, have less of it than the errors had. An autoregression of the
    residuals is one number of all rows, and what the fit takes of it follows from the regressor. It
    knows nothing of residuals whose variance changes, so that it is no more than a lower bound
    beside the kernel's: the larger of a robust and a conventional deviation, as
    [AngristPischke2009]_ advise for small samples.

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
    note = CovarianceNote(kind="ar1")
    nothing = applied_covariance(np.zeros((k, k)), (n, k), note)
    if not e @ e > 0:
        return nothing
    size = np.linalg.norm(influence, axis=0)  # columns may be of sizes far apart
    orthonormal, triangle = np.linalg.qr(influence / size)
    # Rows further apart than a residual is remembered count as just so far.
    reach = int(np.log(_FORGOTTEN) / np.log(_MAX_RESIDUAL_AUTOREGRESSION))
    # On the grid of places, where a row is missing 0.
    basis, present = (order.on_grid(each, reach) for each in (orthonormal, np.ones((n, 1))))
    rows, pairs = float(present.sum()), float(present[1:, 0] @ present[:-1, 0])

    def coloured(rho: float) -> Array:
        """The correlations of errors times the basis, (m, k)."""
        before = lfilter([1.0], [1.0, -rho], basis, axis=0)
        after = lfilter([1.0], [1.0, -rho], basis[::-1], axis=0)[::-1]
        return np.asarray((before + after - basis) * present, dtype=float)

    def of_parameters(taken: Array) -> Array:
        """Correlations of what the fit takes, as those of its parameters, (k, k)."""
        mixing = triangle * size
        return np.asarray(mixing.T @ taken @ mixing, dtype=float)

    def expected(rho: float) -> float:
        """Autocorrelation at a row's distance that residuals are expected to show."""
        coloured_basis = coloured(rho)
        taken, early, late = basis.T @ coloured_basis, basis[:-1], basis[1:]
        crossed = np.sum(late * coloured_basis[:-1]) + np.sum(coloured_basis[1:] * early)
        products = rho * pairs - float(crossed) + float(np.sum((late @ taken) * early))
        return (products / max(pairs, 1.0)) / ((rows - float(np.trace(taken))) / rows)

    after, before = order.pairs(1)
    power, most = float(e @ e / len(e)), _MAX_RESIDUAL_AUTOREGRESSION
    observed = float(e[after] @ e[before] / max(len(e[after]), 1)) / power
    of_none, of_most = expected(0.0), expected(most)
    if observed < of_none - MAX_CHANCE_DEVIATION.value / np.sqrt(len(e)):
        return nothing
    rho = most if of_most <= observed else 0.0
    if of_none < observed < of_most:
        rho = float(brentq(lambda rho: expected(rho) - observed, 0.0, most, xtol=_RESOLVED))
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
        note=note,
    )


_CERTAIN = 1e9  # degrees of freedom, from which F is chi-squared to rounding
_SAME = 1e-9  # of the eigenvalues of a correlation matrix


def wald(difference: Array, covariance: Array) -> tuple[float, int]:
    """``d' V^-1 d`` of a difference (k,), and in how many directions it is told.

    What has no deviation, or an infinite one, is left out, and so are directions in which rounding
    alone differs.
    """
    variances = np.diag(covariance)
    there = (variances > 0) & np.isfinite(variances)
    if not there.any():
        return 0.0, 0
    sizes, directions = np.linalg.eigh(correlation(covariance[np.ix_(there, there)]))
    kept = sizes > _SAME * sizes[-1]
    along = directions[:, kept].T @ (difference[there] / np.sqrt(variances[there]))
    return float(np.sum(along**2 / sizes[kept])), int(kept.sum())


def hotelling_p_value(
    square: float, restrictions: int, freedom: float, *, one_variance: bool = False
) -> float:
    """P-value of ``d' V^-1 d``, Hotelling's T squared.

    A covariance matrix of ``nu`` degrees of freedom makes ``(nu - q + 1)/(nu q)`` times it F
    distributed with q and ``nu - q + 1``. Where the shape of the matrix is known, and one variance
    alone is estimated, ``1/q`` times it is F with q and ``nu``.

    Parameters
    ----------
    square : float
    restrictions : int
        q.
    freedom : float
        Of the covariance, the effective degrees where scores are alike.
    one_variance : bool
        Whether the covariance is one variance times a matrix without chance in it.

    References
    ----------
    [Hotelling1931]_; for covariances that allow for autocorrelation, [Sun2013]_.
    """
    if one_variance:
        return float(fdtrc(restrictions, freedom, square / restrictions))
    dof = min(max(freedom - restrictions + 1, 1.0), _CERTAIN)
    return float(
        fdtrc(
            restrictions,
            dof,
            square * dof / ((dof + restrictions - 1) * restrictions),
        )
    )
