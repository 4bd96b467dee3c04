"""The map from declared to base parameters in numbers, and the point of least distance to it."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from axisid.modeling.derivation import BaseModel
from axisid.support.arrays import Array

_SAME_DISTANCE = 1e-6  # between squares of distances in deviations, by one more than the lesser
_SAME_PARAMETER = 1e-3  # between two values of a parameter, by its size and deviation: they are one

_MOST_STEPS = 200
_STILL = 1e-10  # relative, of parameters, distance and slope
_SIZES = (1.0, 0.1, 10.0, 0.01, 100.0)  # where a nominal value of 0 says nothing
_STRETCHES = (1.0, 3.0, 1 / 3)
#: Relative deviations that none is taken below, from where it starts to where it ends: a product
#: that is known sharply is a narrow, curved valley, which is found by the wider ones about it.
_SHARPEST = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
_MOST_SIGNS = 8  # parameters whose signs are tried in all ways


def mapped(base: BaseModel, theta: Array) -> tuple[Array, Array]:
    """Base parameters (b,) of declared ones (p,), and the Jacobian (b, p).

    ``beta = weights . monomials(theta)``; dimensions as in `BaseModel`.
    """
    powers, weights = (np.array(each, dtype=float) for each in (base.exponents, base.weights))
    slopes = np.empty_like(powers)
    for j in range(len(theta)):
        lower = powers.copy()
        lower[:, j] = np.maximum(lower[:, j] - 1, 0)
        slopes[:, j] = powers[:, j] * np.prod(theta**lower, axis=1)
    return weights @ np.prod(theta**powers, axis=1), weights @ slopes


@dataclass(frozen=True, slots=True)
class Minimum:
    """Declared parameters (p,) and their squared distance, in deviations."""

    theta: Array
    cost: float


class Distance:
    """How far declared parameters are from base parameters and fixed values.

    Attributes
    ----------
    free : list of int
        The unknowns among the p declared parameters: those not fixed exactly.
    target : (z,) array
        Base parameters, then the values fixed with a deviation.
    """

    def __init__(self, base: BaseModel, beta: Array, covariance: Array) -> None:
        self.base, declared = base, base.declared.parameters
        self._exponents = np.array(base.exponents, dtype=float)
        self._known = [j for j, p in enumerate(declared) if p.known is not None]
        self._uncertain = [j for j in self._known if declared[j].known_sd > 0]
        exact = set(self._known) - set(self._uncertain)
        self.free = [j for j in range(len(declared)) if j not in exact]
        self._start = np.array([p.nominal if p.known is None else p.known for p in declared])
        self._low = np.array([p.lower for p in declared])
        self._high = np.array([p.upper for p in declared])
        self._spread = np.array([declared[j].known_sd for j in self._uncertain])
        self.target = np.concatenate([beta, self._start[self._uncertain]])
        whole = self.covariance(covariance)
        self._wider = [_whitening(whole, self.target, least) for least in _SHARPEST]
        self._whiten = self._wider[-1]

    def covariance(self, of_beta: Array) -> Array:
        """Of the target, (z, z), from that of the base parameters."""
        b, f = len(of_beta), len(self._spread)
        whole = np.zeros((b + f, b + f))
        whole[:b, :b] = of_beta
        whole[b:, b:] = np.diag(self._spread**2)
        return whole

    def minimum(self) -> Minimum:
        """The nearest parameters, inside the bounds if any there are as near."""
        found = [self._descend(start) for start in self._starts()]
        least = min(each.cost for each in found)
        near = [each for each in found if _is_as_near(each, least)] or found
        near += [
            Minimum(theta, near[0].cost)
            for theta in self._mirrored(near[0].theta)
            if not self._inside(near[0].theta)
        ]
        return next((each for each in near if self._inside(each.theta)), near[0])

    def others(self, theta: Array) -> list[Array]:
        """Further parameters inside the bounds that are as near, each once."""
        cost = self._residuals(theta)[0]
        least = float(cost @ cost)
        candidates = [*self._mirrored(theta)]
        if not self.base.undetermined:
            ends = [self._descend(start) for start in self._starts()]
            candidates += [each.theta for each in ends if _is_as_near(each, least)]
        apart: list[Array] = []
        for other in candidates:
            is_new = not any(self.alike(seen, other).all() for seen in [theta, *apart])
            if is_new and self._inside(other):
                apart.append(other)
        return apart

    def alike(self, theta: Array, other: Array) -> NDArray[np.bool_]:
        """Which parameters (p,) of two solutions are one, by their size and their deviation."""
        slopes = np.linalg.norm(self._residuals(theta)[1], axis=0)
        deviations = np.zeros(len(theta))
        deviations[self.free] = np.divide(1.0, slopes, out=np.zeros(len(slopes)), where=slopes > 0)
        size = np.maximum(np.abs(theta), np.abs(other)) + deviations
        return np.asarray(np.abs(other - theta) <= _SAME_PARAMETER * size)

    def influence(self, theta: Array, rank: int) -> Array:
        """Derivative of the parameters (p, z) by the target; 0 for those fixed exactly."""
        _, slopes = self._residuals(theta)
        sizes, unit = _scaled(slopes)
        left, values, right = np.linalg.svd(unit, full_matrices=False)
        inverse = (right[:rank].T / values[:rank]) @ left[:, :rank].T
        whole = np.zeros((len(theta), len(self.target)))
        whole[self.free] = (inverse / sizes[:, None]) @ self._whiten
        return whole

    def sharpness(self, theta: Array, rank: int) -> float:
        """Smallest against largest singular value of the scaled Jacobian; 1 for no unknowns."""
        if rank == 0:
            return 1.0
        values = np.linalg.svd(_scaled(self._residuals(theta)[1])[1], compute_uv=False)
        return float(values[rank - 1] / values[0]) if values[0] > 0 else 0.0

    def _residuals(self, theta: Array, whiten: Array | None = None) -> tuple[Array, Array]:
        """Of the target less the map, in deviations, and the map's slopes by the unknowns."""
        whiten = self._whiten if whiten is None else whiten
        beta, jacobian = mapped(self.base, theta)
        expected = np.concatenate([beta, theta[self._uncertain]])
        slopes = np.vstack([jacobian, np.eye(len(theta))[self._uncertain]])[:, self.free]
        return whiten @ (self.target - expected), whiten @ slopes

    def _descend(self, start: Array) -> Minimum:
        """The nearest parameters from a start, whatever is known sharply being so step by step."""
        from scipy.optimize import least_squares

        theta = start.copy()

        def at(free: Array, whiten: Array) -> tuple[Array, Array]:
            theta[self.free] = free
            return self._residuals(theta, whiten)

        for whiten in self._wider if self.free else ():
            try:
                with np.errstate(all="ignore"):
                    found = least_squares(
                        lambda *here: at(*here)[0],
                        theta[self.free],
                        lambda *here: -at(*here)[1],
                        args=(whiten,),
                        x_scale="jac",
                        xtol=_STILL,
                        ftol=_STILL,
                        gtol=_STILL,
                        max_nfev=_MOST_STEPS,
                    )
            except ValueError:  # nothing is finite there
                return Minimum(start, np.inf)
            theta[self.free] = found.x
        left, _ = self._residuals(theta)
        return Minimum(theta, float(left @ left))

    def _starts(self) -> Iterator[Array]:
        """The nominal values first; where one is 0, other sizes; then neighbours."""
        known = np.isin(np.arange(len(self._start)), self._known)
        nonlinear = np.any(self._exponents[self._exponents.sum(axis=1) > 1] > 0, axis=0)
        at_zero = (self._start == 0) & ~known & nonlinear
        sizes = _SIZES if np.any(at_zero) else (1.0,)
        stretches = _STRETCHES if np.any(nonlinear) else (1.0,)
        for stretch, size in product(stretches, sizes):
            filled = np.where(at_zero, size, self._start)
            yield np.where(known, filled, stretch * filled)

    def _mirrored(self, theta: Array) -> Iterator[Array]:
        """The same base parameters from other signs: flips that leave every monomial's sign."""
        odd = np.mod(self._exponents[np.any(np.array(self.base.weights) != 0, axis=0)], 2)
        free = [j for j in range(len(theta)) if j not in self._known and theta[j] != 0]
        # Only parameters that enter some monomial evenly or beside others can flip.
        able = [j for j in free if not np.any((odd[:, j] == 1) & (odd.sum(axis=1) == 1))]
        for flips in product((0, 1), repeat=len(able[:_MOST_SIGNS])):
            chosen = np.zeros(len(theta))
            chosen[able[:_MOST_SIGNS]] = flips
            if any(flips) and not np.any(np.mod(odd @ chosen, 2)):
                yield np.where(chosen == 1, -theta, theta)

    def _inside(self, theta: Array) -> bool:
        return bool(np.all((self._low <= theta) & (theta <= self._high)))


def _scaled(slopes: Array) -> tuple[Array, Array]:
    sizes = np.linalg.norm(slopes, axis=0)
    sizes = np.where(sizes > 0, sizes, 1.0)
    return sizes, slopes / sizes


def _is_as_near(found: Minimum, least: float) -> bool:
    """Whether a minimum is the least one, but for rounding."""
    return found.cost <= least + _SAME_DISTANCE * (1 + least)


def _whitening(covariance: Array, values: Array, sharpest: float) -> Array:
    """``L^-1`` with ``L L' = C``, of values that are known to no more than a share."""
    least = sharpest * np.where(values == 0, 1.0, np.abs(values))
    deviations = np.maximum(np.sqrt(np.maximum(np.diag(covariance), 0.0)), least)
    relative = covariance / np.outer(deviations, deviations)
    np.fill_diagonal(relative, 1.0)
    sizes, vectors = np.linalg.eigh(relative)
    safe = np.maximum(sizes, np.finfo(float).eps * len(sizes))
    return np.asarray((vectors / np.sqrt(safe)).T / deviations, dtype=float)
