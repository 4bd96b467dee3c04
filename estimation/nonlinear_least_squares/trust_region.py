"""Search for parameters within bounds: weighted nonlinear least squares by a trust-region method.

Active bounds are determined at the end of a trust-region search: a parameter that the residuals
drive to a bound is fixed there, and a new search continues with the other parameters. Residuals are
simulated minus recorded outputs; a prior of a parameter adds a residual, its prior error.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.choices import HUBER, SOFT_L1, SQUARES
from axisid.estimation.output_residuals import OutputResiduals, jacobian_at
from axisid.estimation.unknowns import Unknowns
from axisid.support.arrays import Array
from axisid.support.progress import Progress

# distance from a bound in standard errors, below which a parameter is fixed at the bound
_AT_BOUND = 0.05

MOST_STEPS = 60
# steps of a search including its restarts after a change of the active bounds
MOST_IN_ALL = 2 * MOST_STEPS
_TOLERANCE = 1e-8  # relative, of cost, parameters and gradient, at which a search ends
#: Length of a step in standard errors at which a search ends.
RESOLUTION = 0.01
_LOST = 1e3  # residuals of a loop that cannot be simulated, relative to those at the start
_ROUNDS = 5  # trust-region searches, after each of which the active bounds are determined again

#: Loss function rho: maps squared residuals divided by the squared scale of the loss, (n,), to the
#: loss and its first two derivatives, (3, n).
Loss = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class FitStep:
    """Parameters and residual of a step of the search.

    Attributes
    ----------
    physical : (P,) array
    error : float
        Root mean square of the residuals of the output, in its unit; of several outputs, the first.
    """

    physical: Array
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WeightedLoss:
    """Weights and loss function of the residuals.

    Attributes
    ----------
    weights : (n,) array
        Inverse standard deviation of the noise of each row; 0 for rows that are not used.
    loss : callable
        Loss function rho with its first two derivatives, see `Loss`.
    tuning : float
        Scale of the loss in standard deviations of the noise.
    shares : (n,) array
        Factor of the loss of each row, relative to that of a prior. The weights include the root of
        this factor.
    """

    weights: Array
    loss: Loss
    tuning: float
    shares: Array

    def counted(self, z: Array) -> Array:
        """Return the loss with its factor `shares`, and its first two derivatives, (3, n).

        `z`, (n,), are squared weighted residuals over the squared scale of the loss.
        """
        # The share scales the loss, not the residual for which the loss is evaluated.
        value, first, second = self.loss(z / self.shares)
        return np.array([self.shares * value, first, second / self.shares])


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchResult:
    """Result of a search.

    Attributes
    ----------
    physical : (P,) array
        Final parameters.
    errors : (n,) array
        Residuals at these parameters.
    jacobian : (n, P) array
        Derivatives of the residuals by the parameters; 0 for fixed ones.
    at_bound : (P,) array of int
        -1 at the lower bound, 1 at the upper bound, 0 elsewhere.
    steps : tuple of FitStep
        All steps of the search.
    cost : float
        Cost at the final parameters, see `cost_of`.
    converged : bool
        True if the last trust-region search converged and the active bounds did not change.
    step_left : float
        Length of the Gauss-Newton step from the final parameters, in standard errors, see `Search`;
        infinite if unknown.
    interrupted : bool
        True if Ctrl-C ended the search. The result then has the parameters of the lowest cost.
    """

    physical: Array
    errors: Array
    jacobian: Array
    at_bound: NDArray[np.int8]
    steps: tuple[FitStep, ...]
    cost: float
    converged: bool
    step_left: float = np.inf
    interrupted: bool = False


class Search:
    """Search for the parameters of least cost.

    Parameters
    ----------
    predictions : OutputResiduals
        Residuals as a function of the parameters.
    unknowns : Unknowns
        Bounds, prior values and fixed values of the parameters.
    scale : (P,) array
        Scales of the parameters.
    weighing : WeightedLoss
    progress : callable, optional
        As in `fit`.
    resolution : float
        Length r of the last step in standard errors. A Gauss-Newton step d reduces the cost F by
        ``d' H d / 2`` with ``H = J' J``, and the covariance of the parameters is ``s^2 inv(H)``
        with ``s^2 = 2 F / n``. So a step has the length r if the cost falls by ``r^2 s^2 / 2``,
        that is ``dF / F = r^2 / n`` [DennisSchnabel1996]_. A coarser search than the default fixes
        no parameter at a bound.
    """

    def __init__(
        self,
        predictions: OutputResiduals,
        unknowns: Unknowns,
        scale: Array,
        weighing: WeightedLoss,
        progress: Progress | None = None,
        *,
        resolution: float = RESOLUTION,
    ) -> None:
        counted = max(int(np.count_nonzero(weighing.weights)), 1)
        self._least_gain = max(_TOLERANCE, resolution**2 / counted)
        self._rounds = 1 if resolution > RESOLUTION else _ROUNDS
        self._predictions, self._unknowns, self._scale = predictions, unknowns, scale
        self._weighing, self._progress = weighing, progress
        self._steps: list[FitStep] = []
        # Largest absolute weighted residual or prior error at the start, 1 or more; 0 before the
        # first evaluation. `_residuals` needs it for loops that cannot be simulated.
        self._largest = 0.0
        self._at = np.empty(0)  # parameters at which residuals and Jacobian are known
        self._slopes: tuple[Array, Array]
        self._best: SearchResult | None = None

    def run(self, start: Array) -> SearchResult:
        """Search from parameters (P,) strictly inside their bounds.

        An interrupt (Ctrl-C) ends the search with the parameters of the lowest cost so far.

        Raises
        ------
        EstimationError
            The loop cannot be simulated at the start, or near the parameters of a step.
        KeyboardInterrupt
            The search was interrupted before its first step.
        """
        try:
            return self._searched(start)
        except KeyboardInterrupt:
            if self._best is None:
                raise
            return replace(self._best, steps=tuple(self._steps), interrupted=True)

    def _searched(self, start: Array) -> SearchResult:
        """Return the result of searches that are repeated until the active bounds do not change.

        After each search, parameters that the residuals drive to a bound are fixed there, and
        parameters that the residuals drive away from a bound are freed.
        """
        at, bound = start.copy(), np.zeros(len(start), dtype=np.int8)
        for remaining in reversed(range(self._rounds)):
            at, converged = self._trust_region(at, bound)
            active = self._active_bounds(at)
            settled = np.array_equal(active, bound)
            if settled or not remaining or len(self._steps) >= MOST_IN_ALL:
                break
            freed, u = (bound != 0) & (active == 0), self._unknowns
            at = np.select(
                [active < 0, active > 0, freed], [u.lower, u.upper, u.inside(at, self._scale)], at
            )
            bound = active
        errors, jacobian = self._slopes_at(at)
        return SearchResult(
            physical=at,
            errors=errors,
            jacobian=jacobian,
            at_bound=bound,
            steps=tuple(self._steps),
            cost=cost_of(at, errors, self._unknowns, self._weighing),
            converged=settled and converged,
            step_left=self._step_left(at),
        )

    def _trust_region(self, at: Array, bound: NDArray[np.int8]) -> tuple[Array, bool]:
        """Return the parameters (P,) at the end of one trust-region search, and if it converged.

        The search starts at parameters `at`, (P,), and is in units of the parameters' scales.
        Parameters with an active bound (`bound` is -1 or 1) are fixed.
        """
        u = self._unknowns
        chosen = u.free & (bound == 0)
        if not chosen.any():
            return at, True
        from scipy.optimize import least_squares

        scale, rows = self._scale[chosen], len(self._weighing.weights)
        bounds = u.lower[chosen] / scale, u.upper[chosen] / scale

        def whole(x: Array) -> Array:
            """Return all parameters, (P,), for scaled values of the searched parameters."""
            there = at.copy()
            there[chosen] = x * scale
            return np.where(u.free, np.clip(there, u.lower, u.upper), at)

        def loss(z: Any) -> Any:
            """Return the loss of the rows and of the prior errors (squares), with derivatives."""
            found = _squares(z)
            found[:, :rows] = self._weighing.counted(z[:rows])
            return found

        ended = least_squares(
            cast("Any", lambda x: self._residuals(whole(x))),
            np.clip(at[chosen] / scale, *bounds),
            cast("Any", lambda x: self._jacobian(whole(x))[:, chosen] * scale),
            bounds=bounds,
            method="trf",
            x_scale="jac",
            ftol=self._least_gain,
            xtol=_TOLERANCE,
            gtol=_TOLERANCE,
            loss=cast("Any", loss),
            f_scale=self._weighing.tuning,
            max_nfev=MOST_STEPS,
        )
        return whole(ended.x), bool(ended.status > 0)

    def _residuals(self, at: Array) -> Array:
        """Return weighted residuals, then prior errors, at parameters (P,), (n + j,).

        If the loop cannot be simulated, all are a large value, so that the step is rejected. At the
        start there is no such value yet, and the error of the simulation is raised.
        """
        # `_largest` is 0 at the first call: the residuals then come with their Jacobian, which is
        # needed at the start in any case. So do residuals at the parameters of the last step.
        if np.array_equal(self._at, at) or not self._largest:
            return weighed_rows(at, self._slopes_at(at)[0], self._unknowns, self._weighing)
        lanes = self._predictions(at[None, :])
        if lanes.failures:
            rows = len(self._weighing.weights) + int(self._unknowns.has_prior.sum())
            return np.full(rows, _LOST * self._largest)
        return weighed_rows(at, lanes.errors[:, 0], self._unknowns, self._weighing)

    def _jacobian(self, at: Array) -> Array:
        """Return the Jacobian of weighted residuals and prior errors, (n + j, P)."""
        jacobian = self._weighing.weights[:, None] * self._slopes_at(at)[1]
        return np.vstack([jacobian, self._unknowns.known_rows])

    def _slopes_at(self, at: Array) -> tuple[Array, Array]:
        """Return residuals (n,) and their Jacobian (n, P) at parameters (P,).

        Parameters other than those of the last call count as a step of the search: the step is
        recorded in `_steps` and reported as progress, and the parameters are stored as the best
        ones if they have the lowest cost. The first call also sets `_largest`, with which
        `_residuals` rejects a step to parameters that cannot be simulated.
        """
        if np.array_equal(self._at, at):
            return self._slopes
        # Choose the steps per sample, and the initial states of windows, before the differences of
        # the Jacobian: with the same settings, only the parameters change the simulated outputs.
        self._predictions.settle(at)
        u = self._unknowns
        self._slopes = jacobian_at(self._predictions, at, self._scale, u.lower, u.upper, u.free)
        self._at = at.copy()
        errors, _ = self._slopes
        rows = weighed_rows(at, errors, u, self._weighing)
        if not self._largest:  # at the start
            self._largest = max(float(np.abs(rows).max()), 1.0)
        self._keep_best(at)
        # The rows of several outputs alternate; the reported error is that of the first output.
        error = float(np.sqrt(np.mean(errors[:: len(self._predictions.units)] ** 2)))
        self._steps.append(FitStep(physical=at.copy(), error=error))
        if self._progress is not None:
            text = f"step {len(self._steps)}, error {error:.4g}"
            self._progress(len(self._steps) - 1, MOST_STEPS, text)
        return self._slopes

    def _keep_best(self, at: Array) -> None:
        """Store the last parameters as the best, unless earlier parameters have a lower cost."""
        errors, jacobian = self._slopes
        cost = cost_of(at, errors, self._unknowns, self._weighing)
        if self._best is None or cost <= self._best.cost:
            self._best = SearchResult(
                physical=at.copy(),
                errors=errors,
                jacobian=jacobian,
                at_bound=np.zeros(len(at), dtype=np.int8),
                steps=(),
                cost=cost,
                converged=False,
            )

    def _step_left(self, at: Array) -> float:
        """Return the length of the Gauss-Newton step from parameters (P,), in standard errors.

        ``sqrt(g' inv(H) g) / s`` with ``g = J' r`` and ``H = J' J`` of the weighted residuals r.
        """
        rows, jacobian = self._rows_as_counted(at)
        sizes = np.linalg.norm(jacobian, axis=0)
        shown = jacobian[:, sizes > 0] / sizes[sizes > 0]
        step = np.linalg.lstsq(shown, rows, rcond=None)[0]
        noise = float(np.linalg.norm(rows)) / max(int(np.count_nonzero(rows)), 1) ** 0.5
        return float(np.linalg.norm(shown @ step)) / noise if noise > 0 else 0.0

    def _rows_as_counted(self, at: Array) -> tuple[Array, Array]:
        """Return residuals (n + j,) and Jacobian (n + j, P) of the equivalent least squares.

        Weighted residuals and their Jacobian are multiplied by the root of the loss's derivative;
        the j prior errors and their Jacobian are not.
        """
        rows = weighed_rows(at, self._slopes_at(at)[0], self._unknowns, self._weighing)
        n, jacobian = len(self._weighing.weights), self._jacobian(at)
        slope = self._weighing.counted((rows[:n] / self._weighing.tuning) ** 2)[1]
        rows[:n] *= np.sqrt(slope)
        jacobian[:n] *= np.sqrt(slope)[:, None]
        return rows, jacobian

    def _active_bounds(self, at: Array) -> NDArray[np.int8]:
        """Return the active bounds at parameters `at`, (P,): -1 lower, 1 upper, 0 none.

        A bound is active if the parameter is closer to it than a twentieth of its standard error,
        and the cost falls towards it. The standard errors are scaled by the present residuals, as
        the weights are those of the start.
        """
        (errors, _), u = self._slopes_at(at), self._unknowns
        rows, jacobian = weighed_rows(at, errors, u, self._weighing), self._jacobian(at)
        n, c = len(self._weighing.weights), self._weighing.tuning
        counts = self._weighing.counted((rows[:n] / c) ** 2)[1]
        noise = np.sqrt(np.sum(counts * rows[:n] ** 2) / max(np.count_nonzero(rows[:n]), 1))
        rows[:n] *= counts
        downhill = -(jacobian.T @ rows)  # negative gradient of the cost
        reach = _AT_BOUND * noise / np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
        reach = np.maximum(reach, _TOLERANCE * self._scale)
        low = u.free & (downhill < 0) & (at - u.lower <= reach)
        high = u.free & (downhill > 0) & (u.upper - at <= reach)
        return np.where(low, -1, np.where(high, 1, 0)).astype(np.int8)


def weighed_rows(at: Array, errors: Array, unknowns: Unknowns, weighing: WeightedLoss) -> Array:
    """Return the weighted residuals (n,), then the prior errors ``(theta - prior)/sd`` (j,).

    `at` are the parameters, (P,), and `errors` the residuals, (n,).
    """
    return np.concatenate([weighing.weights * errors, unknowns.prior_errors(at)])


def cost_of(at: Array, errors: Array, unknowns: Unknowns, weighing: WeightedLoss) -> float:
    """Return the cost ``sum c^2 rho((w e / c)^2) / 2 + ||prior errors||^2 / 2`` of parameters (P,).

    Parameters
    ----------
    at : (P,) array
        Parameters.
    errors : (n,) array
        Residuals e.
    unknowns : Unknowns
    weighing : WeightedLoss
        Weights w, loss rho and scale c.
    """
    prior_errors, c = unknowns.prior_errors(at), weighing.tuning
    # The loss, and its first and second derivative, which the cost does not need.
    rho, _, _ = weighing.counted((weighing.weights * errors / c) ** 2)
    losses = c * c * rho
    return 0.5 * float(losses.sum() + prior_errors @ prior_errors)


def best_of(found: Sequence[SearchResult]) -> SearchResult:
    """Return the result with the lowest cost; the first of results with equal costs."""
    least = min(each.cost for each in found) * (1 + 100 * _TOLERANCE)
    return next(each for each in found if each.cost <= least)


def _squares(z: Array) -> Array:
    """Return the loss z and its first two derivatives."""
    return np.array([z, np.ones_like(z), np.zeros_like(z)])


def _soft_l1(z: Array) -> Array:
    """Return the loss ``2 (sqrt(1 + z) - 1)`` and its first two derivatives."""
    root = np.sqrt(1 + z)
    return np.array([2 * (root - 1), 1 / root, -0.5 / root**3])


def _huber(z: Array) -> Array:
    """Return the loss z up to 1, ``2 sqrt(z) - 1`` above, and its first two derivatives."""
    root = np.sqrt(np.maximum(z, 1.0))
    return np.where(z > 1, [2 * root - 1, 1 / root, -0.5 / root**3], _squares(z))


#: Loss functions by name.
LOSSES: Mapping[str, Loss] = MappingProxyType({SQUARES: _squares, SOFT_L1: _soft_l1, HUBER: _huber})
