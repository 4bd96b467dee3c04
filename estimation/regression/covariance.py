"""Estimators of the covariance of an estimate, the delta method, and Wald's test.

An estimate is linear in the residuals to first order: ``theta_hat - theta = A' e``, with the
influence A, ``X (X'X)^-1`` for least squares and ``Z (X'Z)^-1`` for instruments. The estimators
differ in their assumptions on e.
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
    """Estimator of the covariance of an estimate under an assumption on the residuals."""

    #: True if only one variance is estimated, False if the whole matrix is.
    has_one_variance: ClassVar[bool] = False

    @abstractmethod
    def applied(self, solution: Solution) -> CovarianceEstimate:
        """Return the covariance of the estimate, (k, k), with degrees of freedom and a note."""

    def matrix(self, solution: Solution) -> Array:
        """Return the covariance of the estimate, (k, k)."""
        return self.applied(solution).matrix


def applied_covariance(
    matrix: Array,
    shape: tuple[int, ...],
    note: CovarianceNote | str,
    *,
    is_corrected: bool = False,
) -> CovarianceEstimate:
    """Return a covariance of k parameters from n rows, with ``n - k`` degrees of freedom.

    Parameters
    ----------
    matrix : (k, k) array
        Covariance before the correction for small samples.
    shape : (int, int)
        Numbers of rows n and parameters k.
    note : CovarianceNote or str
        Note on the estimator; a text is the name of an estimator of your own.
    is_corrected : bool
        True to multiply the matrix by ``n/(n - k)`` for small samples.
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

    W is the regressor of least squares; with instruments it is Z, as in [Young2011]_ for noise-free
    instruments at convergence. The variance is the sample variance with ``n - 1``, as in the tables
    of [Janot2019]_.
    """

    has_one_variance = True

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """Return the covariance of the published tables, (k, k), with degrees of freedom."""
        e, factor = solution.counted, solution.inverse_factor
        matrix = float(e @ e) / (len(e) - 1) * (factor @ factor.T)
        note = CovarianceNote(kind="published", degrees=len(e) - 1)
        return applied_covariance(matrix, solution.influence.shape, note)


@dataclass(frozen=True, slots=True)
class Classical(Covariance):
    """Covariance ``sigma^2 A'A`` for independent residuals of equal variance.

    The variance sigma^2 is estimated with ``n - k`` degrees of freedom.
    """

    has_one_variance = True

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """Return the covariance for independent residuals of equal variance, (k, k)."""
        e, A = solution.counted, solution.influence
        n, k = A.shape
        matrix = float(e @ e) / (n - k) * (A.T @ A)
        return applied_covariance(matrix, A.shape, CovarianceNote(kind="classical"))


@dataclass(frozen=True, slots=True)
class Robust(Covariance):
    """Covariance ``A' diag(e^2) A``, times ``n/(n - k)`` (HC1).

    It is for independent residuals of any variance.
    """

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """Return the covariance for independent residuals of any variance, (k, k)."""
        scores = _scores(solution)
        note = CovarianceNote(kind="robust")
        return applied_covariance(scores.T @ scores, scores.shape, note, is_corrected=True)


@dataclass(frozen=True, slots=True)
class Hac(Covariance):
    """Heteroscedasticity- and autocorrelation-consistent (HAC) covariance.

    ``G_0 + sum_(l=1)^L (1 - l/(L+1)) (G_l + G_l')`` of the autocovariances ``G_l`` of the scores
    ``A_t e_t``, with the Bartlett kernel [NeweyWest1987]_, multiplied by ``n/(n - k)`` for small
    samples. If the lags are not given, the scores of each parameter are prewhitened by a
    first-order autoregression and the long-run covariance is recoloured [AndrewsMonahan1992]_.
    Rows are neighbours by their distance in time: scores of missing rows are zero [Parzen1963]_.

    Attributes
    ----------
    lags : int or None
        Number of lags L with correlated scores; None takes the plug-in rule of [NeweyWest1994]_ for
        the parameter with the largest number of lags, at most the root of the number of rows.
    widened : bool or None
        True to raise standard errors to those of `covariance_of_ar1` where few scores are
        independent; None to do so only if the lags are not given. The raised standard errors are
        correct for parameters of the fit and their restrictions, because a fit reduces the slow
        part of its residuals. A fit does not reduce other directions, such as a term that is not in
        the model or the difference of two estimators; there the kernel alone has the correct size.
    """

    lags: int | None = None
    widened: bool | None = None

    def __post_init__(self) -> None:
        """Refuse lags that are not a whole number of 0 or more."""
        is_whole = isinstance(self.lags, (int, np.integer))
        if self.lags is not None and not (is_whole and self.lags >= 0):
            raise UsageError(
                f"the lags are {self.lags!r}. Give a whole number of 0 or more, or None to choose "
                "the lags from the data.",
                code="result",
            )

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """Return the HAC covariance, (k, k), with degrees of freedom and a note.

        Many lags and slow scores reduce the degrees of freedom. Where few scores are independent,
        standard errors are raised to those of AR(1) residuals, see `widened`.
        """
        applied = self.of_scores(_scores(solution), solution.neighbours)
        may_widen = self.lags is None if self.widened is None else self.widened
        if not (may_widen and float(applied.freedom.min()) < FEW_SCORES.value):
            return applied
        of_ar1, variances = covariance_of_ar1(solution), np.diag(applied.matrix)
        least = np.diag(of_ar1.matrix)
        is_raised = (variances > 0) & (least > variances)
        return replace(
            applied,
            matrix=widened(applied.matrix, least),
            freedom=np.where(is_raised, of_ar1.freedom, applied.freedom),
            note=replace(applied.note, is_at_least_ar1=bool(is_raised.any())),
        )

    def of_scores(self, scores: Array, neighbours: RowTimes) -> CovarianceEstimate:
        """Return the covariance of an estimate from its scores, (n, k).

        Standard errors are not raised to those of AR(1) residuals.
        """
        kernel = self.long_run(scores, neighbours)
        applied = applied_covariance(kernel.matrix, scores.shape, kernel.note, is_corrected=True)
        return replace(applied, freedom=np.minimum(kernel.freedom, applied.freedom))

    def long_run(self, scores: Array, neighbours: RowTimes) -> CovarianceEstimate:
        """Return the long-run covariance of scores, (n, k), without the small-sample factor.

        The degrees of freedom follow from the relative variance of the kernel, ``2/n sum w^2``, and
        of the prewhitening by the delta method: rho has the variance ``(1 - rho^2)/n``. Together
        ``n / (1 + 2 sum w^2 + 2 (1 + rho)/(1 - rho))``, the last term with prewhitening only.

        Raises
        ------
        UsageError
            The given lags are more than a quarter of the rows.
        """
        rows, is_prewhitened = len(scores), self.lags is None
        # Prewhitened scores, with the coefficient rho of each parameter; 0 with given lags.
        white, rho = self.whitened(scores, neighbours)
        lags = plug_in_lags(white, rows) if self.lags is None else self.lags
        # Recolouring factor of each parameter, and Bartlett's weights of the lags.
        gain, weights = 1 / (1 - rho), 1 - np.arange(1, lags + 1) / (lags + 1)
        of_kernel = 1 + 2 * float(np.sum(weights**2))
        of_prewhitening = 2 * (1 + rho) / (1 - rho) if is_prewhitened else 0.0
        freedom = rows / (of_kernel + of_prewhitening) * np.ones_like(rho)
        rule: LagRule = "plug-in"
        if not is_prewhitened:
            rule = "given"
        elif lags == most_lags(rows):
            rule = "plug-in, capped"
        return CovarianceEstimate(
            matrix=bartlett_sum(white, lags) * np.outer(gain, gain),
            freedom=np.asarray(freedom, dtype=float),
            note=CovarianceNote(
                kind="hac", lags=lags, lag_rule=rule, is_prewhitened=is_prewhitened
            ),
        )

    def whitened(self, scores: Array, neighbours: RowTimes) -> tuple[Array, Array]:
        """Return prewhitened scores, (N, k), and their first-order autoregression, (k,).

        The scores are on a grid of N times, with zeros for missing rows. If the lags are given, the
        scores are not prewhitened and the autoregression is 0.

        Raises
        ------
        UsageError
            The given lags are more than a quarter of the rows.
        """
        rows = len(scores)
        if self.lags is not None:
            if self.lags > rows // 4:
                raise UsageError(
                    f"{self.lags} lags are too many for {rows} rows. Give {rows // 4} lags or "
                    "fewer.",
                    code="result",
                )
            return neighbours.on_grid(scores, int(self.lags) + 1), np.zeros(scores.shape[1])
        # Gaps longer than the largest lag, or the lags of the rule, are shortened to it: no product
        # has two rows farther apart.
        on_grid = neighbours.on_grid(scores, max(most_lags(rows), _lags_of_rule(rows)) + 2)
        # First-order coefficient of each parameter's scores, limited to avoid a unit root.
        power = np.einsum("tk,tk->k", on_grid, on_grid)
        of_neighbours = np.einsum("tk,tk->k", on_grid[1:], on_grid[:-1])
        slope = np.divide(of_neighbours, power, out=np.zeros_like(power), where=power > 0)
        most = MAX_AUTOREGRESSION.value
        rho = np.clip(np.where(np.isfinite(slope), slope, 0.0), -most, most)
        white = np.concatenate([on_grid, np.zeros((1, on_grid.shape[1]))])
        white[1:] -= rho * on_grid
        return white, rho


def bartlett_sum(scores: Array, lags: int) -> Array:
    """Return the sum of autocovariances with Bartlett's weights, (k, k).

    It is ``C_0 + sum w_l (C_l + C_l')`` over lags from 1, with ``C_l = sum s_t s_(t-l)'`` and
    ``w_l = 1 - l/L``, where ``L = lags + 1``. The same is ``1/L sum_t S_t S_t'`` with ``S_t``, the
    sum of the L scores that end at t; scores are zero before the first row and after the last.

    Parameters
    ----------
    scores : (n, k) array
        Scores of each row.
    lags : int
        Largest lag.
    """
    width = lags + 1
    # The sums S_t of L successive scores are differences of cumulative sums.
    summed = np.zeros((len(scores) + width, scores.shape[1]))
    np.cumsum(scores, axis=0, out=summed[1 : len(scores) + 1])
    summed[len(scores) + 1 :] = summed[len(scores)]
    windows = summed[1:].copy()
    windows[width:] -= summed[1:-width]
    return np.asarray(windows.T @ windows / width, dtype=float)


def plug_in_lags(scores: Array, rows: int) -> int:
    """Return the number of lags by the plug-in rule for prewhitened scores, (n, k).

    It is the largest number over the parameters, so that neither units nor signs matter, and at
    most `most_lags`. `rows` is the number of rows without missing rows.
    """
    # Autocovariances of each parameter's scores by lag, (lags + 1, k).
    autocovariances = np.array(
        [
            np.einsum("tk,tk->k", scores[lag:], scores[: len(scores) - lag]) / rows
            for lag in range(_lags_of_rule(rows) + 1)
        ]
    )
    by_parameter = [lags_of(list(of_one), rows) for of_one in autocovariances.T]
    return min(max(by_parameter), most_lags(rows))


def _lags_of_rule(rows: int) -> int:
    """Return the number of autocovariances in the plug-in rule, ``4 (n/100)^(2/9)``."""
    return int(min(np.ceil(4 * (rows / 100) ** (2 / 9)), rows - 1))


def most_lags(n: int) -> int:
    """Return the largest number of lags for n rows, ``sqrt(n)``, which keeps HAC consistent.

    The plug-in rule alone has no bound: where the scores of neighbours cancel, it divides by a sum
    near 0.
    """
    return int(n**0.5)


def lags_of(sums: Sequence[float], n: int) -> int:
    """Return the number of lags by the plug-in rule of [NeweyWest1994]_, not bounded.

    ``1.1447 |s_1 / s_0|^(2/3) n^(1/3)`` with ``s_0 = g_0 + 2 sum g_l`` and ``s_1 = 2 sum l g_l``.

    Parameters
    ----------
    sums : sequence of float
        Autocovariances g_l of one parameter's scores, from lag 0.
    n : int
        Number of rows.
    """
    level = sums[0] + 2 * sum(sums[1:])
    slope = 2 * sum(lag * value for lag, value in enumerate(sums))
    if level == 0 or not np.all(np.isfinite(sums)):
        return len(sums) - 1
    return int(1.1447 * abs(slope / level) ** (2 / 3) * n ** (1 / 3))


def delta_method(covariance: Array, jacobian: Array) -> Array:
    """Return ``J Sigma J'``, (p, p), the first-order covariance of a mapped estimate.

    The matrix is exactly symmetric.

    Parameters
    ----------
    covariance : (k, k) array
        Covariance Sigma of the estimate.
    jacobian : (p, k) array
        Derivatives J of the map by the estimate.
    """
    mapped = jacobian @ covariance @ jacobian.T
    return np.asarray((mapped + mapped.T) / 2, dtype=float)


def correlation(covariance: Array) -> Array:
    """Return the correlation matrix, (k, k), of a covariance matrix, (k, k)."""
    deviations = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(deviations, deviations), dtype=float)


def _scores(solution: Solution) -> Array:
    """Return the scores ``A_t e_t`` of each row, (n, k), whose sum is the error of the estimate."""
    return solution.influence * solution.counted[:, None]


# coefficient of an AR(1) with a correlation length of 100 rows; a short record cannot distinguish a
# longer correlation from a drift
_MAX_RESIDUAL_AUTOREGRESSION = 0.99

_RESOLVED = 1e-3  # resolution of the coefficient, far finer than a short record determines it
_FORGOTTEN = 0.05  # correlation of two rows, at whose distance longer gaps are cut off


def covariance_of_ar1(solution: Solution) -> CovarianceEstimate:
    """Return the covariance ``A' Omega A``, (k, k), for errors that follow an AR(1).

    A is the influence of the errors, Omega their covariance; the regressor is not random.

    Where few scores are independent, `Hac` uses the larger standard error of its kernel and of this
    covariance, for each parameter. [AngristPischke2009]_ recommends the larger of a robust and a
    conventional standard error for small samples. This covariance is thus a lower bound, and a
    covariance of zero means that there is no lower bound.

    A kernel sums the sample autocovariances of the scores. With few independent scores the sum is
    too small: the regressor is slow, so the fit removes the slow part of the errors from the
    residuals and their scores. For an AR(1), which has one coefficient rho for all rows, this
    removed part follows from the regressor, and its variance is added again. An AR(1) does not
    account for a variance that changes along the record. Therefore it does not replace the kernel.

    The coefficient rho, 0 or more, is the one whose expected lag-1 autocorrelation of the residuals
    after the fit equals the observed one. The covariance is zero if the residuals are zero, or if
    the observed autocorrelation is significantly smaller than that of independent errors: as
    position noise is differentiated, the errors then have no slow part.

    The degrees of freedom follow by the delta method: the estimated variance of the innovations has
    the relative variance ``2/n``, and the estimated rho, which is independent of it, has the
    variance ``(1 - rho^2)/n``.
    """
    from scipy.optimize import brentq
    from scipy.signal import lfilter

    e, influence, order = solution.counted, solution.influence, solution.neighbours
    n, k = influence.shape
    note = CovarianceNote(kind="ar1")
    zero = applied_covariance(np.zeros((k, k)), (n, k), note)
    if not e @ e > 0:
        return zero
    # Orthonormal basis Q of the influence, ``A = Q R``; columns may have very different norms.
    size = np.linalg.norm(influence, axis=0)
    orthonormal, triangle = np.linalg.qr(influence / size)
    # Gaps longer than the correlation length are shortened to it.
    longest_gap = int(np.log(_FORGOTTEN) / np.log(_MAX_RESIDUAL_AUTOREGRESSION))
    # On a grid of m times, with zeros for missing rows: the basis, and 1 for each present row.
    basis = order.on_grid(orthonormal, longest_gap)
    present = order.on_grid(np.ones((n, 1)), longest_gap)
    rows, pairs = float(present.sum()), float(present[1:, 0] @ present[:-1, 0])

    def coloured(rho: float) -> Array:
        """Return the correlation matrix of an AR(1) (coefficient rho) times the basis, (m, k)."""
        before = lfilter([1.0], [1.0, -rho], basis, axis=0)
        after = lfilter([1.0], [1.0, -rho], basis[::-1], axis=0)[::-1]
        return np.asarray((before + after - basis) * present, dtype=float)

    def of_parameters(in_basis: Array) -> Array:
        """Return a (k, k) matrix in the basis Q as a matrix of the parameters, (k, k)."""
        mixing = triangle * size
        return np.asarray(mixing.T @ in_basis @ mixing, dtype=float)

    def expected(rho: float) -> float:
        """Return the expected lag-1 autocorrelation of the residuals after the fit.

        The residuals are ``(1 - Q Q') e`` for errors e with the correlation matrix C of an AR(1).
        The fit removes their part in the basis, which has the covariance ``Q' C Q``.
        """
        coloured_basis = coloured(rho)
        removed, early, late = basis.T @ coloured_basis, basis[:-1], basis[1:]
        crossed = np.sum(late * coloured_basis[:-1]) + np.sum(coloured_basis[1:] * early)
        products = rho * pairs - float(crossed) + float(np.sum((late @ removed) * early))
        return (products / max(pairs, 1.0)) / ((rows - float(np.trace(removed))) / rows)

    # Search for the coefficient rho for which the expected autocorrelation is the observed one.
    # First the observed one, and the expected ones for the smallest and largest allowed rho.
    after, before = order.pairs(1)
    power, most = float(e @ e / len(e)), _MAX_RESIDUAL_AUTOREGRESSION
    observed = float(e[after] @ e[before] / max(len(e[after]), 1)) / power
    lowest, highest = expected(0.0), expected(most)
    # Significantly below that of independent errors: there is no lower bound.
    if observed < lowest - MAX_CHANCE_DEVIATION.value / np.sqrt(len(e)):
        return zero
    # Outside the expected range rho is at the nearer end; within the range it is a root.
    rho = most if highest <= observed else 0.0
    if lowest < observed < highest:
        rho = float(brentq(lambda rho: expected(rho) - observed, 0.0, most, xtol=_RESOLVED))
    # Variance of the errors: that of the residuals, with the part that the fit removes added again.
    removed = basis.T @ coloured(rho)
    variance = len(e) * power / (len(e) - float(np.trace(removed)))
    # Slopes of the logarithms of the parameters' variances by rho, for a fixed variance of the
    # innovations; the variance of the errors is 1/(1 - rho^2) times that of the innovations.
    at = max(rho - _RESOLVED, 0.0), min(rho + _RESOLVED, most)
    less, more = (np.log(np.diag(of_parameters(basis.T @ coloured(r))) / (1 - r**2)) for r in at)
    slopes = (more - less) / (at[1] - at[0])
    relative_variances = (2 + slopes**2 * (1 - rho**2)) / n
    return CovarianceEstimate(
        matrix=np.asarray(variance * of_parameters(removed), dtype=float),
        freedom=np.clip(2 / relative_variances, MIN_DEGREES_OF_FREEDOM.value, n - k),
        note=note,
    )


_CERTAIN = 1e9  # degrees of freedom from which F equals chi-squared to rounding
_SAME = 1e-9  # eigenvalue of a correlation matrix, relative to the largest, that is rounding


def wald(difference: Array, covariance: Array) -> tuple[float, int]:
    """Return Wald's statistic ``d' V^-1 d`` of a difference d, (k,), and the rank of V.

    V is the covariance of d, (k, k). Elements of d with a variance of 0 or infinity are left out,
    and so are directions of V whose eigenvalues are rounding errors. Both numbers are 0 if no
    element remains.
    """
    variances = np.diag(covariance)
    is_known = (variances > 0) & np.isfinite(variances)
    if not is_known.any():
        return 0.0, 0
    sizes, directions = np.linalg.eigh(correlation(covariance[np.ix_(is_known, is_known)]))
    kept = sizes > _SAME * sizes[-1]
    # Components of the scaled difference along the eigenvectors of the correlation matrix.
    components = directions[:, kept].T @ (difference[is_known] / np.sqrt(variances[is_known]))
    return float(np.sum(components**2 / sizes[kept])), int(kept.sum())


def hotelling_p_value(
    square: float, restrictions: int, freedom: float, *, one_variance: bool = False
) -> float:
    """Return the p-value of ``T^2 = d' V^-1 d``, Hotelling's T squared.

    For a covariance matrix with ``nu`` degrees of freedom, ``(nu - q + 1)/(nu q) T^2`` is F
    distributed with q and ``nu - q + 1`` degrees of freedom. If only one variance is estimated and
    the shape of the matrix is known, ``T^2/q`` is F distributed with q and ``nu``.

    Parameters
    ----------
    square : float
        ``T^2``.
    restrictions : int
        Number q of restrictions, the rank of V.
    freedom : float
        Degrees of freedom nu of the covariance; effective ones for correlated scores.
    one_variance : bool
        True if the covariance is one estimated variance times a known matrix.

    References
    ----------
    [Hotelling1931]_; for covariances that allow for autocorrelation, [Sun2013]_.
    """
    if one_variance:
        return float(fdtrc(restrictions, freedom, square / restrictions))
    dof = min(max(freedom - restrictions + 1, 1.0), _CERTAIN)
    statistic = square * dof / ((dof + restrictions - 1) * restrictions)
    return float(fdtrc(restrictions, dof, statistic))
