"""What a model may lack, as columns beside its own: terms by name, and parameters that change.

A family is one kind of it over a grid: of Stribeck velocities, of periods, of times. Its gain is
what a candidate takes of the sum of squares that the model, and what was found before, leave.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.special import ndtri_exp

from axisid.estimation.signals import Span
from axisid.estimation.thresholds.lacking import (
    MAX_LOSS_OF_FIT,
    MIN_OWN_PART,
    NEARLY_AS_GOOD,
    TRIMMED_SHARE,
)
from axisid.support.arrays import Array, runs

from .examined_rows import ExaminedRows

Kind = Literal[
    "coulomb",
    "viscous",
    "direction",
    "quadratic",
    "stribeck",
    "slope",
    "bend",
    "friction slope",
    "friction bend",
    "turn",
    "place",
    "friction place",
    "dead band",
    "delay",
    "change",
    "drift",
]

_SPEEDS = np.geomspace(0.015, 0.5, 8)  # of a Stribeck velocity, by the largest speed
_MOST_WAVES = 40  # in twice the travel
_LONGEST = 0.75  # of the least wave number
_ROWS_IN_A_WAVE = 4.0
_TURN = np.array([2 * np.pi])  # rad
_FREQUENT, _RARE = 0.05, 1e-300  # p-values: the tail is none of the first, and 0 has no square
_SUBJECTS = {
    "quadratic": "speed",
    "stribeck": "speed",
    "slope": "place",
    "bend": "place",
    "turn": "place",
    "friction slope": "friction over the place",
    "friction bend": "friction over the place",
    "friction place": "friction over the place",
}
#: Friction that nearly any axis has: what its lack bends over the speed is no term of its own.
PLAIN: tuple[Kind, ...] = ("coulomb", "viscous")
_FINER = np.linspace(-1.0, 1.0, 11)  # steps of the grid of waves


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
        return self.parameter or _SUBJECTS.get(self.kind, self.kind)

    def tells(self, other: "Family") -> bool:
        """Whether, once it is found, the other may only be it again."""
        return other.subject == self.subject or (self.kind in PLAIN and other.subject == "speed")

    def finer(self, number: int) -> "Family":  # noqa: ARG002
        """Candidates near one on the grid; itself where there are none between."""
        return self

    @abstractmethod
    def chance(self, single: float) -> float:
        """P-value of the best of the family from its own."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid(Family):
    """Candidates as they are, each of one column or two.

    Attributes
    ----------
    kind : str
    each : (n, m, g) array
    places : (m,) array
    parameter : str
    make : callable, optional
        Columns, (n, m, g), of other places.
    """

    kind: Kind
    each: Array
    places: Array
    parameter: str = ""
    make: Callable[[Array], Array] | None = None

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

    def finer(self, number: int) -> "Grid":
        """See `Family.finer`."""
        if self.make is None:
            return self
        inverse = 1 / self.places  # a grid of wave numbers
        step = abs(float(inverse[1] - inverse[0]))
        near = inverse[number] + step * _FINER
        places = 1 / near[near > _LONGEST * inverse[0]]
        return Grid(kind=self.kind, each=self.make(places), places=places)

    def chance(self, single: float) -> float:
        """See `Family.chance`; by Bonferroni."""
        return min(1.0, single * len(self.places))


class Peaks(Grid):
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


def families(
    x: ExaminedRows, names: tuple[str, ...], *, turns: bool, commanded: bool
) -> list[Family]:
    """Everything that is looked for.

    Parameters
    ----------
    x : ExaminedRows
    names : tuple of str
        Of the regressor's columns.
    turns : bool
        Whether the position is an angle.
    commanded : bool
        Whether the force is taken as that of commands, of which a drive may make less.
    """
    return [*_terms(x, commanded=commanded), *_of_places(x, turns=turns), *_of_time(x, names)]


def _terms(x: ExaminedRows, *, commanded: bool) -> Iterator[Family]:
    s, rows, ones = x.signals, x.samples, x.weights
    speed = np.abs(s.velocity)
    widths = _SPEEDS * float(speed.max())
    peaks = s.direction[:, None] * np.exp(-speed[:, None] / widths)
    v, q = s.velocity[rows], x.place
    alone = np.array([np.nan])
    singles: tuple[tuple[Kind, Array], ...] = (
        ("coulomb", x.direction),
        ("viscous", ones * v),
        ("direction", ones * np.abs(v)),
        ("quadratic", ones * v * np.abs(v)),
        ("slope", ones * q),
        ("bend", ones * q**2),
        ("friction slope", x.direction * q),
        ("friction bend", x.direction * q**2),
        ("delay", ones * change_by_stretch(s.force, x.sampling.spans)[rows]),
    )
    if commanded:
        singles += (("dead band", x.sampling.reduce(np.sign(s.force))),)
    for kind, column in singles:
        yield Grid(kind=kind, each=column[:, None, None], places=alone)
    reduced = x.sampling.reduce(peaks)
    yield Peaks(kind="stribeck", each=reduced[:, :, None], places=widths)


def change_by_stretch(values: Array, spans: Sequence[Span]) -> Array:
    """Change of values (N,) in a sample, of each stretch by itself; zero outside of them."""
    found = np.zeros_like(values)
    for first, last in spans:
        found[first:last] = np.gradient(values[first:last])
    return found


def _of_places(x: ExaminedRows, *, turns: bool) -> Iterator[Family]:
    q, travel = x.place, float(np.ptp(x.place))
    if not travel > 0:
        return
    steps = np.abs(np.diff(q))
    apart = float(np.median(steps[steps > 0])) if np.any(steps > 0) else travel
    most = int(min(_MOST_WAVES, 2 * travel / (_ROWS_IN_A_WAVE * apart)))
    if turns:
        yield Grid(kind="turn", each=_waves(q, x.weights, _TURN), places=_TURN)
    if most < 3:
        return
    periods = 2 * travel / np.arange(2, most + 1)  # longer ones are slopes and bends
    kinds: tuple[tuple[Kind, Array], ...] = (
        ("place", x.weights),
        ("friction place", x.direction),
    )
    for kind, factor in kinds:

        def make(at: Array, factor: Array = factor) -> Array:
            return _waves(q, factor, at)

        yield Grid(kind=kind, each=make(periods), places=periods, make=make)


def _of_time(x: ExaminedRows, names: tuple[str, ...]) -> Iterator[Family]:
    times = x.times
    along = (times - times[0]) / (times[-1] - times[0])
    for name, column in zip(names, x.regressor.T, strict=True):
        if not column.any():  # nothing that these rows could show of it changes
            continue
        yield Steps(parameter=name, column=column, times=times)
        drift = (column * along)[:, None, None]
        yield Grid(kind="drift", parameter=name, each=drift, places=np.array([np.nan]))


def _waves(q: Array, factor: Array, periods: Array) -> Array:
    """Cosine and sine of each period, (n, m, 2)."""
    angle = 2 * np.pi * q[:, None] / periods
    both = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    return np.asarray(factor[:, None, None] * both, dtype=float)


def _gain(product: Array, own: Array, size: Array) -> Array:
    is_apart = own > MIN_OWN_PART.value**2 * size
    return np.where(is_apart, product**2 / np.where(is_apart, own, 1.0), 0.0)


def _from(values: Array) -> Array:
    """Sums from each row to the last."""
    return np.asarray(np.cumsum(values[::-1], axis=0)[::-1], dtype=float)
