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

_LONGEST = 0.1  # s, duration of the highest order of an autoregression
_FEWEST = 20  # orders that are tried for any sampling period
_ROWS_PER_ORDER = 10  # rows for each order and output, at least

_ROUNDING = 1e-9  # relative size of a difference that is rounding
# independent noise that is added to each output, relative to its variance, so that no output is an
# exact function of the other outputs
_ADDED_VARIANCE = 1e-6
_NEGLIGIBLE = 1e-12  # covariance relative to the variance, below which it is set to 0
_LAGS_BETWEEN_TESTS = 256  # lags after which `_NEGLIGIBLE` is tested again
_PATIENCE = 250  # orders beyond twice the best order, after which no higher order is tried


@dataclass(frozen=True, slots=True, kw_only=True)
class Autoregression:
    """Autoregression ``e_t = -A_1 e_{t-1} - ... + w_t`` of m outputs.

    The rows of the outputs alternate: the rows of all outputs at one sample follow each other.

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
        """Order p, the number of coefficients ``A_1, ..., A_p``."""
        return len(self.coefficients) - 1

    @property
    def outputs(self) -> int:
        """Number of outputs m."""
        return len(self.variance)

    def covariances_to(self, lags: int) -> Array:
        """Return the autocovariances ``C_0, ..., C_(lags - 1)`` of the errors, (lags, m, m).

        Beyond the order they follow from ``C_k = -A_1 C_(k-1) - ... - A_p C_(k-p)``. Negligible
        autocovariances are 0.
        """
        m, p = self.outputs, self.order
        found = np.zeros((lags, m, m))
        found[: p + 1] = self.covariances[:lags]
        # The row ``-A_p, ..., -A_1`` of matrices, (m, p m), for the last p autocovariances.
        row = -self.coefficients[:0:-1].transpose(1, 0, 2).reshape(m, p * m)
        for k in range(p + 1, lags if p else 0):
            if k % _LAGS_BETWEEN_TESTS == 0:
                recent, variance = np.abs(found[k - p : k]).max(), np.abs(found[0]).max()
                if recent < _NEGLIGIBLE * variance:
                    break
            found[k] = row @ found[k - p : k].reshape(p * m, m)
        return found

    def coloured(self, columns: Array) -> Array:
        """Return ``A' Omega A`` for columns A, (m n, k), and errors of one stretch, (k, k).

        Omega is the covariance matrix of the errors of the n samples, a block Toeplitz matrix. The
        product is computed by Fourier transforms of at least twice the length of the stretch, so
        that there is no wrap-around.
        """
        n = len(columns) // self.outputs
        if not n:
            return np.zeros((columns.shape[1],) * 2)
        size = next_fast_len(2 * n - 1, real=True)
        # Autocovariances of positive lags at the beginning, of negative lags at the end.
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
        # Derivatives of ``a' Omega a`` by W, (m, m), and by the coefficients of each lag. The
        # spectrum of the errors is ``H W H^H`` with the inverse H of that of the coefficients.
        by_variance, by_lag = np.zeros_like(self.variance), np.zeros_like(self.covariances)
        response = np.linalg.inv(rfft(self.coefficients, size, axis=0))
        for piece in pieces:
            # The column seen by the innovations, ``H^H a``, (f, m, 1).
            seen = response.conj().transpose(0, 2, 1) @ self._spectra(piece[:, None], size)
            as_row = seen.transpose(0, 2, 1)
            by_variance += _mean_product(as_row, as_row, size)
            crossed = (response @ self.variance @ seen).conj().transpose(0, 2, 1)
            by_lag -= 2 * irfft(seen * crossed, size, axis=0)[: self.order + 1]
        value = float(np.sum(by_variance * self.variance))  # a' Omega a
        if not value > 0:
            return 2 / samples
        # Variances of ``a' Omega a`` for N = 1, due to W and due to the coefficients.
        product = self.variance @ by_variance
        variance = 2 * float(np.sum(product * product.T))
        if self.order:
            variance += self._variance_by_coefficients(by_lag[1:])
        return variance / samples / value / value

    def _variance_by_coefficients(self, slopes: Array) -> float:
        """Return the variance of a number due to the estimated coefficients, for N = 1 sample.

        `slopes`, (p, m, m), has the derivatives of the number by the coefficients.
        """
        from scipy.linalg import cho_factor, cho_solve

        p, m = self.order, self.outputs
        # The block Toeplitz covariance C of p errors, (p m, p m).
        lags = np.subtract.outer(np.arange(p), np.arange(p))
        blocks = self.covariances[np.abs(lags)]
        blocks = np.where((lags > 0)[:, :, None, None], blocks.transpose(0, 1, 3, 2), blocks)
        toeplitz = blocks.transpose(0, 2, 1, 3).reshape(p * m, p * m)
        stacked = slopes.transpose(0, 2, 1).reshape(p * m, m)
        return float(np.sum(cho_solve(cho_factor(toeplitz), stacked) @ self.variance * stacked))

    def _spectra(self, columns: Array, size: int) -> NDArray[np.complex128]:
        """Return the Fourier transforms of columns, (m n, k), by frequency and output, (f, m, k).

        `size` is the length of the transform, in samples.
        """
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
    # Twice for negative frequencies, except for frequency 0 and the Nyquist frequency.
    weights = np.full(len(one), 2 / size)
    weights[0] = weights[size // 2 + size % 2 :] = 1 / size
    weighted = other * weights[:, None, None]
    left, right = one.reshape(-1, one.shape[2]), weighted.reshape(-1, other.shape[2])
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
    pieces : sequence of (m n,) array
        Errors of stretches without gaps; between stretches there is no correlation. The rows of all
        outputs at one sample follow each other.
    period : float
        Sampling period, s.
    counted : sequence of (m n,) array of bool, optional
        True for measured errors; the other errors are 0, and pairs with them are left out. By
        default all errors are measured.
    outputs : int
        Number of outputs m.
    """
    rows = sum(map(len, pieces)) // outputs
    # True for each measured sample; empty if all are measured.
    masks = [each[::outputs] for each in counted or ()]
    is_measured = np.concatenate([*masks, np.zeros(0, dtype=bool)])
    used = rows if counted is None else int(np.sum(is_measured))
    if not used:
        return levinson_whittle(np.zeros((1, outputs, outputs)), 0)
    most = min(max(round(_LONGEST / period), _FEWEST), used // (_ROWS_PER_ORDER * outputs))
    order = RowTimes.joined([RowTimes.consecutive(len(each) // outputs) for each in pieces])
    products = order.autocovariances(np.concatenate(pieces).reshape(-1, outputs), most)
    if used < rows:
        # Masked samples: scale the sums to all pairs; leave out lags with few measured pairs.
        all_pairs = np.rint(order.autocovariances(np.ones(rows)[:, None], most))
        pairs = np.rint(order.autocovariances(is_measured.astype(float)[:, None], most))
        few = np.flatnonzero(pairs < _MIN_PAIRS * used)
        usable = slice(0, int(few[0]) if len(few) else None)
        products = products[usable] * all_pairs[usable] / pairs[usable]
        used = int(pairs[usable].min())  # the criterion must not count pairs that are missing
    return levinson_whittle(products / rows, used)


def levinson_whittle(covariances: Array, samples: int) -> Autoregression:
    """Return the autoregression of minimal ``N log det V + 2 p m^2`` over the orders p.

    V is the covariance of the innovations. Levinson's recursion for several outputs [Whittle1963]_:
    forward and backward autoregressions of order p give those of order p + 1. Independent noise of
    a thousandth of its standard deviation is added to each of several outputs, because one output
    may be a function of the others.

    Parameters
    ----------
    covariances : (p + 1, m, m) array
        Autocovariances.
    samples : int
        Number N of samples from which they were estimated.
    """
    lagged = covariances.copy()
    if len(lagged[0]) > 1:
        lagged[0] = lagged[0] + np.diag(_ADDED_VARIANCE * np.diag(lagged[0]))
    # Coefficients of the forward and of the backward autoregression, (p + 1, m, m), and the
    # covariances v and u of their innovations.
    unit = np.eye(len(lagged[0]))[None]
    ahead, behind, v, u = unit, unit, lagged[0], lagged[0]
    best = Autoregression(coefficients=unit, variance=v, covariances=lagged[:1])
    if not np.all(np.diag(v) > 0):
        return best
    least = samples * np.linalg.slogdet(v)[1]
    for p in range(1, len(lagged)):
        if p > _PATIENCE + 2 * best.order:
            break  # the cost of an order grows with the order
        # Partial covariance at lag p, and the last coefficients of the next order.
        partial = np.einsum("pij,pjk->ik", ahead, lagged[p:0:-1])
        first, second = -np.linalg.solve(u.T, partial.T).T, -np.linalg.solve(v.T, partial).T
        pad = np.zeros_like(unit)
        longer, back = np.concatenate([ahead, pad]), np.concatenate([behind, pad])
        ahead, behind = longer + first @ back[::-1], back + second @ longer[::-1]
        v, u = v + first @ partial.T, u + second @ partial
        v, u = (v + v.T) / 2, (u + u.T) / 2
        if min(np.linalg.eigvalsh(v)[0], np.linalg.eigvalsh(u)[0]) <= 0:
            break  # by rounding
        criterion = samples * np.linalg.slogdet(v)[1] + 2 * p * v.size
        if criterion < least:
            least = criterion
            best = Autoregression(coefficients=ahead, variance=v, covariances=lagged[: p + 1])
    return best


def sum_covariances(found: Sequence[CovarianceEstimate]) -> CovarianceEstimate:
    """Return the sum of independent covariances with its degrees of freedom.

    The degrees of freedom of a sum of variances ``v_i`` with ``nu_i`` degrees of freedom are
    ``(sum v_i)^2 / sum (v_i^2 / nu_i)`` (Welch-Satterthwaite). They are infinite for a variance of
    0.
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

    Each variance has the degrees of freedom ``2 / r``, with its relative variance r due to the
    estimated autoregression, minus the degrees of freedom that the fit has taken from the errors.
    The variances are increased by the ratio of the two.

    Parameters
    ----------
    columns : (n, k) array
        Influence A of the errors on k quantities.
    model : Autoregression
        Autoregression of the errors of one record.
    spans : sequence of slice
        The record's stretches.
    rows : int
        Number of errors from which the model was estimated.
    taken : float
        Degrees of freedom that the fit has taken from the errors.
    """
    # Stretches are independent of each other.
    matrix = np.zeros((columns.shape[1], columns.shape[1]))
    for span in spans:
        matrix = matrix + model.coloured(columns[span])
    dof_of_model = np.array(
        [2 / model.uncertainty([column[span] for span in spans], rows) for column in columns.T]
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
    # Scores, (w, k), and products ``A_w' A_w``, (w, k, k), of each window.
    scores = np.array([columns[rows].T @ errors[rows] for rows in windows])
    products = np.array([columns[rows].T @ columns[rows] for rows in windows])
    whole = products.sum(axis=0)
    inverse = np.linalg.pinv(whole, hermitian=True)
    # Effective number of windows of each column.
    sizes = np.diagonal(products, axis1=1, axis2=2)
    count = sizes.sum(axis=0) ** 2 / np.maximum(np.sum(sizes**2, axis=0), np.finfo(float).tiny)
    # Variance that remains after the fit, for equal errors. A parameter that a single window
    # determines has no scatter over windows, and is not inflated.
    remaining = np.diag(whole) - np.einsum("gjk,kl,glj->j", products, inverse, products)
    has_scatter = remaining > _ROUNDING * np.diag(whole)
    inflation = np.divide(np.diag(whole), remaining, out=np.ones_like(remaining), where=has_scatter)
    matrix = scores.T @ scores
    return CovarianceEstimate(
        matrix=widened(matrix, np.diag(matrix) * inflation),
        freedom=np.maximum(count / inflation, 1.0),
    )


def widened(covariance: Array, least: Array) -> Array:
    """Return a covariance, (k, k), with variances raised to at least `least`, (k,).

    Rows and columns are scaled, so that the correlations do not change. A variance of 0 stays 0.
    """
    variances = np.diag(covariance)
    ratio = np.divide(least, variances, out=np.ones_like(variances), where=variances > 0)
    scale = np.sqrt(np.maximum(ratio, 1.0))
    return np.asarray(np.outer(scale, scale) * covariance, dtype=float)
