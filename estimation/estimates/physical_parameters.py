"""Physical parameters from base parameters and from values known independently.

Classical minimum distance: with ``z = (beta_hat, fixed values)`` and its covariance V, the
parameters minimise ``(z - h)' V^-1 (z - h)`` with ``h(theta) = (beta(theta), theta_fixed)``. An
exactly fixed value is not an unknown. If z has more members than there are unknowns, the minimum
tests whether the fixed values contradict the record: Hotelling's T squared, with the degrees of
freedom of V. For this test beta_hat must be unbiased and V its whole uncertainty: the bias is
subtracted, and V includes the uncertainty of the drive gain.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.regression import Form, delta_method, hotelling_p_value
from axisid.estimation.unknowns import JointForm
from axisid.modeling.derivation import BaseModel, describe_undetermined, undetermined_names
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array, BoolArray, Exact
from axisid.support.checks import is_among
from axisid.support.errors import UsageError
from axisid.support.wording import quoted

from .estimated_values import NamedValues, SamplingDistribution

_SAME_DISTANCE = 1e-6  # difference of equal squared distances, relative to 1 plus the smaller one
_SAME_PARAMETER = 1e-3  # difference of equal values, relative to size and standard error

_MOST_STEPS = 200
_STILL = 1e-10  # relative change of parameters, distance and derivative at convergence
_SIZES = (1.0, 0.1, 10.0, 0.01, 100.0)  # start values in place of a nominal value of 0
_STRETCHES = (1.0, 3.0, 1 / 3)  # factors of the start values
#: Least relative standard errors, from the start to the end of a descent: an exactly known product
#: makes a narrow, curved valley of the distance, which is found through wider valleys.
_SHARPEST = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
_MOST_SIGNS = 8  # parameters of which all combinations of signs are tried


def mapped(base: BaseModel, theta: Array) -> tuple[Array, Array]:
    """Return the base parameters, (b,), of declared parameters `theta`, (p,), and their Jacobian.

    The Jacobian, (b, p), has the derivatives of the base parameters by the declared ones. Each base
    parameter is a weighted sum of monomials (products of powers) of the declared parameters:
    ``beta = weights . monomials(theta)``. Powers and weights are those of `BaseModel`.
    """
    powers, weights = (np.array(each, dtype=float) for each in (base.exponents, base.weights))
    slopes = np.empty_like(powers)
    for j in range(len(theta)):
        lower = powers.copy()
        lower[:, j] = np.maximum(lower[:, j] - 1, 0)
        slopes[:, j] = powers[:, j] * np.prod(theta**lower, axis=1)
    return weights @ np.prod(theta**powers, axis=1), weights @ slopes


#: End of a descent: declared parameters, (p,), and their squared distance, in standard errors.
Minimum = tuple[Array, float]


class Distance:
    """Squared distance of declared parameters from an estimate, which `minimum` minimises.

    The declared parameters imply base parameters, and some of them have fixed values. The distance
    compares the implied base parameters with the estimated ones, and the parameters with their
    fixed values, in standard errors.

    Parameters
    ----------
    base : BaseModel
        Base parameters as functions of the declared parameters.
    beta : (b,) array
        Estimated base parameters.
    covariance : (b, b) array
        Covariance of the estimated base parameters.

    Attributes
    ----------
    free : list of int
        Indices of the unknowns among the p declared parameters: those not fixed exactly.
    target : (z,) array
        Estimated base parameters, then the values fixed with a standard deviation.
    """

    def __init__(self, base: BaseModel, beta: Array, covariance: Array) -> None:
        """Set the unknowns, their start and bounds, the target, and the whitenings of its error.

        The whitenings go from wide to sharp. Each bounds the relative standard errors from below
        (`_SHARPEST`). A descent goes through all of them, as an exactly known product makes a
        narrow valley. The last, the sharpest, defines the distance.
        """
        self.base, declared = base, base.declared.parameters
        self._exponents = np.array(base.exponents, dtype=float)
        self._known = np.array([p.known is not None for p in declared])
        spread = np.array([p.known_sd for p in declared])
        self._uncertain = np.flatnonzero(spread > 0)
        self.free = [*np.flatnonzero(~self._known | (spread > 0))]
        self._start = np.array([p.nominal if p.known is None else p.known for p in declared])
        self._low, self._high = np.transpose([(p.lower, p.upper) for p in declared])
        self._spread = spread[self._uncertain]
        self.target = np.concatenate([beta, self._start[self._uncertain]])
        whole = self.covariance(covariance)
        self._wider = [_whitening(whole, self.target, least) for least in _SHARPEST]
        self._whiten = self._wider[-1]

    def covariance(self, of_beta: Array) -> Array:
        """Return the covariance of `target`, (z, z).

        It is block diagonal: the covariance of the base parameters, `of_beta`, (b, b), and the
        variances of the values that are fixed with a standard deviation.
        """
        b, f = len(of_beta), len(self._spread)
        whole = np.zeros((b + f, b + f))
        whole[:b, :b] = of_beta
        whole[b:, b:] = np.diag(self._spread**2)
        return whole

    def minimum(self) -> Minimum:
        """Return the declared parameters with the smallest distance, and that distance.

        Several parameters may have the same distance. The first of them inside the bounds is then
        returned; the first of all if none is inside.
        """
        minima = self._best_minima()
        theta, cost = minima[0]
        candidates = [*minima, *((other, cost) for other in self._mirrored(theta))]
        for candidate in candidates:
            if self._inside(candidate[0]):
                return candidate
        return minima[0]

    def others(self, theta: Array) -> list[Array]:
        """Return other solutions inside the bounds with the same distance as `theta`, each once.

        These are parameters of other signs, and ends of other descents where the base parameters
        determine all declared parameters.
        """
        candidates = [*self._mirrored(theta)]
        if not self.base.undetermined:
            candidates += [other for other, _ in self._best_minima()]
        solutions = [theta]
        for other in filter(self._inside, candidates):
            if not any(self.are_same(solution, other).all() for solution in solutions):
                solutions.append(other)
        return solutions[1:]

    def _best_minima(self) -> list[Minimum]:
        """Return the ends of all descents whose distance equals the smallest one, to rounding."""
        minima = [self._descend(start) for start in self._starts()]
        least = min(cost for _, cost in minima)
        near = [each for each in minima if each[1] <= least + _SAME_DISTANCE * (1 + least)]
        return near or minima

    def are_same(self, theta: Array, other: Array) -> BoolArray:
        """Return True for each parameter, (p,), that is equal in two solutions.

        The tolerance is 0.1 % of the sum of the parameter's size and its standard error.
        """
        # A standard error while the other unknowns are fixed: the inverse of the slopes' norm.
        slopes = np.linalg.norm(self._residuals(theta)[1], axis=0)
        deviations = np.zeros(len(theta))
        deviations[self.free] = np.divide(1.0, slopes, out=np.zeros(len(slopes)), where=slopes > 0)
        size = np.maximum(np.abs(theta), np.abs(other)) + deviations
        return np.asarray(np.abs(other - theta) <= _SAME_PARAMETER * size)

    def influence(self, theta: Array, rank: int) -> Array | None:
        """Return the derivative of the nearest declared parameters by `target`, (p, z).

        It is the pseudo-inverse of the map to the target, of the given `rank`. Rows of parameters
        that are fixed exactly are 0. None where the target hardly changes with some combination of
        the parameters, so that the derivative cannot be calculated.
        """
        slopes, whole = self._residuals(theta)[1], np.zeros((len(theta), len(self.target)))
        if rank == 0:
            return whole
        sizes = np.linalg.norm(slopes, axis=0)
        sizes = np.where(sizes > 0, sizes, 1.0)
        left, values, right = np.linalg.svd(slopes / sizes, full_matrices=False)
        if values[rank - 1] < _MIN_SENSITIVITY * values[0] or not values[0] > 0:
            return None
        inverse = (right[:rank].T / values[:rank]) @ left[:, :rank].T
        whole[self.free] = (inverse / sizes[:, None]) @ self._whiten
        return whole

    def _residuals(self, theta: Array, whiten: Array | None = None) -> tuple[Array, Array]:
        """Return ``W (target - expected)``, (z,), and the slopes of ``W expected``, (z, f).

        The expected values are the base parameters and uncertain fixed values that `theta`, (p,),
        implies. The slopes are by the f unknowns. W is `whiten`, (z, z), by default that of the
        covariance of the target.
        """
        whiten = self._whiten if whiten is None else whiten
        beta, jacobian = mapped(self.base, theta)
        expected = np.concatenate([beta, theta[self._uncertain]])
        slopes = np.vstack([jacobian, np.eye(len(theta))[self._uncertain]])[:, self.free]
        return whiten @ (self.target - expected), whiten @ slopes

    def _descend(self, start: Array) -> Minimum:
        """Return the end of a descent (Gauss-Newton) from a start, (p,), and its squared distance.

        The descent is repeated with smaller and smaller least standard errors, `_SHARPEST`, each
        from the end of the previous one. The distance is infinite where it is not finite.
        """
        from scipy.optimize import least_squares

        theta = start.copy()

        def residuals_at(unknowns: Array, whiten: Array) -> Array:
            """Return the whitened residuals, (z,), for values of the unknowns, (f,)."""
            theta[self.free] = unknowns
            return self._residuals(theta, whiten)[0]

        def jacobian_at(unknowns: Array, whiten: Array) -> Array:
            """Return the derivatives of the whitened residuals by the unknowns, (z, f)."""
            theta[self.free] = unknowns
            return -self._residuals(theta, whiten)[1]

        # Without unknowns there is nothing to minimise.
        whitenings = self._wider if self.free else []
        with np.errstate(all="ignore"):
            for whiten in whitenings:
                try:
                    fit = least_squares(
                        residuals_at,
                        theta[self.free],
                        jacobian_at,
                        args=(whiten,),
                        x_scale="jac",
                        xtol=_STILL,
                        ftol=_STILL,
                        gtol=_STILL,
                        max_nfev=_MOST_STEPS,
                    )
                except ValueError:  # no finite value
                    return start, np.inf
                theta[self.free] = fit.x
            residuals, _ = self._residuals(theta)
            cost = float(residuals @ residuals)
        return theta, cost if np.isfinite(cost) else np.inf

    def _starts(self) -> Iterator[Array]:
        """Yield starts of the descents, (p,) each.

        These are the nominal values, with several sizes in place of nominal values of 0 in
        nonlinear monomials; then the same with all unknowns multiplied by 3 and by 1/3. A linear
        map has a single start.
        """
        nonlinear = np.any(self._exponents[self._exponents.sum(axis=1) > 1] > 0, axis=0)
        at_zero = (self._start == 0) & ~self._known & nonlinear
        sizes = _SIZES if np.any(at_zero) else (1.0,)
        stretches = _STRETCHES if np.any(nonlinear) else (1.0,)
        for stretch, size in product(stretches, sizes):
            filled = np.where(at_zero, size, self._start)
            yield np.where(self._known, filled, stretch * filled)

    def _mirrored(self, theta: Array) -> Iterator[Array]:
        """Yield `theta`, (p,), with changed signs that leave the base parameters unchanged."""
        odd = np.mod(self._exponents[np.any(np.array(self.base.weights) != 0, axis=0)], 2)
        # Only parameters in a monomial of even power, or with others, can change their sign.
        alone = np.any((odd == 1) & (odd.sum(axis=1, keepdims=True) == 1), axis=0)
        able = np.flatnonzero(~self._known & (theta != 0) & ~alone)[:_MOST_SIGNS]
        for flips in product((0, 1), repeat=len(able)):
            chosen = np.zeros(len(theta))
            chosen[able] = flips
            if any(flips) and not np.any(np.mod(odd @ chosen, 2)):
                yield np.where(chosen == 1, -theta, theta)

    def _inside(self, theta: Array) -> bool:
        """Return True if all parameters, (p,), are within their declared bounds."""
        return bool(np.all((self._low <= theta) & (theta <= self._high)))


def _whitening(covariance: Array, values: Array, sharpest: float) -> Array:
    """Return a matrix W with ``W' W = C^-1`` for the covariance C, (z, z).

    Standard errors are at least `sharpest` times the size of the values, (z,), so that exact values
    do not make W infinite.
    """
    least = sharpest * np.where(values == 0, 1.0, np.abs(values))
    deviations = np.maximum(np.sqrt(np.maximum(np.diag(covariance), 0.0)), least)
    relative = covariance / np.outer(deviations, deviations)
    np.fill_diagonal(relative, 1.0)
    sizes, vectors = np.linalg.eigh(relative)
    safe = np.maximum(sizes, np.finfo(float).eps * len(sizes))
    return np.asarray((vectors / np.sqrt(safe)).T / deviations, dtype=float)


# squared standard errors from the estimate, up to which physical parameters reproduce it
_MAX_EXACT_DISTANCE = 1e-6
# smallest singular value of the scaled map to base parameters, relative to the largest; below it,
# the physical parameters cannot be calculated
_MIN_SENSITIVITY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Physical(Exact):
    """Physical parameters of one estimate.

    Attributes
    ----------
    method : str
        Method of the estimate.
    known : tuple of Parameter
        Parameters with a fixed value, known independently of the record.
    combined : tuple of Parameter
        Base parameters that are not declared parameters, described by the parameters in them.
    own : tuple of str
        Names of the base parameters, which are the parameters of the estimate itself.
    parameters : NamedValues
        Declared parameters that can be calculated, by name.
    covariances : mapping of str to array
        Covariance matrices of `parameters`, in their order, by name: ``iid``, ``robust``, ``hac``.
    undetermined : tuple of str
        Sentences on parameters that cannot be calculated, with the values that would have to be
        known; empty where all can be calculated.
    statistic, dof, p_value : float, int, float or None
        The minimum distance, Hotelling's T squared with `dof` restrictions, and its p-value; None
        where the fixed values cannot contradict the record.
    remarks : tuple of str
        Remarks on other values that fit as well, and on violated bounds.
    """

    method: str
    known: tuple[Parameter, ...]
    combined: tuple[Parameter, ...]
    own: tuple[str, ...]
    parameters: NamedValues
    covariances: Mapping[str, Array]
    undetermined: tuple[str, ...]
    statistic: float
    dof: int
    p_value: float | None
    remarks: tuple[str, ...]

    @property
    def shows_more(self) -> bool:
        """True if there is information beyond the base parameters."""
        return bool(self.parameters) and bool(self.known or {*self.parameters} - {*self.own})


class PhysicalByMethod(dict[str, Physical]):
    """Physical parameters by method; an unknown method is refused with a list of the methods."""

    def __getitem__(self, method: str) -> Physical:
        """Return the physical parameters by one method; UsageError for an unknown method."""
        name = method.lower() if isinstance(method, str) else method
        if is_among(name, self):
            return super().__getitem__(name)
        advice = (
            "The estimates have the physical parameters already. Read result[METHOD].parameters"
        )
        if self:
            advice = (
                f"Choose from {', '.join(self)}, and then a parameter by name: "
                "result.physical[METHOD].parameters[NAME]"
            )
        raise UsageError(
            f"there are no physical parameters by the method {quoted(method)}. {advice}.",
            code="result",
        )


def physical_parameters(method: str, form: Form, of_base: SamplingDistribution) -> Physical | None:
    """Return physical parameters from estimated base parameters and the fixed values of the axis.

    They are the declared parameters with the smallest `Distance` from both. Their covariances
    follow by the delta method.

    Parameters
    ----------
    method : str
        Method of the estimate.
    form : Form
        Form of the regression, which has the axis of the parameters.
    of_base : SamplingDistribution
        Distribution of the base parameters.

    Returns
    -------
    Physical or None
        None where the parameters of the estimate are the physical parameters and none is known, and
        for joint forms of several records, which have parameters for each record.

    References
    ----------
    [NeweyMcFadden1994]_.
    """
    base = form.axis.base
    if isinstance(form, JointForm) or not (base.changed or base.known):
        return None
    # Minimum distance, with the errors of the base parameters by noise and by the drive gain.
    expected, by_gain = of_base.covariances[of_base.chosen], of_base.by_gain
    if by_gain is not None:
        expected = expected + np.outer(by_gain, by_gain)
    distance = Distance(base, of_base.corrected, expected)
    theta, cost = distance.minimum()
    rank = len(distance.free) - len(base.undetermined)
    dof = len(distance.target) - rank
    # Derivatives of the solution by base parameters and fixed values, or why there is no solution.
    influence, undetermined = None, describe_undetermined(base)
    if not np.isfinite(cost) or (dof == 0 and cost > _MAX_EXACT_DISTANCE):
        undetermined += (
            "no values of the physical parameters give the estimated base parameters. Check the "
            "equation of motion and the fixed values, or declare better nominal values",
        )
    else:
        influence = distance.influence(theta, rank)
        if influence is None:
            undetermined += (
                "at this estimate the base parameters hardly change with the physical parameters, "
                "which therefore cannot be calculated. Fix other values",
            )
    # Distribution of the declared parameters that are determined; `kept` has their indices.
    declared, undetermined_parameters = base.declared.parameters, undetermined_names(base)
    dof_of_base = float(np.min(of_base.freedom[of_base.chosen]))
    kept: list[int] = []
    slopes = np.zeros((0, len(distance.target)))
    if influence is not None:
        kept = [j for j, p in enumerate(declared) if p.name not in undetermined_parameters]
        slopes = influence[kept]
    # Values that are fixed so far away that the distance is not finite contradict the record.
    is_tested = dof > 0 and (influence is not None or not np.isfinite(cost))
    distribution = SamplingDistribution(
        quantities=tuple(Quantity(name=declared[j].name, unit=declared[j].unit) for j in kept),
        theta=theta[kept],
        covariances={
            name: delta_method(distance.covariance(c), slopes)
            for name, c in of_base.covariances.items()
        },
        freedom={name: np.full(len(kept), np.min(each)) for name, each in of_base.freedom.items()},
        chosen=of_base.chosen,
        by_gain=None if by_gain is None else slopes[:, : len(by_gain)] @ by_gain,
    )
    remarks = [*_remarks_on_other_solutions(distance, theta, kept)] if kept else []
    remarks += [
        declared[j].out_of_bounds(theta[j])
        for j in kept
        if declared[j].known is None and not declared[j].allows(theta[j])
    ]
    return Physical(
        method=method,
        known=base.known,
        combined=tuple(p for p, _ in base.combined),
        own=tuple(p.name for p in base.axis.parameters),
        parameters=distribution.values,
        covariances=distribution.covariances,
        undetermined=undetermined,
        statistic=min(cost, float(np.finfo(float).max)) if is_tested else 0.0,
        dof=dof if is_tested else 0,
        p_value=hotelling_p_value(cost, dof, dof_of_base) if is_tested else None,
        remarks=tuple(remarks),
    )


def _remarks_on_other_solutions(distance: Distance, theta: Array, kept: list[int]) -> Iterator[str]:
    """Yield remarks on other solutions of the minimum distance within the declared bounds.

    `theta`, (p,), is the reported solution; `kept` has the indices of the reported parameters.
    """
    names = [p.name for p in distance.base.declared.parameters]
    for other in distance.others(theta):
        same = distance.are_same(theta, other)
        values = ", ".join(f"{names[j]} = {other[j]:.4g}" for j in kept if not same[j])
        if values:
            yield (
                f"{values} would fit as well. The reported values are nearer to the nominal "
                "values. Declare bounds that exclude one of the two solutions"
            )
