"""Autoregressive errors of one or several outputs, and covariances of estimates with such errors.

The law computes the control from the position, so that the errors of both outputs are strongly
correlated: the covariance of the parameters needs their joint model.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from axisid.estimation.signals import RowTimes
from axisid.support.arrays import Array

from .linear import CovarianceEstimate

# share of the errors that must form pairs at a lag, if samples are masked: measured with half of
# the samples masked, at random or in blocks, the standard error is 0.9 to 1.4 times the scatter
_MIN_PAIRS = 0.25

_LONGEST = 0.1  # s, of an autoregression
_FEWEST = 20  # orders that are tried for any sampling period
_ROWS_PER_ORDER = 10

_ROUNDING = 1e-9
_OWN = 1e-6  # of each output's variance: added as independent noise, so that outputs are distinct
# covariance relative to the variance, below which it is set to 0; checked every so many lags
_FORGOTTEN, _ASKED = 1e-12, 256
_PATIENCE = 250  # orders beyond twice the best one, after which no higher order is tried


@dataclass(frozen=True, slots=True, kw_only=True)
class Autoregression:
    """Autoregression ``e_t = -A_1 e_{t-1} - ... + w_t`` of m outputs.

    The rows of the outputs alternate: those of one sample are neighbours.

    Attributes
    ----------
    coefficients : (p + 1, m, m) array
        ``1, A_1, ..., A_p``.
    variance : (m, m) array
        Covariance of the innovations w.
    covariances : (p + 1, m, m) array
        Autocovariances ``C_0, ..., C_p`` of the errors, from which the coefficients follow.
    """

    coefficients: Array
    variance: Array
    covariances: Array

    @property
    def order(self) -> int:
        """Order p."""
        return len(self.coefficients) - 1

    @property
    def outputs(self) -> int:
        """Number of outputs m."""
        return len(self.variance)

    def covariances_to(self, lags: int) -> Array:
        """Return the autocovariances ``C_0, ..., C_(lags - 1)`` of the errors, (lags, m, m).

        Beyond the order they follow from ``C_k = -A_1 C_(k-1) - ...``; negligible ones are 0.
        """
        m, p = self.outputs, self.order
        found = np.zeros((lags, m, m))
        found[: p + 1] = self.covariances[:lags]
        before = -self.coefficients[:0:-1].transpose(1, 0, 2).reshape(m, p * m)
        for k in range(p + 1, lags if p else 0):
            if k % _ASKED == 0:
                recent, variance = np.abs(found[k - p : k]).max(), np.abs(found[0]).max()
                if recent < _FORGOTTEN * variance:
                    break
            found[k] = before @ found[k - p : k].reshape(p * m, m)
        return found

    def coloured(self, columns: Array) -> Array:
        """Return ``A' Omega A`` for columns A, (m n, k), and errors of one stretch, (k, k).

        Omega is the covariance matrix of the errors. The product is computed by Fourier transforms
        of at least twice the length of the stretch, so that there is no wrap-around.
        """
        n = len(columns) // self.outputs
        if not n:
            return np.zeros((columns.shape[1],) * 2)
        size = next_fast_len(2 * n - 1, real=True)
        circle = np.zeros((size, self.outputs, self.outputs))
        circle[:n] = self.covariances_to(n)
        circle[size - n + 1 :] = circle[n - 1 : 0 : -1].transpose(0, 2, 1)
        spectra = self._spectra(columns, size)
        return _mean_product(spectra, rfft(circle, axis=0) @ spectra, size)

    def uncertainty(self, pieces: Sequence[Array], rows: int) -> float:
        """Return the relative variance of ``a' Omega a`` due to the estimated autoregression.

        The coefficients have the covariance ``C^-1 (x) W / N`` with the block Toeplitz covariance
        C of p errors, W of the innovations and N samples [Ljung1999]_; W has the covariance of N
        normal innovations. The derivatives of ``a' Omega a`` are taken in the frequency domain.

        Parameters
        ----------
        pieces : sequence of (m n,) array
            The column a in each stretch.
        rows : int
            Number of errors, m N, from which the autoregression was estimated.
        """
        samples, longest = max(rows // self.outputs, 1), max(map(len, pieces)) // self.outputs
        size = next_fast_len(longest + max(longest, self.order + 1), real=True)
        spread, by_lag = np.zeros_like(self.variance), np.zeros_like(self.covariances)
        answer = np.linalg.inv(rfft(self.coefficients, size, axis=0))
        for piece in pieces:
            seen = answer.conj().transpose(0, 2, 1) @ self._spectra(piece[:, None], size)
            across = seen.transpose(0, 2, 1)
            spread += _mean_product(across, across, size)
            crossed = (answer @ self.variance @ seen).conj().transpose(0, 2, 1)
            by_lag -= 2 * irfft(seen * crossed, size, axis=0)[: self.order + 1]
        whole = float(np.sum(spread * self.variance))
        if not whole > 0:
            return 2 / samples
        moved = self.variance @ spread
        share = 2 * float(np.sum(moved * moved.T))
        if self.order:
            share += self._of_coefficients(by_lag[1:])
        return share / samples / whole / whole

    def _of_coefficients(self, slopes: Array) -> float:
        """Return the variance due to the coefficients for N = 1, from derivatives, (p, m, m)."""
        from scipy.linalg import cho_factor, cho_solve

        p, m = self.order, self.outputs
        lags = np.subtract.outer(np.arange(p), np.arange(p))
        blocks = self.covariances[np.abs(lags)]
        blocks = np.where((lags > 0)[:, :, None, None], blocks.transpose(0, 1, 3, 2), blocks)
        whole = blocks.transpose(0, 2, 1, 3).reshape(p * m, p * m)
        wide = slopes.transpose(0, 2, 1).reshape(p * m, m)
        return float(np.sum(cho_solve(cho_factor(whole), wide) @ self.variance * wide))

    def _spectra(self, columns: Array, size: int) -> NDArray[np.complex128]:
        """Return the Fourier transforms of columns (m n, k) by output, (f, m, k)."""
        by_sample = columns.reshape(-1, self.outputs, columns.shape[1])
        return np.asarray(rfft(by_sample, size, axis=0))


def _mean_product(one: NDArray[np.complex128], other: NDArray[np.complex128], size: int) -> Array:
    """Return the mean over all frequencies of ``one^H other``, (k, l).

    Parameters
    ----------
    one, other : (f, m, k) and (f, m, l) arrays
        Values at frequencies of 0 or more.
    size : int
        Number of all frequencies.
    """
    weights = np.full(len(one), 2 / size)  # for negative frequencies too
    weights[0] = weights[size // 2 + size % 2 :] = 1 / size
    left, right = (
        each.reshape(-1, each.shape[2]) for each in (one, other * weights[:, None, None])
    )
    return np.asarray((left.conj().T @ right).real)


def autoregression_of(
    pieces: Sequence[Array],
    period: float,
    counted: Sequence[NDArray[np.bool_]] | None = None,
    outputs: int = 1,
) -> Autoregression:
    """Return the autoregression of errors by Yule-Walker, with the order by Akaike's criterion.

    Parameters
    ----------
    pieces : sequence of (n,) array
        Stretches without gaps; between stretches there is no correlation.
    period : float
        Sampling period, s.
    counted : sequence of (n,) array of bool, optional
        True for measured errors; other errors are 0, and pairs with them are left out.
    outputs : int
        Number of outputs m, whose rows of a sample are neighbours.
    """
    rows = sum(map(len, pieces)) // outputs
    there = np.concatenate([*(each[::outputs] for each in counted or ()), np.zeros(0, dtype=bool)])
    used = rows if counted is None else int(np.sum(there))
    if not used:
        return levinson_whittle(np.zeros((1, outputs, outputs)), 0)
    most = min(max(round(_LONGEST / period), _FEWEST), used // (_ROWS_PER_ORDER * outputs))
    order = RowTimes.joined([RowTimes.consecutive(len(each) // outputs) for each in pieces])
    products = order.autocovariances(np.concatenate(pieces).reshape(-1, outputs), most)
    if used < rows:
        # Masked samples: scale the sums to all pairs; leave out lags with few measured pairs.
        whole, pairs = (
            np.rint(order.autocovariances(each[:, None], most))
            for each in (np.ones(rows), there.astype(float))
        )
        few = np.flatnonzero(pairs < _MIN_PAIRS * used)
        told = slice(0, int(few[0]) if len(few) else None)
        products = products[told] * whole[told] / pairs[told]
        used = int(pairs[told].min())  # the criterion must not count pairs that are missing
    return levinson_whittle(products / rows, used)


def levinson_whittle(covariances: Array, samples: int) -> Autoregression:
    """Return the autoregression of minimal ``N log det V + 2 p m^2`` over the orders p.

    Levinson's recursion for several outputs [Whittle1963]_: forward and backward autoregressions of
    order p give those of order p + 1. Several outputs get independent noise of a thousandth of
    their standard deviation each, as one output may be a function of the others.

    Parameters
    ----------
    covariances : (p + 1, m, m) array
        Autocovariances.
    samples : int
        Number N of samples from which they were estimated.
    """
    lagged = covariances.copy()
    if len(lagged[0]) > 1:
        lagged[0] = lagged[0] + np.diag(_OWN * np.diag(lagged[0]))
    unit = np.eye(len(lagged[0]))[None]
    ahead, behind, v, u = unit, unit, lagged[0], lagged[0]
    best = Autoregression(coefficients=unit, variance=v, covariances=lagged[:1])
    if not np.all(np.diag(v) > 0):
        return best
    least = samples * np.linalg.slogdet(v)[1]
    for p in range(1, len(lagged)):
        if p > _PATIENCE + 2 * best.order:
            break  # the cost of an order grows with the order
        partial = np.einsum("pij,pjk->ik", ahead, lagged[p:0:-1])
        first, second = -np.linalg.solve(u.T, partial.T).T, -np.linalg.solve(v.T, partial).T
        pad = np.zeros_like(unit)
        longer, back = np.concatenate([ahead, pad]), np.concatenate([behind, pad])
        ahead, behind = longer + first @ back[::-1], back + second @ longer[::-1]
        v, u = v + first @ partial.T, u + second @ partial
        v, u = (v + v.T) / 2, (u + u.T) / 2
        if min(np.linalg.eigvalsh(v)[0], np.linalg.eigvalsh(u)[0]) <= 0:
            break
        criterion = samples * np.linalg.slogdet(v)[1] + 2 * p * v.size
        if criterion < least:
            least = criterion
            best = Autoregression(coefficients=ahead, variance=v, covariances=lagged[: p + 1])
    return best


def sum_covariances(found: Sequence[CovarianceEstimate]) -> CovarianceEstimate:
    """Return the sum of independent covariances with its degrees of freedom.

    For the sum of variances ``v_i`` with ``nu_i`` degrees of freedom they are
    ``(sum v_i)^2 / sum (v_i^2 / nu_i)`` (Welch-Satterthwaite).
    """
    matrix = np.sum([each.matrix for each in found], axis=0)
    variances = np.diag(matrix)
    per_dof = np.sum([np.diag(each.matrix) ** 2 / each.freedom for each in found], axis=0)
    dof = np.divide(variances**2, per_dof, out=np.full(len(variances), np.inf), where=per_dof > 0)
    return CovarianceEstimate(matrix=matrix, freedom=dof)


def autoregressive_covariance(
    columns: Array, model: Autoregression, spans: Sequence[slice], rows: int, taken: float
) -> CovarianceEstimate:
    """Return ``A' Omega A`` for columns A, (n, k), and errors that follow an autoregression.

    The degrees of freedom are ``2 / relative variance`` of each variance due to the estimated
    autoregression, minus those that the fit has taken from the errors.

    Parameters
    ----------
    columns : (n, k) array
        Influence of the errors on k quantities.
    model : Autoregression
        Autoregression of the errors of one record.
    spans : sequence of slice
        The record's stretches.
    rows : int
        Number of errors from which the model was estimated.
    taken : float
        Degrees of freedom that the fit has taken from the errors.
    """
    zero = np.zeros((columns.shape[1], columns.shape[1]))
    matrix = sum((model.coloured(columns[each]) for each in spans), zero)
    dof_of_model = np.array(
        [2 / model.uncertainty([column[each] for each in spans], rows) for column in columns.T]
    )
    dof = np.maximum(dof_of_model - taken, 1.0)
    inflation = np.divide(
        dof_of_model, dof, out=np.ones_like(dof_of_model), where=np.isfinite(dof_of_model)
    )
    return CovarianceEstimate(matrix=widened(matrix, np.diag(matrix) * inflation), freedom=dof)


def clustered_covariance(
    columns: Array, errors: Array, windows: Sequence[slice]
) -> CovarianceEstimate:
    """Return the covariance ``sum_w s_w s_w'`` of scores ``s_w = A_w' e_w`` clustered by window.

    The errors of windows are independent of each other. Within a window, disturbances are
    integrated twice in the errors of an open loop, which no autoregression describes. A column with
    ``q_w = a_w' a_w`` has the effective number of windows ``(sum q_w)^2 / sum q_w^2``. The variance
    is increased by the share of the errors that the fit has taken, computed for equal errors.

    Parameters
    ----------
    columns : (n, k) array
        Influence A: the change of each parameter by each error.
    errors : (n,) array
        Errors of all windows.
    windows : sequence of slice
        Rows of each window.

    References
    ----------
    [Wooldridge2010]_, chapter 20.
    """
    scores = np.array([columns[rows].T @ errors[rows] for rows in windows])
    own = np.array([columns[rows].T @ columns[rows] for rows in windows])
    whole, inverse = own.sum(axis=0), np.linalg.pinv(own.sum(axis=0), hermitian=True)
    sizes = np.diagonal(own, axis1=1, axis2=2)
    count = sizes.sum(axis=0) ** 2 / np.maximum(np.sum(sizes**2, axis=0), np.finfo(float).tiny)
    remaining = np.diag(whole) - np.einsum("gjk,kl,glj->j", own, inverse, own)
    # A parameter that a single window determines has no scatter over windows.
    is_told = remaining > _ROUNDING * np.diag(whole)
    inflation = np.divide(np.diag(whole), remaining, out=np.ones_like(remaining), where=is_told)
    matrix = scores.T @ scores
    return CovarianceEstimate(
        matrix=widened(matrix, np.diag(matrix) * inflation),
        freedom=np.maximum(count / inflation, 1.0),
    )


def widened(covariance: Array, least: Array) -> Array:
    """Return a covariance, (k, k), with variances raised to at least `least`, (k,).

    The correlations do not change.
    """
    variances = np.diag(covariance)
    ratio = np.divide(least, variances, out=np.ones_like(variances), where=variances > 0)
    scale = np.sqrt(np.maximum(ratio, 1.0))
    return np.asarray(np.outer(scale, scale) * covariance, dtype=float)
