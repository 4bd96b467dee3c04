"""Uncertainty of functions of an estimate: error of the delta method, and random draws.

The estimate ``theta`` of a regression maps to physical parameters, and a function maps these to a
number. To first order the variance is ``g' C g`` with the gradient g of the whole map; where the
map is curved within the uncertainty, draws from the distribution of theta are better.
"""

from collections.abc import Callable

import numpy as np
from msgspec import Struct
from scipy.special import chdtri

from axisid.support.arrays import Array, MaybeNan
from axisid.support.errors import UsageError

from .inverse_and_direct import Form

_STEP = 0.01  # standard errors, of the differences of a Jacobian
_MOST_DRAWS = 1_000_000


class Drawn(Struct, frozen=True, kw_only=True, rename={"interval": "interval_95"}):
    """Quantiles of one parameter over random draws, with the exact map.

    Attributes
    ----------
    median : float
        Median over the draws.
    interval : (float, float)
        The 2.5 % and the 97.5 % quantile.
    draws : int
        Number of draws in the quantiles.
    lost : int
        Number of draws with an inertia that is not positive, or without a finite value; the
        quantiles exclude them.
    seed : int
        Seed of numpy.random.default_rng, which repeats the draws.
    """

    median: MaybeNan
    interval: tuple[MaybeNan, MaybeNan]
    draws: int
    lost: int
    seed: int


class DrawSummary(Drawn, frozen=True, kw_only=True):
    """Value and quantiles of a function of the parameters over draws from their distribution.

    Attributes
    ----------
    value : float
        Value at the estimate.
    unit : str

    Notes
    -----
    The other attributes are those of `Drawn`.
    """

    value: float
    unit: str

    def __str__(self) -> str:
        """Return the value, the median and the 95 % interval with the unit, on one line."""
        low, high = self.interval
        lost = f", {self.lost} excluded" if self.lost else ""
        return (
            f"{self.value:.6g} {self.unit}, median {self.median:.6g}, 95 %: {low:.6g} to "
            f"{high:.6g} {self.unit} ({self.draws} draws{lost})"
        )


def curvature(slopes: Array, bends: Array, gradient: Array, hessian: Array) -> float:
    """Return the ratio of the second-order to the first-order part of a function's standard error.

    ``sqrt(tr(H C H C)/2) / sqrt(g' C g)``: the variance of a quadratic function of normal errors is
    ``g' C g + tr(H C H C)/2``, of which the delta method has the first term. Third derivatives may
    contribute as much as the second term.

    Parameters
    ----------
    slopes : (p, k) array
        ``J L`` with ``L L' = C``: rows are scaled gradients, whose squared norms are variances.
    bends : (p, k, k) array
        ``L' H L`` for the Hessian of each physical parameter.
    gradient, hessian : (p,) and (p, p) arrays
        Derivatives of the function by the physical parameters.
    """
    first = float(np.linalg.norm(gradient @ slopes))
    curved = slopes.T @ hessian @ slopes + np.tensordot(gradient, bends, axes=1)
    second = float(np.linalg.norm(curved)) / np.sqrt(2)
    if second == 0:
        return 0.0
    return float("inf") if first == 0 else second / first


def scaled_gradients_and_hessians(
    form: Form, theta: Array, covariance: Array
) -> tuple[Array, Array]:
    """Return gradients and Hessians of a form's map, scaled by standard errors, for `curvature`.

    The Hessians are differences of the exact Jacobian along the columns of L with ``L L' = C``.

    Parameters
    ----------
    form : Form
    theta : (k,) array
    covariance : (k, k) array
        Covariance of theta.

    Returns
    -------
    (p, k) array
        ``J L``.
    (p, k, k) array
        ``L' H L`` for each physical parameter.
    """
    directions = covariance_root(covariance)
    jacobian = form.physical(theta)[1]
    bends = np.empty((len(jacobian), len(theta), len(theta)))
    for j, direction in enumerate(directions.T):
        ahead, behind = (form.physical(theta + s * direction)[1] for s in (_STEP, -_STEP))
        bends[:, :, j] = (ahead - behind) @ directions / (2 * _STEP)
    return jacobian @ directions, bends


def covariance_root(covariance: Array) -> Array:
    """Return L, (k, k), with ``L L' = C`` for a covariance C of any rank.

    All elements are NaN for a covariance that is not finite.
    """
    if not np.all(np.isfinite(covariance)):
        return np.full_like(covariance, np.nan)
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0, scale, 1.0)
    sizes, vectors = np.linalg.eigh(covariance / np.outer(safe, safe))
    return np.asarray(safe[:, None] * vectors * np.sqrt(np.maximum(sizes, 0.0)), dtype=float)


def draw_parameters(
    form: Form, theta: Array, covariance: Array, freedom: Array, draws: int, seed: int
) -> tuple[Array, int]:
    """Draw physical parameters from the multivariate Student's t distribution of an estimate.

    The parameters of the regression are drawn, and then mapped exactly to the physical parameters.

    Parameters
    ----------
    form : Form
    theta, covariance : (k,) and (k, k) arrays
        Parameters of the regression and their covariance.
    freedom : (k,) array
        Degrees of freedom of each parameter, as for the intervals.
    draws, seed : int
        Number of draws, and seed of the random numbers.

    Returns
    -------
    (d, p) array
        Draws with finite values and a positive inertia.
    int
        Number of draws without finite values or without a positive inertia.

    Raises
    ------
    UsageError
        The number of draws is no whole number from 2 to 1 000 000.
    """
    if not (isinstance(draws, (int, np.integer)) and 2 <= draws <= _MOST_DRAWS):
        raise UsageError(
            f"the number of draws is {draws!r}. Give a whole number from 2 to {_MOST_DRAWS}.",
            code="result",
        )
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(draws, len(theta))) @ covariance_root(covariance).T
    # Student's t: normal numbers by the root of chi-squared over its degrees of freedom. All
    # parameters have the same quantile, so that equal degrees of freedom give equal factors.
    factors = np.sqrt(freedom / chdtri(freedom, rng.random(size=(draws, 1))))
    drawn = theta + normal * factors
    with np.errstate(all="ignore"):
        physical = np.array([form.physical(each)[0] for each in drawn])
    finite = np.all(np.isfinite(physical), axis=1)
    kept = physical[finite]
    if len(kept):
        kept = kept[form.have_inertia(kept)]
    return kept, int(draws - len(kept))


def summary_of_draws(
    function: Callable[[list[float]], float],
    at: Array,
    unit: str,
    physical: Array,
    lost: int,
    seed: int,
) -> DrawSummary:
    """Return value and quantiles of a function over drawn physical parameters, (d, p).

    Parameters
    ----------
    function : callable
        Function of the parameters as a list; it returns NaN where it has no value.
    at : (p,) array
        Estimate.
    unit : str
        Unit of the function.
    physical : (d, p) array
        Draws, as from `draw_parameters`.
    lost : int
        Number of excluded draws, as from `draw_parameters`.
    seed : int
        Seed of the draws.
    """
    values = np.array([function(each) for each in physical.tolist()])
    finite = values[np.isfinite(values)]
    low = median = high = np.nan
    if len(finite):
        low, median, high = np.quantile(finite, [0.025, 0.5, 0.975])
    return DrawSummary(
        value=function(at.tolist()),
        unit=unit,
        median=float(median),
        interval=(float(low), float(high)),
        draws=len(finite),
        lost=lost + len(values) - len(finite),
        seed=seed,
    )
