"""How sure an output-error estimate is: the errors are coloured, as the loop colours noise.

Noise of the position comes back through the law, differentiated, so that errors follow one another
with alternating signs; what the model lacks lasts. Both are told by an autoregression of the errors
``a(q) e = w``, of each record its own, with which

    Sigma = (J'J)^-1 (sum_r v_r G_r'G_r) (J'J)^-1,    G = 1/a run backwards along J,

as the prediction-error method has it for errors that are not white [Ljung1999]_ (9.42).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from axisid.estimation.regression import StepsError
from axisid.support.arrays import Array

_LONGEST = 0.1  # s, of the autoregression
_FEWEST, _MOST = 20, 1000  # orders that are tried, whatever the period
_ROWS_PER_ORDER = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Autoregression:
    """``e_t = -a_1 e_{t-1} - ... + w_t``.

    Attributes
    ----------
    coefficients : (p + 1,) array
        ``1, a_1, ..., a_p``.
    variance : float
        Of w.
    """

    coefficients: Array
    variance: float

    @property
    def order(self) -> int:
        """How many errors before it count."""
        return len(self.coefficients) - 1

    def coloured(self, columns: Array) -> Array:
        """Columns (n, k) run backwards through ``1/a``: their products with e are those with w."""
        from scipy.signal import lfilter

        return np.asarray(lfilter([1.0], self.coefficients, columns[::-1], axis=0)[::-1])


def autoregression_of(pieces: Sequence[Array], period: float) -> Autoregression:
    """The autoregression of errors by Yule and Walker, its order by Akaike's criterion.

    Parameters
    ----------
    pieces : sequence of (n,) array
        Stretches without gaps; none follows another.
    period : float
        s
    """
    from scipy.signal import correlate

    rows = sum(map(len, pieces))
    most = min(max(round(_LONGEST / period), _FEWEST), _MOST, rows // _ROWS_PER_ORDER)
    products = np.zeros(most + 1)
    for e in pieces:
        lags = min(most, len(e) - 1)
        found = correlate(e, e, method="fft")[len(e) - 1 : len(e) + lags]
        products[: lags + 1] += found
    return _by_durbin(products / rows, rows)


def _by_durbin(covariances: Array, rows: int) -> Autoregression:
    """Levinson's and Durbin's recursion, and the order that the criterion takes."""
    a, variance = np.array([1.0]), float(covariances[0])
    best = Autoregression(coefficients=a, variance=variance)
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
            least, best = criterion, Autoregression(coefficients=a, variance=variance)
    return best


@dataclass(frozen=True, kw_only=True)
class Scores:
    """What the covariance of an estimate is made of.

    Attributes
    ----------
    jacobian : (n, k) array
        Of the weighted errors by the parameters that are free.
    errors : (n,) array
        Weighted, as the loss lets them count.
    curvature : (n,) array
        Of the loss: by how much each counted error changes with its error.
    known : (j, k) array
        Rows of what was known before, over its deviations.
    spans : tuple of tuple of slice
        Stretches by record.
    periods : tuple of float
        By record, s.
    """

    jacobian: Array
    errors: Array
    curvature: Array
    known: Array
    spans: tuple[tuple[slice, ...], ...]
    periods: tuple[float, ...]

    @cached_property
    def inverse(self) -> Array:
        """Of the curvature of the cost, (k, k), from a triangle of columns of one size."""
        rows = np.vstack([np.sqrt(self.curvature)[:, None] * self.jacobian, self.known])
        size = np.linalg.norm(rows, axis=0)
        size = np.where(size > 0, size, 1.0)
        factor = np.linalg.pinv(np.linalg.qr(rows / size, mode="r")) / size[:, None]
        return np.asarray(factor @ factor.T)

    @property
    def autoregressions(self) -> tuple[Autoregression, ...]:
        """Of the errors, by record."""
        return tuple(
            autoregression_of([self.errors[rows] for rows in spans], period)
            for spans, period in zip(self.spans, self.periods, strict=True)
        )

    def coloured(self, models: Sequence[Autoregression]) -> Array:
        """Covariance for errors that follow these autoregressions, (k, k)."""
        meat = self.known.T @ self.known
        for model, spans in zip(models, self.spans, strict=True):
            for rows in spans:
                G = model.coloured(self.jacobian[rows])
                meat += model.variance * (G.T @ G)
        return self._sandwich(meat)

    def independent(self) -> Array:
        """Covariance for independent errors, of each record its own variance, (k, k)."""
        meat = self.known.T @ self.known
        for spans in self.spans:
            J = np.concatenate([self.jacobian[rows] for rows in spans])
            e = np.concatenate([self.errors[rows] for rows in spans])
            meat += float(e @ e) / max(len(e) - J.shape[1], 1) * (J.T @ J)
        return self._sandwich(meat)

    def _sandwich(self, meat: Array) -> Array:
        found = self.inverse @ meat @ self.inverse
        return np.asarray((found + found.T) / 2)


def with_steps(covariance: Array, moved: Array) -> Array:
    """A covariance with what an encoder's steps add to it, as `StepsError` has it.

    Their error follows from the motion and comes again with it, so that it biases an estimate, and
    no autoregression shows how far it makes one scatter.

    Parameters
    ----------
    covariance : (k, k) array
    moved : (k, B) array
        What steps that begin elsewhere move the parameters by.
    """
    scatter, seen = np.var(moved, axis=1, ddof=1), np.diag(covariance)
    ratio = np.divide(scatter, seen, out=np.ones_like(seen), where=seen > 0)
    beyond = np.sqrt(np.maximum(ratio - 1, 0.0))
    found = StepsError(
        bias=moved.mean(axis=1), missing=np.outer(beyond, beyond) * covariance, loops=moved.shape[1]
    )
    return np.asarray(covariance + found.covariance)
