"""Errors that follow one another, as an autoregression."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.support.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Autoregression:
    """``e_t = -a_1 e_{t-1} - ... + w_t``.

    Attributes
    ----------
    coefficients : (p + 1,) array
        ``1, a_1, ..., a_p``.
    variance : float
        Of w.
    covariances : (p + 1,) array
        ``c_0, ..., c_p`` of the errors, from which the coefficients follow.
    """

    coefficients: Array
    variance: float
    covariances: Array

    @property
    def order(self) -> int:
        """How many errors before it count."""
        return len(self.coefficients) - 1

    @property
    def innovations(self) -> Array:
        """Variance of w as that of one output, (1,)."""
        return np.array([self.variance])

    def covariances_to(self, lags: int) -> Array:
        """``c_0, ..., c_(lags - 1)`` of errors that follow it: ``c_k = -a_1 c_(k-1) - ...``."""
        from scipy.signal import lfilter, lfiltic

        known, a = self.covariances, self.coefficients
        more = lags - len(known)
        if more <= 0 or not self.order:
            return np.concatenate([known, np.zeros(max(more, 0))])[:lags]
        before = lfiltic([1.0], a, known[:0:-1])
        later, _ = lfilter([1.0], a, np.zeros(more), zi=before)
        return np.concatenate([known, later])

    def coloured(self, columns: Array) -> Array:
        """Covariance of what columns (n, k) of one stretch make of such errors, (k, k).

        By the spectra of both, on a circle that is longer than twice the stretch: of lags beyond it
        columns have no products.
        """
        from scipy.fft import next_fast_len, rfft

        n = len(columns)
        if not n:
            return np.zeros((columns.shape[1], columns.shape[1]))
        size = next_fast_len(2 * n - 1, real=True)
        circle = np.zeros(size)
        circle[:n] = self.covariances_to(n)
        circle[size - n + 1 :] = circle[n - 1 : 0 : -1]
        power = rfft(circle).real
        power[1 : (size + 1) // 2] *= 2  # of frequencies below 0 too
        spectra = rfft(columns, size, axis=0)
        return np.asarray((spectra.conj().T @ (power[:, None] * spectra)).real / size)

    def uncertainty(self, pieces: Sequence[Array], rows: int) -> float:
        """Variance of what it makes of columns over its square, as it is found from so many errors.

        The coefficients of an autoregression have the covariance ``variance / rows`` times the
        inverse of that of as many errors [Ljung1999]_; the slopes by them are taken in the
        frequency domain.

        Parameters
        ----------
        pieces : sequence of (n,) array
            The column in each stretch.
        rows : int
            Errors that it was found from.
        """
        from scipy.fft import irfft, next_fast_len, rfft
        from scipy.linalg import solve_toeplitz

        if not rows:
            return np.inf
        if not self.order or not self.variance > 0:
            return 2 / rows
        longest = max(map(len, pieces))
        size = next_fast_len(longest + max(longest, self.order + 1), real=True)
        power = sum((np.abs(rfft(piece, size)) ** 2 for piece in pieces), np.zeros(size // 2 + 1))
        answer = rfft(self.coefficients, size)
        power = power * self.variance / np.abs(answer) ** 2
        slopes = -2 * irfft(power / answer.conj(), size)[1 : self.order + 1]
        spread = self.variance / rows * solve_toeplitz(self.covariances[: self.order], slopes)
        whole = float(irfft(power, size)[0])
        return float(slopes @ spread) / whole**2 + 2 / rows if whole > 0 else 2 / rows


def by_durbin(covariances: Array, rows: int) -> Autoregression:
    """By Levinson's and Durbin's recursion, of the order that the criterion takes.

    Parameters
    ----------
    covariances : (p + 1,) array
    rows : int
        From which they are found.
    """
    a, variance = np.array([1.0]), float(covariances[0])
    best = Autoregression(coefficients=a, variance=variance, covariances=covariances[:1])
    if not variance > 0:
        return best
    least = rows * np.log(variance)
    for p in range(1, len(covariances)):
        reflection = -float(a @ covariances[p:0:-1]) / variance
        if not abs(reflection) < 1:
            break
        longer = np.append(a, 0.0)
        a = longer + reflection * longer[::-1]
        variance *= 1 - reflection**2
        criterion = rows * np.log(variance) + 2 * p
        if criterion < least:
            least = criterion
            best = Autoregression(
                coefficients=a, variance=variance, covariances=covariances[: p + 1]
            )
    return best
