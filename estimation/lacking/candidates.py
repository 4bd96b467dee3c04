"""What a model may lack, as columns beside its own: terms by name, and parameters that change.

A family is one kind of it over a grid: of Stribeck velocities, of periods, of times. Its gain is
what a candidate takes of the sum of squares that the model, and what was found before, leave.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.special import ndtri_exp

from axisid.estimation.thresholds.lacking import (
    MAX_LOSS_OF_FIT,
    MIN_OWN_PART,
    NEARLY_AS_GOOD,
    TRIMMED_SHARE,
)
from axisid.support.arrays import Array, runs

from .examined_rows import ExaminedRows
from .terms import OF_KIND, PLAIN, Kind, Term

_FREQUENT, _RARE = 0.05, 1e-300  # p-values: the tail is none of the first, and 0 has no square
_NEAR = np.geomspace(0.5, 1.6, 33)  # of an antiresonance


class Family(ABC):
    """Candidates of one kind.

    Attributes
    ----------
    kind : str
    parameter : str
        What changes; empty for terms.
    """

    kind: Kind
    parameter: str

    @abstractmethod
    def gains(self, basis: Array, residuals: Array) -> Array:
        """Sums of squares that each candidate takes of residuals (n,) beside a basis (n, r)."""

    def best(self, basis: Array, residuals: Array) -> tuple[float, int]:
        """The largest gain, and the number of its candidate."""
        gains = self.gains(basis, residuals)
        number = int(np.argmax(gains))
        return float(gains[number]), number

    @abstractmethod
    def columns(self, number: int) -> Array:
        """One candidate, (n, g)."""

    @abstractmethod
    def at(self, number: int, basis: Array, residuals: Array) -> float:
        """Its place on the grid: a speed, a period, a time in s; NaN for none."""

    @property
    def subject(self) -> str:
        """What it is about: another of that may only be its shape seen otherwise."""
        return self.parameter or OF_KIND[self.kind].subject or self.kind

    def tells(self, other: "Family") -> bool:
        """Whether, once it is found, the other may only be it again."""
        of_speed = self.kind in PLAIN and other.subject == "speed"
        is_last = not self.parameter and OF_KIND[self.kind].is_last
        return other.subject == self.subject or of_speed or is_last

    def finer(self, number: int) -> "Family":  # noqa: ARG002
        """Candidates near one on the grid; itself where there are none between."""
        return self

    @abstractmethod
    def chance(self, single: float) -> float:
        """P-value of the best of the family from its own."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CandidateGrid(Family):
    """Candidates as they are, each of one column or two.

    Attributes
    ----------
    kind : str
    each : (n, m, g) array
    places : (m,) array
    parameter : str
    """

    kind: Kind
    each: Array
    places: Array
    parameter: str = ""

    def gains(self, basis: Array, residuals: Array) -> Array:
        """See `Family.gains`."""
        n, m, g = self.each.shape
        flat = self.each.reshape(n, m * g)
        within = (basis.T @ flat).reshape(-1, m, g)
        product = (residuals @ flat).reshape(m, g)
        size = self._products
        own = size - np.einsum("rmg,rmh->mgh", within, within)
        if g == 1:
            return _gain(product[:, 0], own[:, 0, 0], size[:, 0, 0])
        a, b, c = own[:, 0, 0], own[:, 1, 1], own[:, 0, 1]
        determinant = a * b - c**2
        whole = size[:, 0, 0] * size[:, 1, 1] - size[:, 0, 1] ** 2
        is_apart = determinant > MIN_OWN_PART.value**4 * whole
        u, v = product.T
        found = (b * u**2 - 2 * c * u * v + a * v**2) / np.where(is_apart, determinant, 1.0)
        return np.where(is_apart, found, 0.0)

    @cached_property
    def _products(self) -> Array:
        """Of each candidate's columns with each other, (m, g, g)."""
        return np.asarray(np.einsum("nmg,nmh->mgh", self.each, self.each), dtype=float)

    def columns(self, number: int) -> Array:
        """See `Family.columns`."""
        return self.each[:, number]

    def at(self, number: int, basis: Array, residuals: Array) -> float:  # noqa: ARG002
        """See `Family.at`."""
        return float(self.places[number])

    def chance(self, single: float) -> float:
        """See `Family.chance`; by Bonferroni."""
        return min(1.0, single * len(self.places))


class Peaks(CandidateGrid):
    """Peaks of friction about zero speed, from narrow to wide."""

    def best(self, basis: Array, residuals: Array) -> tuple[float, int]:
        """See `Family.best`; the widest that is as good: an axis that sticks hides a peak."""
        gains = self.gains(basis, residuals)
        good = gains >= NEARLY_AS_GOOD.value * gains.max()
        number = int(np.flatnonzero(good)[-1])
        return float(gains[number]), number


@dataclass(frozen=True, kw_only=True, eq=False)
class Steps(Family):
    """A parameter that is another from a row on, over all rows but the first and the last.

    Attributes
    ----------
    parameter : str
    column : (n,) array
        Of the regressor.
    times : (n,) array
        s
    """

    parameter: str
    column: Array
    times: Array
    kind: Kind = "change"

    def gains(self, basis: Array, residuals: Array) -> Array:
        """See `Family.gains`; of sums from the end, in place of columns."""
        size = _from(self.column**2)
        within = np.sum(_from(basis * self.column[:, None]) ** 2, axis=1)
        found = _gain(_from(self.column * residuals), size - within, size)
        share = size / size[0]
        trimmed = TRIMMED_SHARE.value
        return np.where((share > trimmed) & (share < 1 - trimmed), found, 0.0)

    def columns(self, number: int) -> Array:
        """See `Family.columns`."""
        return np.where(np.arange(len(self.column)) >= number, self.column, 0.0)[:, None]

    def at(self, number: int, basis: Array, residuals: Array) -> float:
        """See `Family.at`; the middle of the rows that do as well, such as those of a rest."""
        gains = self.gains(basis, residuals)
        left = float(residuals @ residuals) - gains[number]
        good = gains >= gains[number] - MAX_LOSS_OF_FIT.value * left / len(gains)
        first, last = next((a, b) for a, b in runs(good) if a <= number < b)
        return float(self.times[first] + self.times[last - 1]) / 2

    def chance(self, single: float) -> float:
        """See `Family.chance`; of the largest over the times."""
        return supremum_p(single, TRIMMED_SHARE.value)


def supremum_p(single: float, trimmed: float) -> float:
    """P-value of the largest Wald statistic of one parameter over the times of a change.

    Parameters
    ----------
    single : float
        That of the statistic at a time that was known.
    trimmed : float
        Part of the record at either end in which no change is looked for.

    References
    ----------
    [Andrews1993]_ for the limit, [Estrella2003]_ for its tail.
    """
    if single > _FREQUENT:
        return 1.0
    square = float(ndtri_exp(np.log(max(single, _RARE) / 2)) ** 2)
    times = 2 * np.log((1 - trimmed) / trimmed)
    tail = np.sqrt(square / 2 / np.pi) * np.exp(-square / 2)
    return min(1.0, float(tail * ((1 - 1 / square) * times + 2 / square)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Waves(CandidateGrid):
    """Waves over the position, of periods whose inverses are evenly apart.

    Attributes
    ----------
    make : callable
        Columns, (n, m, 2), of periods.
    between : callable
        Periods about one of them.
    """

    make: Callable[[Array], Array]
    between: Callable[[Array, float], Array]

    def finer(self, number: int) -> "CandidateGrid":
        """See `Family.finer`."""
        places = self.between(self.places, float(self.places[number]))
        return replace(self, each=self.make(places), places=places)


@dataclass(frozen=True, kw_only=True, eq=False)
class Resonances(CandidateGrid):
    """Loads behind springs.

    Attributes
    ----------
    measured : callable
        The columns, (n, m, 1), by the motion that was measured.
    """

    measured: Callable[[Array], Array]

    def at(self, number: int, basis: Array, residuals: Array) -> float:
        """See `Family.at`; by the measured motion, which swings as the load does.

        The simulated one swings with its loop: its columns are the instruments.
        """
        places = self.places[number] * _NEAR
        instruments, seen = (
            columns - basis @ (basis.T @ columns)
            for columns in (self.each[:, :, 0], self.measured(places)[:, :, 0])
        )
        span, _ = np.linalg.qr(instruments / np.linalg.norm(instruments, axis=0))
        told, seen = span.T @ residuals, span.T @ seen
        gains = np.maximum(told @ seen, 0.0) ** 2 / np.sum(seen**2, axis=0)
        return float(places[np.argmax(gains)])


def families(x: ExaminedRows, names: tuple[str, ...], terms: Sequence[Term]) -> list[Family]:
    """Everything that is looked for: terms, and changes of the parameters of these names."""
    return [*_terms(x, terms), *_of_time(x, names)]


def _terms(x: ExaminedRows, terms: Sequence[Term]) -> Iterator[Family]:
    for term in terms:
        places, make = term.places(x.along), partial(term.columns, x.along)
        if not len(places):
            continue
        grid = CandidateGrid(kind=term.kind, each=make(places), places=places)
        if term.kind == "stribeck":
            yield Peaks(**vars(grid))
        elif term.kind == "resonance":
            yield Resonances(**vars(grid), measured=partial(term.columns, x.measured_along))
        elif term.between is not None:
            yield Waves(**vars(grid), make=make, between=term.between)
        else:
            yield grid


def _of_time(x: ExaminedRows, names: tuple[str, ...]) -> Iterator[Family]:
    times = x.times
    along = (times - times[0]) / (times[-1] - times[0])
    for name, column in zip(names, x.regressor.T, strict=True):
        if not column.any():  # nothing that these rows could show of it changes
            continue
        yield Steps(parameter=name, column=column, times=times)
        drift = (column * along)[:, None, None]
        yield CandidateGrid(kind="drift", parameter=name, each=drift, places=np.array([np.nan]))


def _gain(product: Array, own: Array, size: Array) -> Array:
    is_apart = own > MIN_OWN_PART.value**2 * size
    return np.where(is_apart, product**2 / np.where(is_apart, own, 1.0), 0.0)


def _from(values: Array) -> Array:
    """Sums from each row to the last."""
    return np.asarray(np.cumsum(values[::-1], axis=0)[::-1], dtype=float)
