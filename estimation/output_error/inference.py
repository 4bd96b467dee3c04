"""Inference from the end of a fit's searches: covariances, and the bias by noise."""

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.choices import SQUARES
from axisid.estimation.estimates import (
    NamedValues,
    SamplingDistribution,
    Value,
    degrees_of_freedom_of,
)
from axisid.estimation.estimation_problem import ParameterAtBound
from axisid.estimation.noise_models import pair_freedom
from axisid.estimation.output_residuals import ClosedLoopResiduals, jacobian_at
from axisid.estimation.regression import CovarianceEstimate, widened
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.estimation.unknowns import START, Unknowns, bounded_quadratic_minimum, least_sizes
from axisid.estimation.verdict_checks import NotUsed, unless_faulty, value_or
from axisid.support.arrays import Array, BoolArray, IntArray
from axisid.support.errors import EstimationError
from axisid.support.missing import Missing

from .covariance import Sandwich, unseen_directions
from .fit_search import FitSearch
from .parametric_bootstrap import RecordLoops, calibrated_covariance, outputs_by_noise

# standard deviations: beyond this distance from the mean, the tail of a normal distribution is
# exponential up to rounding
_EXPONENTIAL = 1e4


@dataclass(frozen=True, kw_only=True, eq=False)
class FittedParameters:
    """Parameters of a fit with their covariances, also of a fit that was read from a file.

    Attributes
    ----------
    physical : (P,) array
        Parameters minus their bias by noise in the loop.
    chosen : str
        Name of the reported covariance.
    covariances : mapping of str to (P, P) array
        Covariances by name; 0 for parameters at a bound, infinite variances of parameters that the
        outputs do not show.
    parameters : NamedValues
        Values by name, with unit, standard errors and 95 % interval.
    """

    physical: Array = field(repr=False)
    chosen: str = field(repr=False)
    covariances: Mapping[str, Array] = field(repr=False)
    parameters: NamedValues = field(repr=False)

    def __getitem__(self, name: str) -> Value:
        """Return a parameter with its unit, standard errors and interval, by name."""
        return self.parameters[name]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(self.parameters)

    @property
    def covariance(self) -> Array:
        """The reported covariance of the parameters, (P, P)."""
        return self.covariances[self.chosen]

    def distribution(self, at_bound: Container[str]) -> SamplingDistribution:
        """Return the sampling distribution of the parameters; `at_bound` names those at a bound."""
        freedom = np.array([degrees_of_freedom_of(value) for value in self.parameters.values()])
        return SamplingDistribution(
            quantities=tuple(Quantity(name=n, unit=v.unit) for n, v in self.parameters.items()),
            theta=self.physical,
            covariances=self.covariances,
            freedom={self.chosen: freedom},
            chosen=self.chosen,
            at_bound=at_bound,
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FitInference(FittedParameters):
    """Inference on the parameters from the end of a search.

    Attributes
    ----------
    sides : (P,) array of int
        -1 for parameters at their lower bound, 1 at the upper bound, 0 for others.
    variances : (P,) array
        Variances by the chosen covariance without bounds; infinite for fixed parameters.
    held : tuple of ParameterAtBound
        Parameters at their bounds, with their values without these bounds.
    not_shown : (k, P) array, (k, P) array of bool
        Directions that neither outputs nor prior values show, see `unseen_directions`.
    influence : (P, n) array
        Influence of the errors of the outputs on the parameters, see `Sandwich.influence`.
    judged_sandwich : Sandwich
        Parts of the covariance of free parameters that are not at a bound; its errors are corrected
        for the mean effect of noise.
    loops : tuple of RecordLoops or Missing
        Simulated loops of each record at the parameters, with the record's noise.
    moved : (P,) array, Missing or None
        Bias of the parameters by noise in the loop, or the reason why it is unknown; None if it was
        not requested.
    """

    sides: IntArray = field(repr=False)
    variances: Array = field(repr=False)
    held: tuple[ParameterAtBound, ...] = field(repr=False)
    not_shown: tuple[Array, BoolArray] = field(repr=False)
    influence: Array = field(repr=False)
    judged_sandwich: Sandwich = field(repr=False, compare=False)
    loops: tuple[RecordLoops | Missing, ...] = field(repr=False, compare=False)
    moved: Array | Missing | None = field(repr=False)


def inferred(of: FitSearch) -> FitInference:
    """Return estimates minus bias, covariances and intervals at the best end of a fit's searches.

    Simulated replicas give the bias and the scatter by noise. The bias is subtracted, within the
    bounds. Covariances are computed for all free parameters without bounds. Parameters at bounds
    get one-sided intervals.

    Standard errors are those of all free parameters without bounds: a parameter at a bound is not
    known, and its uncertainty is part of that of the others. A bounded estimate is closer to any
    value within the bounds than the unbounded one, so that intervals about it with the standard
    errors of the unbounded one are wide enough.
    """
    end, weights, free = of.best, of.weighing.weights, of.unknowns.free
    # Simulated replicas: changes of the outputs by noise, and their mean.
    loops = tuple(
        unless_faulty(partial(RecordLoops.at, of.form, end.physical, place, record))
        for place, record in enumerate(of.records)
    )
    whole_sandwich, noise = of.sandwich(free), _noise(of, loops)
    twins = None if isinstance(noise, Missing) else noise
    common = None if twins is None else twins.mean(axis=1)
    # Parameters minus their bias; errors minus the mean effect of noise.
    physical, sides = _corrected(of, whole_sandwich, common)
    inner = free & (sides == 0)
    judged, influence = of.sandwich(inner), np.zeros((len(free), len(weights)))
    if inner.any():
        influence[inner] = judged.influence(weights)
    if common is not None:
        # The effect of squared noise is the same at every reversal, and adds no scatter.
        net = common - end.jacobian @ (influence @ common)
        judged = replace(judged, errors=judged.errors + weights * net)
    # Covariances of all free parameters; that over replicas is reported if there is one.
    scattered = twins if of.horizon is None else None
    coloured, found = _covariances(of, whole_sandwich, twins, judged.errors)
    dof, chosen = coloured.freedom, "coloured"
    if scattered is not None:
        dof, chosen = np.full(len(dof), pair_freedom(scattered.shape[1])), "bootstrap"
        judged = replace(judged, twins=judged.counts[:, None] * scattered)
    variances = np.full(len(free), np.inf)
    variances[free] = np.diag(found[chosen])
    # Infinite variances of parameters that are not shown, 0 of those at bounds.
    rows = np.vstack([weights[:, None] * end.jacobian, of.unknowns.known_rows])
    not_shown = unseen_directions(rows, of.scale, free)
    covariances = {}
    for name, matrix in found.items():
        whole, unseen = np.zeros((len(free), len(free))), np.flatnonzero(not_shown[1].any(axis=0))
        whole[np.ix_(free, free)] = matrix
        whole[unseen, unseen] = np.inf
        covariances[name] = np.where(inner[:, None] & inner, whole, 0.0)
    held = _parameters_at_bounds(of, physical, sides, common, judged.errors, variances)
    return FitInference(
        physical=physical,
        sides=sides,
        chosen=chosen,
        covariances=covariances,
        variances=variances,
        parameters=_parameters(of.unknowns, physical, held, covariances, chosen, dof),
        held=held,
        not_shown=not_shown,
        influence=influence,
        judged_sandwich=judged,
        loops=loops,
        moved=noise if twins is None else end.physical - physical,
    )


def _noise(of: FitSearch, loops: Sequence[RecordLoops | Missing]) -> Array | Missing | None:
    """Return the changes of the outputs by noise at the estimate, (n, R), of R replicas.

    None if no replicas were requested; Missing if the noise is unknown; NotUsed if the loss is
    robust or no noise reaches the output.

    Windows of an open loop have measurement noise only: disturbance forces change their errors
    linearly, which is no bias, and the scatter of their parameters is seen from window to window.
    """
    if not of.bootstrap:
        return None
    if of.loss != SQUARES:
        return NotUsed("the loss function is robust, and outliers are not noise of the loop")
    noise = unless_faulty(
        partial(
            outputs_by_noise,
            loops,
            of.best.physical,
            of.predictions,
            of.bootstrap,
            disturbed=of.horizon is None,
            paired=True,
        )
    )
    if isinstance(noise, Missing) or noise.any():
        return noise
    return NotUsed("no measured noise reaches the fitted output")


def _corrected(of: FitSearch, sandwich: Sandwich, common: Array | None) -> tuple[Array, IntArray]:
    """Return the parameters minus their bias by noise, and the active bounds, (P,) each.

    An active bound is -1 for a parameter at its lower bound, 1 at its upper bound, and 0 for a
    parameter not at a bound.

    The bias is one Gauss-Newton step by the mean change of the errors. If the corrected parameters
    leave their bounds, or a parameter is at its bound, the step is bounded least squares: the
    correction may move a parameter to its bound, or away from its bound, and the other parameters
    are corrected together with it.

    Parameters
    ----------
    of : FitSearch
        The finished searches.
    sandwich : Sandwich
        Parts of the covariance of all free parameters.
    common : (n,) array or None
        Mean change of the errors by noise.
    """
    at, side, u = of.best.physical, of.best.at_bound, of.unknowns
    if common is None:
        return at, side
    by_noise = sandwich.jacobian.T @ (sandwich.curvature * of.weighing.weights * common)
    # At the end of the search the gradient is 0, except for parameters at a bound.
    at_bounds = sandwich.jacobian.T @ sandwich.errors + sandwich.known.T @ u.prior_errors(at)
    negative_gradient = -by_noise - np.where(side[u.free] != 0, at_bounds, 0.0)
    physical = at.copy()
    # Without directions that are not shown, by which bounded least squares would divide.
    physical[u.free] += sandwich.inverse @ negative_gradient
    if not side.any() and np.all(((u.lower < physical) & (physical < u.upper))[u.free]):
        return physical, side
    rows = np.vstack([np.sqrt(sandwich.curvature)[:, None] * sandwich.jacobian, sandwich.known])
    physical, side = at.copy(), np.zeros_like(side)
    lower, upper, start = (each[u.free] for each in (u.lower, u.upper, at))
    physical[u.free], side[u.free] = bounded_quadratic_minimum(
        lower, upper, start, rows, negative_gradient
    )
    return physical, side


def _covariances(
    of: FitSearch,
    sandwich: Sandwich,
    twins: Array | None,
    errors: Array,
) -> tuple[CovarianceEstimate, dict[str, Array]]:
    """Return the covariance for autocorrelated errors, and all covariances by name, (k, k) each.

    The names are ``coloured``, ``iid`` and, with replicas of closed loops, ``bootstrap``. The
    covariances by name include the errors of known values.

    Parameters
    ----------
    of : FitSearch
        The finished searches.
    sandwich : Sandwich
        Parts of the covariance of all free parameters.
    twins : (n, R) array or None
        Changes of the outputs by noise, of simulated replicas.
    errors : (n,) array
        Weighted errors, minus the mean effect of noise.
    """
    weights, influence = of.weighing.weights, sandwich.influence(of.weighing.weights)
    # Autocorrelated errors, and without replicas the noise of the initial states.
    coloured = sandwich.coloured(clustered=of.horizon is not None)
    if twins is None and of.horizon is None:
        starts, k = value_or(np.zeros((0, 0)), partial(_slopes_by_start, of)), len(influence)
        if starts.any():
            whole = sandwich.beside(weights[:, None] * starts).coloured()
            coloured = replace(coloured, matrix=whole.matrix[:k, :k])
    covariances = {"coloured": coloured.matrix, "iid": sandwich.independent()}
    if of.horizon is None and twins is not None:
        centred = twins - twins.mean(axis=1, keepdims=True)
        estimates = -influence @ centred
        residuals = weights[:, None] * centred + sandwich.jacobian @ estimates
        by_twins = calibrated_covariance(sandwich, errors, estimates, residuals)
        covariances["bootstrap"] = by_twins + sandwich.by_known()
    elif of.horizon is not None:
        # The scatter over a few windows is too small, as a fit makes the sum of their scores 0.
        matrix = widened(coloured.matrix, np.diag(covariances["iid"]))
        coloured, covariances["coloured"] = replace(coloured, matrix=matrix), matrix
        if twins is not None:
            # The bias is the common part of a pair of replicas with opposite noise; its mean over
            # the pairs has an uncertainty.
            pairs = twins.shape[1] // 2
            means = (
                (influence @ twins[:, : 2 * pairs]).reshape(len(influence), pairs, 2).mean(axis=2)
            )
            covariances["coloured"] = matrix + np.atleast_2d(np.cov(means)) / pairs
    # Errors of known values: changes of the outputs by a standard error of each known value.
    changes = [np.zeros((len(weights), 0))]
    for form, predictions in of.predictions_with_changed_known:
        at = np.array([of.ended.get(q.name, 0.0) for q in form.physical_quantities])
        predictions.settle(at)
        lanes = predictions(at[None, :])
        if lanes.failures:
            raise EstimationError(lanes.failures[0], code="simulation")
        changes.append(lanes.errors - of.best.errors[:, None])
    by_known_values = influence @ np.hstack(changes)
    return coloured, {
        name: matrix + by_known_values @ by_known_values.T for name, matrix in covariances.items()
    }


def _slopes_by_start(of: FitSearch) -> Array:
    """Return the derivatives of the errors by the initial states of stretches in motion, (n, j).

    The initial states are known from the record except for its noise. Without columns, (n, 0), if
    no stretch begins in motion, or if the initial states are parameters of the fit.
    """
    in_motion = [bool(each.inputs.start.velocity) for each in of.predictions.stretches]
    if of.of_start.any() or not any(in_motion):
        return np.zeros((len(of.best.errors), 0))
    form = replace(of.form, time=()).with_starts(of.records, [START])
    predictions = ClosedLoopResiduals(form, form.axes, of.records, of.outputs)
    first = len(of.best.physical) - len(of.form.time)
    at = np.append(of.best.physical[:first], form.start[first:])
    no_end = np.full(len(at), np.inf)
    searched = np.append(np.zeros(first, dtype=bool), np.repeat(in_motion, 2))
    predictions.settle(at)
    _, slopes = jacobian_at(predictions, at, least_sizes(form), -no_end, no_end, searched)
    return slopes[:, searched]


def _parameters_at_bounds(
    of: FitSearch,
    physical: Array,
    sides: IntArray,
    common: Array | None,
    errors: Array,
    variances: Array,
) -> tuple[ParameterAtBound, ...]:
    """Return parameters at their bounds, with their values without these bounds.

    The interval of a parameter is that of a normal distribution about the estimate without its
    bound, truncated at the bound. The true values of other parameters at bounds may be away from
    their bounds, so that the standard error is that without any bound. The centre is as many
    standard errors beyond the bound as with the other parameters at their bounds.

    Parameters
    ----------
    of : FitSearch
        The finished searches.
    physical, sides : (P,) array
        Parameters minus their bias, and active bounds, as from `_corrected`.
    common : (n,) array or None
        Mean change of the errors by noise.
    errors : (n,) array
        Weighted errors, minus the mean effect of noise.
    variances : (P,) array
        Variances without bounds.
    """
    u, weights, at_bounds = of.unknowns, of.weighing.weights, []
    for j in map(int, np.flatnonzero(sides)):
        # The standard error of this parameter without its bound, with the others at their bounds.
        free = u.free & (sides == 0)
        free[j] = True
        sandwich, place = of.sandwich(free), int(np.count_nonzero(free[:j]))
        deviation = math.sqrt(replace(sandwich, errors=errors).coloured().matrix[place, place])
        # One Gauss-Newton step from the bound gives the estimate without it.
        residuals = sandwich.errors
        if common is not None:
            change = of.best.jacobian @ (physical - of.best.physical)
            residuals = residuals + sandwich.curvature * weights * (common + change)
        gradient = sandwich.jacobian.T @ residuals + sandwich.known.T @ u.prior_errors(physical)
        at, side = float(physical[j]), int(sides[j])
        centre = at + float((sandwich.inverse @ -gradient)[place])
        # The interval has the standard error without any bound; its centre has the same distance
        # from the bound in standard errors.
        wide = max(math.sqrt(variances[j]), deviation)
        beyond = (centre - at) / deviation if deviation > 0 else 0.0
        at_bounds.append(
            ParameterAtBound(
                name=u.names[j],
                unit=u.quantities[j].unit,
                bound=at,
                is_lower=side < 0,
                free=centre,
                deviation=deviation,
                reach=reach_of_cut_normal(at, at + beyond * wide, wide, side),
            )
        )
    return tuple(at_bounds)


def reach_of_cut_normal(bound: float, centre: float, deviation: float, side: int) -> float:
    """Return the end of the one-sided 95 % interval of a normal distribution truncated at a bound.

    The interval begins at the bound. Without a positive standard deviation its end is the bound.

    Parameters
    ----------
    bound, centre, deviation : float
        The bound, and mean and standard deviation of the distribution before truncation.
    side : {-1, 1}
        -1 for a lower bound, 1 for an upper bound.
    """
    if not deviation > 0:
        return bound
    # Distance of the centre from the bound in standard deviations, positive within the bound.
    inwards = side * (bound - centre) / deviation
    outside = math.log(1 - INTERVAL_LEVEL.value)
    if inwards < -_EXPONENTIAL:
        tail = -outside / inwards
    else:
        tail = ndtri_exp(outside + log_ndtr(inwards)) - inwards
    return bound + side * deviation * float(tail)


def _parameters(
    unknowns: Unknowns,
    physical: Array,
    held: Sequence[ParameterAtBound],
    covariances: Mapping[str, Array],
    chosen: str,
    dof: Array,
) -> NamedValues:
    """Return the parameters with unit, standard errors and interval, by name.

    Parameters
    ----------
    unknowns : Unknowns
    physical : (P,) array
    held : sequence of ParameterAtBound
        Parameters at bounds, with their one-sided intervals.
    covariances : mapping of str to (P, P) array
        Covariances by name.
    chosen : str
        Name of the covariance of the intervals.
    dof : (k,) array
        Degrees of freedom of the free parameters.
    """
    freedom = np.full(len(physical), np.inf)
    freedom[unknowns.free] = dof
    # The variance of a hardly shown parameter may be negative by rounding.
    shown = {n: np.where(np.diag(~(np.diag(c) >= 0)), np.inf, c) for n, c in covariances.items()}
    values = SamplingDistribution(
        quantities=unknowns.quantities,
        theta=physical,
        covariances=shown,
        freedom={chosen: freedom},
        chosen=chosen,
    ).values
    at_bound = {e.name: (min(e.bound, e.reach), max(e.bound, e.reach)) for e in held}
    return NamedValues(
        {n: replace(v, interval=at_bound.get(n, v.interval)) for n, v in values.items()}
    )
