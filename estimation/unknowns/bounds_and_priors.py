"""Unknowns of a fit: parameters with their bounds, priors, fixed values and scales."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.thresholds import LARGEST_VALUE
from axisid.support.arrays import Array, BoolArray, IntArray, column_sizes
from axisid.support.checks import by_name, is_real
from axisid.support.errors import DataError, ModelError, UsageError
from axisid.support.wording import quoted

from .nuisance_parameters import ExtendedForm

_MIN_PRIOR_DEVIATION = 1e-12  # of the value; a value with a smaller one is exact, to be fixed

#: A bound, or None for none.
BoundOrNone = float | None
_SPREAD = 0.5  # standard deviation of the logarithm of random starts, or relative to their size
_INSIDE = 0.05  # distance of a start from its bound, of the parameter's scale


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknowns:
    """Parameters of a fit with their bounds, priors and fixed values, (P,) each.

    Attributes
    ----------
    quantities : tuple of Quantity
        Names and units.
    lower, upper : array
        Bounds, SI; infinite for none.
    prior, prior_sd : array
        Mean and standard deviation of the prior; the latter is infinite without a prior.
    fixed : array
        Fixed values, SI; NaN for free parameters.
    """

    quantities: tuple[Quantity, ...]
    lower: Array
    upper: Array
    prior: Array
    prior_sd: Array
    fixed: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(q.name for q in self.quantities)

    @property
    def free(self) -> BoolArray:
        """True for free parameters, (P,)."""
        return np.isnan(self.fixed)

    @property
    def has_prior(self) -> BoolArray:
        """True for free parameters with a prior, (P,)."""
        return np.isfinite(self.prior_sd) & self.free

    @property
    def without_prior(self) -> "Unknowns":
        """The unknowns without priors."""
        return replace(self, prior_sd=np.full_like(self.prior_sd, np.inf))

    @property
    def known_rows(self) -> Array:
        """Derivatives of the prior errors by the parameters, (j, P): rows ``1/sd``."""
        return np.asarray(np.diag(1 / self.prior_sd)[self.has_prior])

    def prior_errors(self, at: Array) -> Array:
        """Return the prior errors ``(theta - prior)/sd`` of parameters (P,), (j,)."""
        return np.asarray(((at - self.prior) / self.prior_sd)[self.has_prior])

    def scale(self, start: Array, size: Array) -> Array:
        """Return the scale of each parameter for the steps of a search, (P,).

        It is the largest magnitude of its start value, smallest scale (`size`, see `least_sizes`)
        and prior value; 1 if all are 0.
        """
        scale = np.max(np.abs([start, size, self.prior]), axis=0)
        return np.where(scale > 0, scale, 1.0)

    def drawn_about(self, start: Array, size: Array, random: np.random.Generator) -> Array:
        """Return random parameters near a start, (P,).

        A parameter with a sign constraint is multiplied by ``exp(0.5 z)`` with z standard normal.
        Other parameters, and parameters that start at 0, are shifted by their size times z, to the
        allowed side.
        """
        draws = random.standard_normal(len(start))
        up, down = self.lower >= 0, self.upper <= 0
        signed = np.where(up, np.abs(draws), np.where(down, -np.abs(draws), draws))
        by_size = start + np.maximum(np.abs(start), _SPREAD * size) * signed
        by_factor = (start != 0) & (up | down)
        return np.where(by_factor, start * np.exp(_SPREAD * draws), by_size)

    def inside(self, start: Array, scale: Array) -> Array:
        """Return a start strictly inside the bounds, with the fixed values.

        A search that starts at a bound cannot leave it.
        """
        margin = np.minimum(_INSIDE * scale, (self.upper - self.lower) / 4)
        moved = np.clip(start, self.lower + margin, self.upper - margin)
        return np.where(self.free, moved, self.fixed)


def bounded_quadratic_minimum(
    lower: Array, upper: Array, at: Array, rows: Array, downhill: Array
) -> tuple[Array, IntArray]:
    """Return the minimum of a quadratic cost within bounds, (k,), and the active bounds, (k,).

    Minimises ``||J d||^2 / 2 - g' d`` for ``d = theta - at``. An active bound is -1 for the lower
    and 1 for the upper bound; 0 for a parameter inside its bounds.

    Parameters
    ----------
    lower, upper : (k,) array
        Bounds of the parameters.
    at : (k,) array
        Parameters at which gradient and J are known.
    rows : (n, k) array
        J, with the Hessian ``J'J``.
    downhill : (k,) array
        Negative gradient g.
    """
    from scipy.optimize import lsq_linear

    size = column_sizes(rows)
    triangle = np.asarray(np.linalg.qr(rows / size, mode="r"))
    low, high = ((end - at) * size for end in (lower, upper))
    found = lsq_linear(
        triangle, np.linalg.pinv(triangle.T) @ (downhill / size), (low, high), "bvls"
    )
    side = np.asarray(found.active_mask, dtype=np.int8)
    moved = at + found.x / size
    return np.where(side < 0, lower, np.where(side > 0, upper, moved)), side


def unknowns_of(
    form: ExtendedForm,
    bounds: Mapping[str, tuple[BoundOrNone, BoundOrNone]],
    prior: Mapping[str, tuple[float, float]],
    fixed: Mapping[str, float],
) -> Unknowns:
    """Return the unknowns of a form from the declaration and from given bounds, priors and values.

    Parameters
    ----------
    form : ExtendedForm
        The name of a local parameter stands for that of every record.
    bounds : mapping of str to (float or None, float or None)
        Bounds within the declared ones.
    prior : mapping of str to (float, float)
        Value and standard deviation.
    fixed : mapping of str to float
        Fixed values by name, SI.

    Raises
    ------
    UsageError
        A name is no parameter, or a value is no number, contradicts another, or is out of bounds.
    ModelError
        The axis fixes a parameter that is only searched in combination with others.
    """
    declared, local = form.declared, form.local
    found = Unknowns(
        quantities=form.physical_quantities,
        lower=np.array([p.lower for p in declared], dtype=float),
        upper=np.array([p.upper for p in declared], dtype=float),
        prior=np.zeros(len(declared)),
        prior_sd=np.full(len(declared), np.inf),
        fixed=np.full(len(declared), np.nan),
    )
    names = found.names

    def indices(name: object, what: _Given) -> list[int]:
        """Return the indices of the parameters that a name stands for.

        They are several for a local parameter of several records. An unknown name is refused, and
        so are a bound and a prior (`what` is given) of a parameter with a fixed value.
        """
        own = local.get(str(name), (str(name),))
        if not {*own} <= {*names}:
            raise UsageError(
                f"a {what} is given for {quoted(name)}, which is not a parameter of the fit. "
                f"Choose from {', '.join(names)}.",
                code="fit",
            )
        at = [names.index(each) for each in own]
        if what != "fixed value" and not found.free[at].all():
            raise UsageError(
                f"{quoted(name)} has both a fixed value and a {what}. Give only one of the two.",
                code="fit",
            )
        return at

    _take_declared(found, form)
    _take_fixed(found, fixed, indices)
    _take_bounds(found, bounds, indices)
    _take_priors(found, prior, indices)
    if not found.free.any():
        raise UsageError(
            "every parameter is fixed. Leave at least one parameter without a fixed value.",
            code="fit",
        )
    return found


def check_enough(counted: Array, spans: Sequence[Sequence[slice]], unknowns: Unknowns) -> None:
    """Refuse a search with fewer residuals than free parameters.

    Parameters
    ----------
    counted : (n,) array
        Positive for rows that are used.
    spans : sequence of sequence of slice
        Stretches by record.
    unknowns : Unknowns

    Raises
    ------
    DataError
        A record has no sample that is not masked, or all records together have too few.
    """
    for number, own in enumerate(spans, 1):
        if not any(np.any(counted[rows] > 0) for rows in own):
            which = f"record {number}" if len(spans) > 1 else "the record"
            raise DataError(
                f"every sample of {which} is masked, so that there is no output to fit. Mask fewer "
                "samples, or fit a part of the record that is not masked.",
                code="fit",
            )
    rows, searched = int(np.count_nonzero(counted)), int(unknowns.free.sum())
    if rows + int(unknowns.has_prior.sum()) <= searched:
        raise DataError(
            f"{rows} values of the output are too few for {searched} parameters. Record a longer "
            "motion, or fix parameters.",
            code="too-short",
        )


#: What is given for a parameter, as messages call it.
_Given = Literal["bound", "prior", "fixed value"]

#: Function that returns the indices of the parameters that a name stands for. Its arguments are the
#: name, and what is given for it.
_Indices = Callable[[object, _Given], list[int]]


def _take_declared(found: Unknowns, form: ExtendedForm) -> None:
    """Set the declared known values in the unknowns, in place.

    A value with a standard deviation is a prior, an exact value is fixed.
    """
    known = {p.name: p for p in (*form.declared, *form.axis.base.known) if p.known is not None}
    for p in known.values():
        if p.name not in found.names:
            raise ModelError(
                f"{p.name} of axis {form.axis.name!r} is fixed, but the fit searches "
                f"{', '.join(found.names)}, in which {p.name} is combined with other parameters. "
                "Fit without the fixed value, and let identify compute the other parameters with "
                "the fixed value.",
                code="fit",
            )
        at, value = found.names.index(p.name), float(p.known or 0.0)
        if p.known_sd:
            found.prior[at], found.prior_sd[at] = value, p.known_sd
        else:
            found.fixed[at] = value


def _take_bounds(
    found: Unknowns, bounds: Mapping[str, tuple[BoundOrNone, BoundOrNone]], indices: _Indices
) -> None:
    """Set given bounds in the unknowns, in place; bounds outside the declared ones have no effect.

    `indices` returns the indices of the parameters that a name stands for.
    """
    for name, given in by_name(bounds, "bounds").items():
        pair = given if isinstance(given, (tuple, list)) else (None,)
        if len(pair) != 2 or not all(end is None or is_real(end) for end in pair):
            raise UsageError(
                f"the bounds of {quoted(name)} are {quoted(given)}. Give a lower and an upper "
                "bound, each a number, or None for no bound.",
                code="fit",
            )
        for j in indices(name, "bound"):
            low = found.lower[j] if pair[0] is None else float(np.maximum(found.lower[j], pair[0]))
            high = found.upper[j] if pair[1] is None else float(np.minimum(found.upper[j], pair[1]))
            if not low < high:
                raise UsageError(
                    f"the given and declared bounds of {found.names[j]} together are {low:g} and "
                    f"{high:g}, and no value lies between them. Give other bounds, or fix "
                    f"{found.names[j]}.",
                    code="fit",
                )
            found.lower[j], found.upper[j] = low, high


def _take_priors(
    found: Unknowns, prior: Mapping[str, tuple[float, float]], indices: _Indices
) -> None:
    """Set given priors in the unknowns, in place.

    `indices` returns the indices of the parameters that a name stands for.
    """
    largest = LARGEST_VALUE.value
    for name, given in by_name(prior, "priors").items():
        own = indices(name, "prior")
        mean, sd = 0.0, 0.0  # refused below, as the standard deviation is 0
        if isinstance(given, (tuple, list)) and len(given) == 2 and all(map(is_real, given)):
            mean, sd = map(float, given)
        least = max(_MIN_PRIOR_DEVIATION * abs(mean), 1 / largest)
        if not (abs(mean) <= largest and least <= sd <= largest):
            raise UsageError(
                f"the prior of {quoted(name)} is {quoted(given)}. Give a value and its standard "
                f"deviation, both finite and of at most {largest:g}. If the standard deviation is "
                "0 or negligible, fix the value instead.",
                code="fit",
            )
        found.prior[own], found.prior_sd[own] = mean, sd


def _take_fixed(found: Unknowns, fixed: Mapping[str, float], indices: _Indices) -> None:
    """Set given fixed values in the unknowns, in place.

    `indices` returns the indices of the parameters that a name stands for.
    """
    for name, value in by_name(fixed, "fixed values").items():
        for j in indices(name, "fixed value"):
            low, high, is_number = found.lower[j], found.upper[j], is_real(value)
            if not (is_number and math.isfinite(value) and low <= value <= high):
                raise UsageError(
                    f"{found.names[j]} is fixed at {quoted(value)}. Give a finite number within "
                    f"its bounds of {low:g} and {high:g}.",
                    code="fit",
                )
            found.fixed[j] = float(value)
