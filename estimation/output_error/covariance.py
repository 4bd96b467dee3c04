"""Covariance of an output-error estimate, whose errors the loop colours.

The law feeds noise of the position back, differentiated, so that consecutive errors have
alternating signs; errors by a missing term are slow. An autoregression ``a(q) e = w`` of the errors
of each record describes both, with which

    Sigma = (J'J)^-1 (sum_r J_r' C_r J_r) (J'J)^-1,    C the covariances of such errors,

as in the prediction-error method for errors that are not white [Ljung1999]_ (9.42). C is that of
stationary errors also at the beginning of a stretch, so that short stretches are treated like long
ones.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from axisid.estimation.diagnostics import covariance_of_twins
from axisid.estimation.nonlinear_least_squares import SearchResult, WeightedLoss
from axisid.estimation.output_residuals import OutputResiduals, record_rows
from axisid.estimation.records import Record
from axisid.estimation.regression import (
    Autoregression,
    CovarianceEstimate,
    autoregression_of,
    autoregressive_covariance,
    clustered_covariance,
    sum_covariances,
)
from axisid.estimation.thresholds import MIN_SHOWN
from axisid.estimation.unknowns import Unknowns
from axisid.support.arrays import Array, BoolArray, column_sizes

# A parameter is part of a direction that the outputs do not show, if the parameter alone would
# change the outputs by more than this share of the largest such change.
_MIN_PART = 0.1


def unseen_directions(jacobian: Array, scale: Array, free: BoolArray) -> tuple[Array, BoolArray]:
    """Return directions in which the parameters change, but the errors do not.

    Parameters
    ----------
    jacobian : (n, P) array
        Derivatives of the weighted errors, and of the errors of prior values.
    scale : (P,) array
        Scales of the parameters.
    free : (P,) array of bool
        True for free parameters; columns of the others are 0.

    Returns
    -------
    (k, P) array
        Common changes of the parameters in each of k directions.
    (k, P) array of bool
        True for parameters that are part of the direction: by the change of the outputs that each
        parameter alone would make.
    """
    # A free parameter without effect on the errors is a separate direction. `changes` are in units
    # of the effect on the errors, `moves` are those of the parameters.
    scaled = jacobian * scale
    sizes = np.linalg.norm(scaled, axis=0)
    seen = sizes > MIN_SHOWN.value * sizes.max(initial=0.0)
    moves = changes = np.eye(len(sizes))[free & ~seen]
    # Combinations of the other parameters, by small singular values of columns of equal size.
    if seen.any():
        _, values, rows = np.linalg.svd(np.linalg.qr(scaled[:, seen] / sizes[seen], mode="r"))
        unseen, into = rows[values <= MIN_SHOWN.value * values[0]], np.eye(len(sizes))[seen]
        changes = np.vstack([changes, unseen @ into])
        moves = np.vstack([moves, (unseen / sizes[seen] * scale[seen]) @ into])
    size = np.abs(changes)
    return moves, size > _MIN_PART * size.max(axis=1, keepdims=True, initial=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class UnseenDirection:
    """A parameter, or a combination of parameters, that no output shows.

    Attributes
    ----------
    parameters : tuple of str
    changes : tuple of float
        Common changes of the parameters without any effect, relative to the first.
    """

    parameters: tuple[str, ...]
    changes: tuple[float, ...] = (1.0,)


def named_directions(
    moves: Array, parts: BoolArray, names: Sequence[str]
) -> tuple[UnseenDirection, ...]:
    """Return the directions of `unseen_directions` with the names of their parameters."""
    directions = []
    for move, part in zip(moves, parts, strict=True):
        changes = move[part] / move[part][0]
        directions.append(
            UnseenDirection(
                parameters=tuple(names[int(j)] for j in np.flatnonzero(part)),
                changes=tuple(map(float, changes)),
            )
        )
    return tuple(directions)


# Smallest singular value that is inverted, relative to the largest. A hardly shown parameter above
# this limit has a large standard error.
_LEAST_SINGULAR_VALUE = MIN_SHOWN.value / 2


@dataclass(frozen=True, kw_only=True)
class Sandwich:
    """The parts of the sandwich covariance of an estimate.

    The sandwich is the inverse curvature of the cost, times the covariance of its gradient (the
    score), times the inverse curvature.

    Attributes
    ----------
    jacobian : (n, k) array
        Derivatives of the weighted errors by the free parameters.
    errors : (n,) array
        Weighted errors times the slope of the loss.
    curvature : (n,) array
        Derivatives of these errors by the weighted errors.
    known : (j, k) array
        Rows of the prior values, divided by their standard errors.
    counts : (n,) array
        Weights of the errors times the slope of the loss; 0 where nothing is measured.
    spans : tuple of tuple of slice
        Stretches by record.
    periods : tuple of float
        Sampling periods by record, s.
    outputs : int
        Number of outputs; their rows of one sample are adjacent.
    twins : (n, R) array or None
        Changes of the weighted errors by the noise of simulated replicas.
    """

    jacobian: Array
    errors: Array
    curvature: Array
    known: Array
    counts: Array
    spans: tuple[tuple[slice, ...], ...]
    periods: tuple[float, ...]
    outputs: int = 1
    twins: Array | None = None

    @property
    def counted(self) -> BoolArray:
        """True for rows that are measurements and have weight, (n,)."""
        return self.counts > 0

    @cached_property
    def inverse(self) -> Array:
        """Inverse of the curvature of the cost, (k, k), from scaled columns.

        Directions without any effect are left out; `inferred` reports infinite variances for them.
        Otherwise their rounding errors would be in the variances of all other parameters.
        """
        rows = np.vstack([np.sqrt(self.curvature)[:, None] * self.jacobian, self.known])
        size = column_sizes(rows)
        triangle = np.linalg.qr(rows / size, mode="r")
        factor = np.linalg.pinv(triangle, rcond=_LEAST_SINGULAR_VALUE) / size[:, None]
        return np.asarray(factor @ factor.T)

    def influence(self, weights: Array) -> Array:
        """Return the influence of the errors of the outputs on the parameters, (k, n).

        Additional errors e, (n,), change the parameters by minus the influence times e. `weights`,
        (n,), are the weights of the errors.
        """
        weighed = self.curvature[:, None] * self.jacobian * weights[:, None]
        return np.asarray(self.inverse @ weighed.T)

    @cached_property
    def autoregressions(self) -> tuple[Autoregression, ...]:
        """Autoregressions of the errors, by record."""
        return tuple(
            autoregression_of(
                [self.errors[rows] for rows in spans],
                period,
                [self.counted[rows] for rows in spans],
                self.outputs,
            )
            for spans, period in zip(self.spans, self.periods, strict=True)
        )

    def coloured(self, *, clustered: bool = False) -> CovarianceEstimate:
        """Return the covariance for autocorrelated errors, (k, k), with degrees of freedom.

        The errors of each record follow an autoregression. If `clustered`, the covariance is
        instead that of the scatter over stretches, which are the windows of an open loop. The part
        that is due to the standard errors of prior values has infinite degrees of freedom.
        """
        columns, known = self.jacobian @ self.inverse, self.by_known()
        if clustered:
            stretches = [rows for spans in self.spans for rows in spans]
            parts = [clustered_covariance(columns, self.errors, stretches)]
        else:
            curved = self.curvature[:, None] * self.jacobian
            parts = [
                self._of_record(columns, r, float(np.sum(columns[rows] * curved[rows])))
                for r, rows in enumerate(map(record_rows, self.spans))
            ]
        by_prior = CovarianceEstimate(matrix=known, freedom=np.full(len(known), np.inf))
        return sum_covariances([*parts, by_prior])

    def _of_record(self, columns: Array, r: int, taken: float) -> CovarianceEstimate:
        """Return the covariance that the errors of one record cause, (j, j).

        Parameters
        ----------
        columns : (n, j) array
            Influence of all errors on j quantities.
        r : int
            Number of the record.
        taken : float
            Degrees of freedom that the fit has taken from the errors of the record.
        """
        spans = self.spans[r]
        used = int(self.counted[record_rows(spans)].sum())
        return autoregressive_covariance(columns, self.autoregressions[r], spans, used, taken)

    def independent(self) -> Array:
        """Return the covariance for independent errors, with a variance by record, (k, k)."""
        return self._sandwich(sum(map(self._independent, self.spans), self.known.T @ self.known))

    def by_known(self) -> Array:
        """Return the covariance that the standard errors of prior values cause, (k, k)."""
        return self._sandwich(self.known.T @ self.known)

    def effects(self) -> Array:
        """Return the ratio of coloured to independent variance by record, (r,); 1 if unknown.

        Coloured errors are autocorrelated. The ratio is that in the directions of the prior values.
        If the weights of a record are divided by the square root of the ratio, the record has the
        weight relative to the prior values that its autocorrelated errors allow. This is exact for
        one parameter.
        """
        reach, ratios = self.known @ self.inverse, []
        for r, spans in enumerate(self.spans):
            coloured = float(np.trace(self._of_record(self.jacobian @ reach.T, r, 0.0).matrix))
            white = float(np.einsum("ij,jk,ik", reach, self._independent(spans), reach))
            ratios.append(coloured / white if coloured > 0 and white > 0 else 1.0)
        return np.array(ratios)

    def beside(self, columns: Array) -> "Sandwich":
        """Return the sandwich with q further parameters, which have no prior values.

        `columns`, (n, q), are the derivatives of the weighted errors by the further parameters.
        """
        nothing = np.zeros((len(self.known), columns.shape[1]))
        return replace(
            self,
            jacobian=np.hstack([self.jacobian, columns]),
            known=np.hstack([self.known, nothing]),
        )

    def extended(self, columns: Array, *, clustered: bool) -> tuple[Array, Array, Array]:
        """Return the changes of an estimate if q further parameters are estimated, to first order.

        Parameters
        ----------
        columns : (n, q) array
            Derivatives of the weighted errors by the further parameters.
        clustered : bool
            As in `coloured`; not used with replicas.

        Returns
        -------
        (k + q,) array, (k + q, k + q) array, (k + q,) array
            Changes of all parameters, their covariance and its degrees of freedom. The covariance
            is that over simulated replicas, or that of autocorrelated errors if there are too few
            replicas.
        """
        # One Gauss-Newton step with the further parameters, then its covariance.
        wide, k = self.beside(columns), self.jacobian.shape[1]
        change = -wide.inverse[:, k:] @ (columns.T @ self.errors)
        if self.twins is not None:
            of_twins = wide.inverse @ (wide.jacobian.T @ self.twins)
            by_twins = covariance_of_twins(of_twins, columns.shape[1])
            if by_twins is not None:
                return change, by_twins.matrix + wide.by_known(), by_twins.freedom
        errors = self.errors + self.curvature * (wide.jacobian @ change)
        by_errors = replace(wide, errors=errors).coloured(clustered=clustered)
        return change, by_errors.matrix, by_errors.freedom

    def _independent(self, spans: Sequence[slice]) -> Array:
        """Return the covariance of the score of one record for independent errors, (k, k)."""
        rows = record_rows(spans)
        J, e, used = self.jacobian[rows], self.errors[rows], int(self.counted[rows].sum())
        return np.asarray(float(e @ e) / max(used - J.shape[1], 1) * (J.T @ J))

    def _sandwich(self, meat: Array) -> Array:
        """Return the covariance of the parameters, (k, k), from that of the score, (k, k)."""
        covariance = self.inverse @ meat @ self.inverse
        return np.asarray((covariance + covariance.T) / 2)


def sandwich_of(
    found: SearchResult,
    weighing: WeightedLoss,
    unknowns: Unknowns,
    predictions: OutputResiduals,
    records: Sequence[Record],
    chosen: BoolArray,
) -> Sandwich:
    """Return the parts of the sandwich covariance at the end of a search.

    Parameters
    ----------
    found : SearchResult
        End of the search.
    weighing : WeightedLoss
    unknowns : Unknowns
    predictions : OutputResiduals
    records : sequence of Record
    chosen : (P,) array of bool
        True for the parameters of the covariance.
    """
    weighed = weighing.weights * found.errors
    z = (weighed / weighing.tuning) ** 2
    _, first, second = weighing.counted(z)
    return Sandwich(
        jacobian=(weighing.weights[:, None] * found.jacobian)[:, chosen],
        errors=first * weighed,
        curvature=np.maximum(first + 2 * z * second, 0.0),
        known=unknowns.known_rows[:, chosen],
        counts=first * weighing.weights,
        spans=predictions.spans,
        periods=tuple(record.period for record in records),
        outputs=len(predictions.units),
    )
