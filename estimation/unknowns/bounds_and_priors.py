"""What a fit searches: parameters with their bounds, priors, fixed values and scales."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.generated_axes import Quantity
from axisid.estimation.thresholds import LARGEST_VALUE
from axisid.support.arrays import Array, BoolArray, IntArray, column_sizes
from axisid.support.errors import DataError, ModelError, UsageError, by_name, is_real, quoted

from .nuisance_parameters import ExtendedForm

_MIN_PRIOR_DEVIATION = 1e-12  # of the value; what is surer is exact, and can be held

#: A bound, or None for none.
BoundOrNone = float | None
_SPREAD = 0.5  # of the logarithm of further starts, and of a size that counts as much as any
_INSIDE = 0.05  # of a parameter's scale, or a quarter of its range: how far inside it starts


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknowns:
    """The parameters of a fit, (P,) each.

    Attributes
    ----------
    quantities : tuple of Quantity
    lower, upper : array
    prior, prior_sd : array
        What was known before; infinite deviations where nothing was.
    fixed : array
        Values that are held; NaN where a parameter is searched.
    """

    quantities: tuple[Quantity, ...]
    lower: Array
    upper: Array
    prior: Array
    prior_sd: Array
    fixed: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(q.name for q in self.quantities)

    @property
    def free(self) -> BoolArray:
        """Which are searched."""
        return np.isnan(self.fixed)

    @property
    def has_prior(self) -> BoolArray:
        """Of which something was known before, and is weighed."""
        return np.isfinite(self.prior_sd) & self.free

    @property
    def without_prior(self) -> "Unknowns":
        """The same as if nothing had been known before."""
        return replace(self, prior_sd=np.full_like(self.prior_sd, np.inf))

    @property
    def known_rows(self) -> Array:
        """Slopes of what was known before, over its deviations, by the parameters, (j, P)."""
        return np.asarray(np.diag(1 / self.prior_sd)[self.has_prior])

    def known_errors(self, at: Array) -> Array:
        """How far parameters (P,) are from what was known before, over its deviations, (j,)."""
        return np.asarray(((at - self.prior) / self.prior_sd)[self.has_prior])

    def scale(self, start: Array, size: Array) -> Array:
        """Scale of each parameter, from which its steps follow; never 0, as friction may be."""
        scale = np.max(np.abs([start, size, self.prior]), axis=0)
        return np.where(scale > 0, scale, 1.0)

    def drawn_about(self, start: Array, size: Array, random: np.random.Generator) -> Array:
        """Parameters (P,) at random about a start: those of one sign by a factor, others by a size.

        A factor of what is 0 leaves it there, so that it is drawn by its size on the allowed side.
        """
        draws = random.standard_normal(len(start))
        up, down = self.lower >= 0, self.upper <= 0
        signed = np.where(up, np.abs(draws), np.where(down, -np.abs(draws), draws))
        by_size = start + np.maximum(np.abs(start), _SPREAD * size) * signed
        by_factor = (start != 0) & (up | down)
        return np.where(by_factor, start * np.exp(_SPREAD * draws), by_size)

    def inside(self, start: Array, scale: Array) -> Array:
        """A start strictly inside the bounds, fixed values as they are.

        A search that starts on a bound stands still there.
        """
        margin = np.minimum(_INSIDE * scale, (self.upper - self.lower) / 4)
        moved = np.clip(start, self.lower + margin, self.upper - margin)
        return np.where(self.free, moved, self.fixed)


def bounded_quadratic_minimum(
    lower: Array, upper: Array, at: Array, rows: Array, downhill: Array
) -> tuple[Array, IntArray]:
    """Parameters (k,) of the least cost within their bounds, and which are at one, -1 or 1.

    Parameters
    ----------
    lower, upper : (k,) array
    at : (k,) array
        Where the cost's slope is known.
    rows : (n, k) array
        Whose squares the cost curves by.
    downhill : (k,) array
        The negative of the slope.
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
    """The parameters of a form, with what was declared of them and what is asked for.

    Parameters
    ----------
    form : ExtendedForm
        What is said of a parameter that records have for themselves is said of all of them.
    bounds : mapping of str to (float or None, float or None)
        Narrower than the declared ones.
    prior : mapping of str to (float, float)
        Value and standard deviation.
    fixed : mapping of str to float

    Raises
    ------
    UsageError
        A name is no parameter's, or a value is none, contradicts another, or is out of bounds.
    ModelError
        The axis fixes a parameter that the fit does not search by itself.
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

    def places(name: object, what: str) -> list[int]:
        own = local.get(str(name), (str(name),))
        if not {*own} <= {*names}:
            raise UsageError(
                f"there is no parameter {quoted(name)} to {what}; the fit has {', '.join(names)}.",
                code="fit",
            )
        at = [names.index(each) for each in own]
        if what != "fix" and not found.free[at].all():
            raise UsageError(
                f"{quoted(name)} is fixed, which leaves nothing to {what} of it; give one of the "
                "two.",
                code="fit",
            )
        return at

    _take_declared(found, form)
    _take_fixed(found, fixed, places)
    _take_bounds(found, bounds, places)
    _take_priors(found, prior, places)
    if not found.free.any():
        raise UsageError("every parameter is fixed; leave at least one to search.", code="fit")
    return found


def check_enough(counted: Array, spans: Sequence[Sequence[slice]], unknowns: Unknowns) -> None:
    """Refuse to search for parameters by fewer errors than they are.

    Parameters
    ----------
    counted : (n,) array
        Which rows count.
    spans : sequence of sequence of slice
        Stretches by record.
    unknowns : Unknowns

    Raises
    ------
    DataError
        Nothing of a record is left to follow, or too little of all.
    """
    for number, own in enumerate(spans, 1):
        if not any(np.any(counted[rows] > 0) for rows in own):
            which = f"record {number}" if len(spans) > 1 else "the record"
            raise DataError(
                f"every sample of {which} is masked, so that nothing is left to follow; mask less, "
                "or follow a part that is not masked.",
                code="fit",
            )
    rows, searched = int(np.count_nonzero(counted)), int(unknowns.free.sum())
    if rows + int(unknowns.has_prior.sum()) <= searched:
        raise DataError(
            f"{rows} values of the output are left to follow, for {searched} parameters; record "
            "longer, or fix parameters.",
            code="too-short",
        )


_Places = Callable[[object, str], list[int]]


def _take_declared(found: Unknowns, form: ExtendedForm) -> None:
    """What the axis, or its drive, declares as known: held where it is exact, else weighed."""
    known = {p.name: p for p in (*form.declared, *form.axis.base.known) if p.known is not None}
    for p in known.values():
        if p.name not in found.names:
            raise ModelError(
                f"{p.name} of axis {form.axis.name!r} is fixed, and the fit searches "
                f"{', '.join(found.names)}, in which it is with others; leave the fixed value "
                "out, and let identify make the others of it.",
                code="fit",
            )
        at, value = found.names.index(p.name), float(p.known or 0.0)
        if p.known_sd:
            found.prior[at], found.prior_sd[at] = value, p.known_sd
        else:
            found.fixed[at] = value


def _take_bounds(
    found: Unknowns, bounds: Mapping[str, tuple[BoundOrNone, BoundOrNone]], places: _Places
) -> None:
    for name, given in by_name(bounds, "bounds").items():
        pair = given if isinstance(given, (tuple, list)) else (None,)
        if len(pair) != 2 or not all(end is None or is_real(end) for end in pair):
            raise UsageError(
                f"the bounds of {quoted(name)} are {quoted(given)}; give a lower and an upper one, "
                "None for none.",
                code="fit",
            )
        for j in places(name, "bound"):
            low = found.lower[j] if pair[0] is None else float(np.maximum(found.lower[j], pair[0]))
            high = found.upper[j] if pair[1] is None else float(np.minimum(found.upper[j], pair[1]))
            if not low < high:
                raise UsageError(
                    f"the bounds of {found.names[j]} leave nothing between {low:g} and {high:g}, "
                    "the declared ones counted; give others, or fix it.",
                    code="fit",
                )
            found.lower[j], found.upper[j] = low, high


def _take_priors(
    found: Unknowns, prior: Mapping[str, tuple[float, float]], places: _Places
) -> None:
    for name, given in by_name(prior, "values known before").items():
        own = places(name, "know")
        pair, largest = given if isinstance(given, (tuple, list)) else (), LARGEST_VALUE.value
        mean, sd = map(float, pair) if len(pair) == 2 and all(map(is_real, pair)) else (0.0, 0.0)
        least = max(_MIN_PRIOR_DEVIATION * abs(mean), 1 / largest)
        if not (abs(mean) <= largest and least <= sd <= largest):
            raise UsageError(
                f"what was known of {quoted(name)} is {quoted(given)}; give a value and its "
                f"standard deviation, finite and of {largest:g} at most, or fix it if that is 0 "
                "or as good as that.",
                code="fit",
            )
        found.prior[own], found.prior_sd[own] = mean, sd


def _take_fixed(found: Unknowns, fixed: Mapping[str, float], places: _Places) -> None:
    for name, value in by_name(fixed, "fixed values").items():
        for j in places(name, "fix"):
            low, high, is_number = found.lower[j], found.upper[j], is_real(value)
            if not (is_number and math.isfinite(value) and low <= value <= high):
                raise UsageError(
                    f"{found.names[j]} is fixed at {quoted(value)}; give a finite number within "
                    f"its bounds of {low:g} and {high:g}.",
                    code="fit",
                )
            found.fixed[j] = float(value)
