"""Errors of several outputs that follow one another, and each other, as an autoregression.

A control's errors are made of the position's by the law, so that one output hardly has any of its
own: what they make of parameters is told of both together or not at all.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.support.arrays import Array

_OWN = 1e-6  # of each output's variance: what no other output and no past tells of it
_PATIENCE = 250  # orders beyond twice the best one, after which none longer is tried
_WRAPPED = 2  # times a stretch, after which errors have forgotten what was


@dataclass(frozen=True, slots=True, kw_only=True)
class VectorAutoregression:
    """``e_t = -A_1 e_{t-1} - ... + w_t`` of m outputs, whose rows of a sample are neighbours.

    Attributes
    ----------
    coefficients : (p + 1, m, m) array
        ``1, A_1, ..., A_p``.
    variance : (m, m) array
        Of w.
    covariances : (p + 1, m, m) array
        Of the errors with those so many samples before.
    """

    coefficients: Array
    variance: Array
    covariances: Array

    @property
    def order(self) -> int:
        """How many samples before count."""
        return len(self.coefficients) - 1

    @property
    def innovations(self) -> Array:
        """Variances of w, (m,)."""
        return np.diag(self.variance)

    @property
    def outputs(self) -> int:
        """How many."""
        return len(self.variance)

    def coloured(self, columns: Array) -> Array:
        """Covariance of what columns (m n, k) of one stretch make of such errors, (k, k)."""
        size = self._size(len(columns))
        seen = self._whitened(self._spectra(columns, size), size)
        return _summed(seen.conj().transpose(0, 2, 1) @ (self.variance @ seen), size)

    def uncertainty(self, pieces: Sequence[Array], rows: int) -> float:
        """Variance of what it makes of columns over its square, as it is found from so many errors.

        As of an autoregression of one output: the coefficients have the covariance of the inverse
        of that of so many errors, times that of w [Ljung1999]_, and w's own covariance is sure as
        that of so many normal ones is.

        Parameters
        ----------
        pieces : sequence of (m n,) array
            The column in each stretch.
        rows : int
            Errors that it was found from.
        """
        samples = max(rows // self.outputs, 1)
        size = self._size(max(map(len, pieces)))
        spread, by_lag = np.zeros_like(self.variance), np.zeros_like(self.covariances)
        answer = self._answer(size)
        for piece in pieces:
            seen = self._whitened(self._spectra(piece[:, None], size), size)[:, :, 0]
            back = np.linalg.solve(answer, (seen @ self.variance)[:, :, None])[:, :, 0]
            outer = np.einsum("wi,wj->wij", seen.conj(), seen)
            spread = spread + _summed(outer, size)
            crossed = np.einsum("wi,wj->wij", seen, back.conj())
            by_lag -= 2 * _by_lag(crossed, size)[: self.order + 1]
        whole = float(np.sum(spread * self.variance))
        if not whole > 0:
            return 2 / samples
        moved = self.variance @ spread
        share = 2 * float(np.sum(moved * moved.T))
        if self.order:
            share += self._of_coefficients(by_lag[1:])
        return share / samples / whole**2

    def _of_coefficients(self, slopes: Array) -> float:
        """Variance by that of the coefficients, for one sample, of slopes (p, m, m) by them."""
        from scipy.linalg import cho_factor, cho_solve

        p, m = self.order, self.outputs
        lags = np.subtract.outer(np.arange(p), np.arange(p))
        blocks = self.covariances[np.abs(lags)]
        blocks = np.where((lags > 0)[:, :, None, None], blocks.transpose(0, 1, 3, 2), blocks)
        whole = blocks.transpose(0, 2, 1, 3).reshape(p * m, p * m)
        wide = slopes.transpose(0, 2, 1).reshape(p * m, m)
        return float(np.sum(cho_solve(cho_factor(whole), wide) @ self.variance * wide))

    def _size(self, rows: int) -> int:
        from scipy.fft import next_fast_len

        samples = rows // self.outputs
        return int(next_fast_len((1 + _WRAPPED) * max(samples, self.order + 1), real=True))

    def _spectra(self, columns: Array, size: int) -> Array:
        """Of columns (m n, k), by frequency, (f, m, k)."""
        from scipy.fft import rfft

        own = columns.reshape(-1, self.outputs, columns.shape[1])
        return np.asarray(rfft(own, size, axis=0))

    def _answer(self, size: int) -> Array:
        """Of the autoregression by frequency, (f, m, m)."""
        from scipy.fft import rfft

        return np.asarray(rfft(self.coefficients, size, axis=0))

    def _whitened(self, spectra: Array, size: int) -> Array:
        """What columns make of w, by frequency."""
        back = self._answer(size).conj().transpose(0, 2, 1)
        return np.asarray(np.linalg.solve(back, spectra))


def by_whittle(covariances: Array, samples: int) -> VectorAutoregression:
    """By the recursion of Levinson for several outputs, of the order that the criterion takes.

    [Whittle1963]_: autoregressions forwards and backwards make each other longer. Each output has
    a part of its own, of a thousandth of its size, as one may be a function of the others.

    Parameters
    ----------
    covariances : (p + 1, m, m) array
    samples : int
        From which they are found.
    """
    own = covariances.copy()
    own[0] = own[0] + np.diag(_OWN * np.diag(own[0]))
    unit = np.eye(len(own[0]))[None]
    ahead, behind, v, u = unit, unit, own[0], own[0]
    best = VectorAutoregression(coefficients=unit, variance=v, covariances=own[:1])
    if not np.all(np.diag(v) > 0):
        return best
    least = samples * np.linalg.slogdet(v)[1]
    for p in range(1, len(own)):
        if p > _PATIENCE + 2 * best.order:
            break  # each order costs as many products as there are orders below it
        partial = np.einsum("pij,pjk->ik", ahead, own[p:0:-1])
        first, second = -np.linalg.solve(u.T, partial.T).T, -np.linalg.solve(v.T, partial).T
        pad = np.zeros_like(unit)
        longer, back = np.concatenate([ahead, pad]), np.concatenate([behind, pad])
        ahead, behind = longer + first @ back[::-1], back + second @ longer[::-1]
        v, u = _symmetric(v + first @ partial.T), _symmetric(u + second @ partial)
        if min(np.linalg.eigvalsh(v)[0], np.linalg.eigvalsh(u)[0]) <= 0:
            break
        criterion = samples * np.linalg.slogdet(v)[1] + 2 * p * v.size
        if criterion < least:
            least = criterion
            best = VectorAutoregression(coefficients=ahead, variance=v, covariances=own[: p + 1])
    return best


def _symmetric(matrix: Array) -> Array:
    return np.asarray((matrix + matrix.T) / 2)


def _by_lag(spectra: Array, size: int) -> Array:
    """From values at the frequencies from 0 on to those at lags, (n, ...)."""
    from scipy.fft import irfft

    return np.asarray(irfft(spectra, size, axis=0))


def _summed(spectra: Array, size: int) -> Array:
    """Mean over all frequencies, of those from 0 on."""
    return np.asarray(_by_lag(spectra, size)[0])
