"""How sure an output-error estimate is: the errors are coloured, as the loop colours noise.

Noise of the position comes back through the law, differentiated, so that errors follow one another
with alternating signs; what the model lacks lasts. Both are told by an autoregression of the errors
``a(q) e = w``, of each record its own, with which

    Sigma = (J'J)^-1 (sum_r J_r' C_r J_r) (J'J)^-1,    C the covariances of such errors,

as the prediction-error method has it for errors that are not white [Ljung1999]_ (9.42). C is of
errors that were under way before a stretch begins, so that short stretches count as long ones do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.predictions import Predictions
from axisid.estimation.records import Record
from axisid.estimation.regression import StepsError, beyond_shown
from axisid.estimation.thresholds.fitting import MIN_PAIRS
from axisid.support.arrays import Array

from .search import Found, Weighing
from .unknowns import Unknowns

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
        """Covariance of what columns (n, k) of one stretch make of such errors, (k, k)."""
        from scipy.linalg import matmul_toeplitz

        covariances = self.covariances_to(len(columns))
        moved = [matmul_toeplitz(covariances, column) for column in columns.T]
        return np.asarray(columns.T @ np.column_stack(moved))


def autoregression_of(
    pieces: Sequence[Array], period: float, counted: Sequence[NDArray[np.bool_]] | None = None
) -> Autoregression:
    """The autoregression of errors by Yule and Walker, its order by Akaike's criterion.

    Parameters
    ----------
    pieces : sequence of (n,) array
        Stretches without gaps; none follows another.
    period : float
        s
    counted : sequence of (n,) array of bool, optional
        Which errors are measured; the others are 0, and no pair with one of them counts.
    """
    rows = sum(map(len, pieces))
    used = rows if counted is None else int(sum(map(np.sum, counted)))
    most = min(max(round(_LONGEST / period), _FEWEST), _MOST, used // _ROWS_PER_ORDER)
    products = _products(pieces, most)
    if used < rows and counted is not None:
        whole = _products([np.ones(len(e)) for e in pieces], most)
        pairs = np.rint(_products([each.astype(float) for each in counted], most))
        few = np.flatnonzero(pairs < MIN_PAIRS.value * used)
        told = slice(0, int(few[0]) if len(few) else None)
        products = products[told] * np.rint(whole[told]) / pairs[told]
        used = int(pairs[told].min())  # a criterion that reckons with all takes what chance made
    return _by_durbin(products / rows, used)


def _products(pieces: Sequence[Array], most: int) -> Array:
    """Sums of the products of values so many lags apart, (most + 1,)."""
    from scipy.signal import correlate

    products = np.zeros(most + 1)
    for e in pieces:
        lags = min(most, len(e) - 1)
        found = correlate(e, e, method="fft")[len(e) - 1 : len(e) + lags]
        products[: lags + 1] += found
    return products


def _by_durbin(covariances: Array, rows: int) -> Autoregression:
    """Levinson's and Durbin's recursion, and the order that the criterion takes."""
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
    counted : (n,) array of bool
        Which rows are measured; the others are 0.
    spans : tuple of tuple of slice
        Stretches by record.
    periods : tuple of float
        By record, s.
    """

    jacobian: Array
    errors: Array
    curvature: Array
    known: Array
    counted: NDArray[np.bool_]
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

    @cached_property
    def autoregressions(self) -> tuple[Autoregression, ...]:
        """Of the errors, by record."""
        return tuple(
            autoregression_of(
                [self.errors[rows] for rows in spans],
                period,
                [self.counted[rows] for rows in spans],
            )
            for spans, period in zip(self.spans, self.periods, strict=True)
        )

    def coloured(self, models: Sequence[Autoregression]) -> Array:
        """Covariance for errors that follow these autoregressions, (k, k)."""
        pairs = zip(models, self.spans, strict=True)
        return self._sandwich(sum((self._coloured(*pair) for pair in pairs), self._of_known))

    def independent(self) -> Array:
        """Covariance for independent errors, of each record its own variance, (k, k)."""
        return self._sandwich(sum(map(self._independent, self.spans), self._of_known))

    def by_known(self) -> Array:
        """What the deviations of what was known before add to a covariance, (k, k)."""
        return self._sandwich(self._of_known)

    def effects(self) -> Array:
        """How much more each record's errors tell of what was known if they are independent, (r,).

        Over the variances of what was known: a record whose weights are divided by its square root
        counts beside what was known as its coloured errors allow, for one parameter exactly.
        """
        reach, found = self.known @ self.inverse, []
        for model, spans in zip(self.autoregressions, self.spans, strict=True):
            both = self._coloured(model, spans), self._independent(spans)
            told, white = (float(np.einsum("ij,jk,ik", reach, meat, reach)) for meat in both)
            found.append(told / white if told > 0 and white > 0 else 1.0)
        return np.array(found)

    @property
    def _of_known(self) -> Array:
        return np.asarray(self.known.T @ self.known)

    def _coloured(self, model: Autoregression, spans: Sequence[slice]) -> Array:
        pieces = (model.coloured(self.jacobian[rows]) for rows in spans)
        return sum(pieces, np.zeros_like(self._of_known))

    def _independent(self, spans: Sequence[slice]) -> Array:
        J = np.concatenate([self.jacobian[rows] for rows in spans])
        e = np.concatenate([self.errors[rows] for rows in spans])
        used = sum(int(self.counted[rows].sum()) for rows in spans)
        return np.asarray(float(e @ e) / max(used - J.shape[1], 1) * (J.T @ J))

    def _sandwich(self, meat: Array) -> Array:
        found = self.inverse @ meat @ self.inverse
        return np.asarray((found + found.T) / 2)


def scores_of(
    found: Found,
    weighing: Weighing,
    unknowns: Unknowns,
    predictions: Predictions,
    records: Sequence[Record],
    chosen: NDArray[np.bool_],
) -> Scores:
    """Of the chosen parameters, (P,), where a search of the records' outputs ended."""
    weighed = weighing.weights * found.slopes.errors
    z = (weighed / weighing.tuning) ** 2
    _, first, second = weighing.loss(z)
    return Scores(
        jacobian=(weighing.weights[:, None] * found.slopes.jacobian)[:, chosen],
        errors=first * weighed,
        curvature=np.maximum(first + 2 * z * second, 0.0),
        known=unknowns.known_rows[:, chosen],
        counted=predictions.counted > 0,
        spans=predictions.spans,
        periods=tuple(record.period for record in records),
    )


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
    missing = beyond_shown(moved.T, covariance)
    steps = StepsError(bias=moved.mean(axis=1), missing=missing, loops=moved.shape[1])
    return np.asarray(covariance + steps.covariance)
