"""What is kept of the rows of a log: triangular factors, and products of neighbouring scores."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from axisid.estimation.regression import Equations, Hac, LongRun, score_products
from axisid.estimation.signals import Neighbours
from axisid.support.arrays import Array, relative_error_percent

from .log_rows import LogRows, Rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Factored:
    """A triangular factor in place of rows: its columns have the same products as theirs.

    Attributes
    ----------
    triangle : (q, q) array
        Of the loop's regressor and intercept, if there is a loop, then the measured regressor, its
        left side less the intercept, and the left side.
    size : int
        Rows there are.
    parameters : int
    """

    triangle: Array
    size: int
    parameters: int

    @property
    def _measured(self) -> Array:
        return self.triangle[:, -(self.parameters + 2) :]

    @property
    def both(self) -> Array:
        """Regressor, and the left side less the intercept, (q, p + 1)."""
        return self._measured[:, :-1]

    @property
    def left(self) -> float:
        """Norm of the left side."""
        return float(np.linalg.norm(self._measured[:, -1]))

    @property
    def equations(self) -> Equations:
        """As if these columns were the rows."""
        both, left = self.both, self._measured[:, -1]
        return Equations(left=left, intercept=left - both[:, -1], regressor=both[:, :-1])

    @property
    def loop(self) -> tuple[Array, Array]:
        """Regressor and intercept of the loop, (q, p) and (q,)."""
        return self.triangle[:, : self.parameters], self.triangle[:, self.parameters]

    def unexplained(self, theta: Array) -> float:
        """What the loop leaves of the left side with parameters (p,), in %."""
        regressor, intercept = self.loop
        left = self._measured[:, -1]
        return relative_error_percent(left - regressor @ theta - intercept, left)


def factored(rows: LogRows) -> Factored:
    """The rows of a pass, factored."""
    triangle, size = np.zeros((0, 0)), 0
    for piece in rows:
        columns = np.column_stack([piece.loop, piece.both, piece.left])
        triangle = triangle if triangle.size else np.zeros((columns.shape[1],) * 2)
        _, triangle = np.linalg.qr(np.vstack([triangle, columns]))
        size += len(columns)
    return Factored(triangle=triangle, size=size, parameters=len(rows.axis.parameters))


@dataclass(frozen=True, slots=True, kw_only=True)
class Scores:
    """What each row does to an estimate: its influence times its residual.

    Attributes
    ----------
    theta : (p,) array
    mixing : (p, p) array
        Of the columns that act on the residuals: the loop's, or the measured ones without a loop.
    """

    theta: Array
    mixing: Array

    def of(self, piece: Rows) -> Array:
        """Of some rows, (n, p)."""
        regressor, left = piece.both[:, :-1], piece.both[:, -1]
        acting = piece.loop[:, :-1] if piece.loop.size else regressor
        return acting @ self.mixing * (left - regressor @ self.theta)[:, None]


def long_run(rows: LogRows, scores: Scores, size: int) -> tuple[Array, Array, LongRun]:
    """Covariances as `Robust` and `Hac` have them, and how the latter was found."""
    # The kernel alone: rows are not kept, and a log that is streamed is long.
    products: Callable[[int], Array] = partial(_products_over, rows, scores)
    found = Hac().long_run(products, size)
    correction = size / (size - len(scores.theta))
    return correction * found.power, correction * found.covariance, found


def _products_over(rows: LogRows, scores: Scores, lags: int) -> Array:
    return rows.over(partial(_score_products, scores=scores, lags=lags))


def _score_products(rows: LogRows, scores: Scores, lags: int) -> Array:
    """``sum s_t s_(t-lag)'`` of the scores for each lag from 0, (lags + 1, p, p)."""
    width = len(scores.theta)
    products = np.zeros((lags + 1, width, width))
    kept, places = np.empty((0, width)), np.empty(0, dtype=np.int64)
    for piece in rows:
        old = len(kept)
        kept = np.vstack([kept, scores.of(piece)])
        places = np.concatenate([places, piece.places])
        products += score_products(kept, Neighbours(places), lags, first=old)
        spent = max(len(kept) - lags, 0)  # more than are within the lags, where rows are missing
        kept, places = kept[spent:], places[spent:]
    return products
