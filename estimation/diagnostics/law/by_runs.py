"""A law that is no sum of products of its gains against the recorded control.

Limited, filtered, adaptive, with an integral: no factor of a column says what a gain does. The law
is run along the record instead, with its gains a little off, and the slopes of its control by each
gain tell which gains are off; the least change of them that explains the control is found by runs
with the changed gains.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import LawAlong, LawPoint
from axisid.estimation.records import Record, quantum_of
from axisid.estimation.regression import Hac, Solution, factor, least_squares
from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import (
    MAX_LAW_RESIDUAL,
    MAX_ROUNDED_SHARE,
    MAX_SCALE_ERROR,
    MIN_DISTANCE_FROM_NOISE,
)
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent

from .factors import LAGS
from .sentences import WHICH_LAW
from .terms import noisy_ticks

# of a control, and of what other gains do not change of it; less tells nothing of a gain
_MIN_GAIN_TOLD_APART = 1e-4
# residual with one gain changed, by that with another; up to it, either may be wrong
_MAX_SAME_RESIDUAL = 1.1

_DRAWS = 3  # of what the log's last digit leaves open
_LARGEST = 5.0  # logarithm of a change that is told to first order


@dataclass(frozen=True, slots=True, kw_only=True)
class GainsBeside:
    """A law beside the recorded control, by its gains.

    Attributes
    ----------
    along : LawAlong
        The law.
    point : LawPoint
        Its declared gains, and the memory that the record's first controls show.
    compared : callable
        What is made of a control before it is compared.
    neighbours : Neighbours
        Of the rows that are compared.
    rounded : tuple of LawAlong
        The law along what may have been before the log rounded it, drawn at random; none where it
        rounds nothing.
    """

    along: LawAlong
    point: LawPoint
    compared: Callable[[Array], Array]
    neighbours: Neighbours
    rounded: tuple[LawAlong, ...] = ()

    @classmethod
    def of(
        cls,
        axis: GeneratedAxis,
        law: ControlLaw,
        record: Record,
        used: NDArray[np.bool_],
        smooth: Callable[[Array], Array],
    ) -> "GainsBeside":
        """A law beside a record of one piece, with a reference and a control.

        Parameters
        ----------
        axis : GeneratedAxis
            Under that law.
        law : ControlLaw
        record : Record
        used : (N,) array of bool
            Samples that are compared.
        smooth : callable
            What both sides are filtered by before.
        """
        ticks, start = noisy_ticks(axis, law, record)
        along = LawAlong.of(axis, law, ticks, record)
        # A control that a converter's noise took from the limit is none that the law gave.
        declared = LawPoint(along.declared.gains, start[: len(law.memory)])
        used = used & ~(np.abs(along.output(declared)) > along.limit)

        def compared(control: Array) -> Array:
            return np.asarray(smooth(control)[used])

        # With noise the first controls show what is remembered less well than all of them do.
        point = along.fitted(declared, compared, ())
        return cls(
            along=along,
            point=point,
            compared=compared,
            neighbours=Neighbours.of(np.flatnonzero(used), 1),
            rounded=tuple(_rounded(along, record)),
        )

    @property
    def gains(self) -> dict[str, float]:
        """By name, at the point."""
        return dict(zip(self.along.law.gains, map(float, self.point.gains), strict=True))

    def best(self, names: Sequence[str]) -> "GainsBeside":
        """The same with the values of such gains that give the recorded control best."""
        every = [*self.along.law.gains]
        free = [every.index(name) for name in names]
        return replace(self, point=self.along.fitted(self.point, self.compared, free))

    @property
    def open_percent(self) -> float:
        """How far the control of a right law may be off for what the log rounds, percent of it."""
        control = self.compared(self.along.control)
        off = (relative_error_percent(each, control) for each in self.left_open(self.point))
        return max(off, default=0.0)

    def unless_rounded(self) -> "GainsBeside":
        """The same without a rounding that the record refutes.

        A reference that its maker computes in whole steps looks like one that the log rounded, and
        the law reads the steps of an encoder as they are. Such steps would leave of the control, by
        any gains, what they do, which jumps from sample to sample as no other fault does.
        """
        for point in (self.point, self._changed(tuple(range(len(self.along.law.gains)))).point):
            sizes = [np.linalg.norm(np.diff(each)) for each in self.left_open(point)]
            jumps = np.linalg.norm(np.diff(self.left(point)))
            if jumps < max(sizes, default=0.0) / MIN_DISTANCE_FROM_NOISE.value:
                return replace(self, rounded=())
        return self

    def left_open(self, point: LawPoint) -> list[Array]:
        """By how much the output may differ for that, drawn at random, (n,) each."""
        undisturbed = self.along.output(point)
        return [self.compared(each.output(point) - undisturbed) for each in self.rounded]

    def left(self, point: LawPoint) -> Array:
        """What the law leaves of the control, but for another start of its memory, (n,)."""
        return self._besides_start(point, self._off(point)[:, None])[:, 0]

    def percent(self, point: LawPoint) -> float:
        """The same in percent of the control."""
        return relative_error_percent(self.left(point), self.compared(self.along.control))

    @property
    def flipped(self) -> "GainsBeside":
        """The same beside the control of the other sign."""
        along = replace(self.along, control=-self.along.control)
        return replace(self, along=along, point=along.fitted(along.declared, self.compared, ()))

    def flipped_percent(self, most: float) -> float | None:
        """What the law leaves of the control of the other sign, percent; None for more than most.

        What the log rounds is open besides.
        """
        left = self.flipped.percent(self.flipped.point)
        return left if left < max(most, MIN_DISTANCE_FROM_NOISE.value * self.open_percent) else None

    def off(self, point: LawPoint) -> dict[str, float]:
        """How many times each gain is what the law has, for those that are clearly off."""
        return {name: times for name, (times, clear) in self.times(point).items() if clear}

    def times(self, point: LawPoint) -> dict[str, tuple[float, bool]]:
        """How many times each gain is what the law has, to first order, and if it is clearly off.

        Of the gains that show in the control, and are told from the others that do.
        """
        return {
            name: (
                float(np.exp(min(step, _LARGEST))),
                abs(step) > max(MAX_SCALE_ERROR.value, MIN_DISTANCE_FROM_NOISE.value * deviation),
            )
            for name, (step, deviation) in self.steps(point).items()
        }

    def steps(self, point: LawPoint) -> dict[str, tuple[float, float]]:
        """Change of the logarithm of each such gain that least squares asks for; its deviation."""
        told, fit = self._asked(point, [*self.along.law.gains])
        if fit is None:
            return {}
        found = zip(fit.theta, np.sqrt(np.diag(self._scatter(fit, point))), strict=True)
        return {name: (float(s), float(d)) for name, (s, d) in zip(told, found, strict=True)}

    def covariance(self, names: Sequence[str]) -> Array:
        """Of the logarithms of gains that the control asks for, others being right, (k, k).

        Infinite variances of those that do not show in it apart from the others.
        """
        told, fit = self._asked(self.point, names, vague=True)
        found = np.diag(np.full(len(names), np.inf))
        if fit is not None:
            places = [names.index(name) for name in told]
            found[np.ix_(places, places)] = self._scatter(fit, self.point)
        return found

    def _asked(
        self, point: LawPoint, names: Sequence[str], *, vague: bool = False
    ) -> tuple[list[str], Solution | None]:
        """Gains among some that the control tells, vague ones too if asked, and their fit."""
        free = [[*self.along.law.gains].index(name) for name in names]
        both = np.column_stack([self._by_gain(point), self._off(point)])
        both = self._besides_start(point, both)
        columns, left = both[:, :-1], both[:, -1]
        shown = columns if vague else np.where(self._vague(point, columns), 0.0, columns)
        size = float(np.linalg.norm(self.compared(self.along.control)))
        told = [free[j] for j in _told_apart(shown[:, free], size)]
        every = [*self.along.law.gains]
        named = [every[i] for i in told]
        if not told:
            return named, None
        return named, least_squares(
            left, factor(columns[:, told], named, neighbours=self.neighbours)
        )

    def _scatter(self, fit: Solution, point: LawPoint) -> Array:
        """Covariance of a fit to what the law leaves, with what the log rounds."""
        matrix = Hac(min(LAGS, len(fit.residuals) // 4)).matrix(fit)
        if open_ := self.left_open(point):
            moved = [fit.influence.T @ each for each in open_]
            matrix = matrix + np.mean([np.outer(m, m) for m in moved], axis=0)
        return np.asarray(matrix)

    def least_change(self) -> "tuple[GainChange, ...]":
        """The changes of fewest gains after which none is off; the best where none are enough.

        Several where other single gains explain the control as well.
        """
        free, best = tuple[int, ...](), self._changed(())
        while len(free) < len(self.along.law.gains):
            further = [i for i in range(len(self.along.law.gains)) if i not in free]
            tried = [self._changed((*free, i)) for i in further]
            best = min(tried, key=lambda change: change.percent)
            if not self.off(best.point):
                most = _MAX_SAME_RESIDUAL * best.percent
                alike = [c for c in tried if c.percent <= most and not self.off(c.point)]
                return (best,) if free else tuple(sorted(alike, key=lambda c: c.percent))
            free = best.free
        return (best,)

    def _changed(self, free: tuple[int, ...]) -> "GainChange":
        point = self.along.fitted(self.point, self.compared, free)
        times = point.gains / np.where(self.point.gains == 0, 1.0, self.point.gains)
        names = [*self.along.law.gains]
        return GainChange(
            free=free,
            point=point,
            times={names[i]: float(times[i]) for i in free},
            percent=self.percent(point),
        )

    def _vague(self, point: LawPoint, columns: Array) -> NDArray[np.bool_]:
        """Which gains show by what the log rounds more than a little, (g,): theirs would be low."""
        if not self.rounded:
            return np.zeros(columns.shape[1], dtype=bool)
        rough = self.rounded[0].slopes_by_gain(point) - self.along.slopes_by_gain(point)
        noise = np.linalg.norm(np.column_stack([*map(self.compared, rough.T)]), axis=0)
        return np.asarray(noise > MAX_ROUNDED_SHARE.value * np.linalg.norm(columns, axis=0))

    def _by_gain(self, point: LawPoint) -> Array:
        """How what is compared changes with the logarithm of each gain, (n, g)."""
        return np.column_stack([*map(self.compared, self.along.slopes_by_gain(point).T)])

    def _off(self, point: LawPoint) -> Array:
        return self.compared(self.along.control) - self.compared(self.along.output(point))

    def _besides_start(self, point: LawPoint, columns: Array) -> Array:
        """Columns without what another start of the memory explains."""
        by_start = self.along.slopes_by_start(point)
        starts = np.column_stack([np.empty((len(columns), 0)), *map(self.compared, by_start.T)])
        shown = starts[:, np.any(starts != 0, axis=0)]
        if not shown.shape[1]:
            return columns
        basis, triangle = np.linalg.qr(shown / np.linalg.norm(shown, axis=0))
        turned, effect, _ = np.linalg.svd(triangle)
        basis = basis @ turned[:, effect > _MIN_GAIN_TOLD_APART * effect.max()]
        return np.asarray(columns - basis @ (basis.T @ columns))


@dataclass(frozen=True, slots=True, kw_only=True)
class GainChange:
    """Gains that are others than declared.

    Attributes
    ----------
    free : tuple of int
        Which may change.
    point : LawPoint
        With what they are.
    times : mapping of str to float
        How many times the declared one each is.
    percent : float
        What the law leaves of the control then, percent of it.
    """

    free: tuple[int, ...]
    point: LawPoint
    times: Mapping[str, float]
    percent: float

    def said(self, law: ControlLaw) -> str:
        """In words: ``kp is 1.1 times the declared one, 44 for 40``."""
        return " and ".join(
            f"{name} is {value:.4g} times the declared one, {value * law.gains[name]:.5g} for "
            f"{law.gains[name]:.5g}"
            for name, value in self.times.items()
        )


def said_of_gains(beside: GainsBeside, start: str) -> tuple[str, GainChange | None]:
    """The least change of gains that explains the control, in words, and that change."""
    law = beside.along.law
    changes = beside.least_change() if law.gains else ()
    best = changes[0] if changes else None
    if best is None or best.percent > MAX_LAW_RESIDUAL.value or beside.off(best.point):
        return (
            f"{start}no change of its gains explains it; check how it forms the velocity, its "
            f"filters, its limits and anti-windup, the period and the noise; {WHICH_LAW}",
            None,
        )
    ways = "; or ".join(change.said(law) for change in changes)
    several = len(changes) > 1
    these = "that" if len(best.times) == 1 else "these"
    rest = (
        "the record does not tell which"
        if several
        else f"and every other gain is right; declare {these}"
        if len(law.gains) > len(best.times)
        else f"declare {these}"
    )
    return f"{start}{ways}, {rest}", best


def _told_apart(columns: Array, size: float) -> list[int]:
    """Columns of gains that show in the control, and are told from the others that do."""
    sizes = np.linalg.norm(columns, axis=0)
    shown = np.flatnonzero(np.isfinite(sizes) & (sizes > _MIN_GAIN_TOLD_APART * size))
    if not len(shown):
        return []
    _, weights, order = qr(columns[:, shown] / sizes[shown], mode="economic", pivoting=True)
    clear = np.abs(np.diag(weights)) > _MIN_GAIN_TOLD_APART
    return sorted(int(shown[i]) for i in order[: len(clear)][clear])


def _rounded(along: LawAlong, record: Record) -> Iterator[LawAlong]:
    """The law along what position and reference may have been before the log rounded them."""
    steps = [quantum_of(values) for values in (record.position, np.asarray(record.reference))]
    if not any(steps):
        return
    rng, read = np.random.default_rng(0), (along.ticks.position, along.ticks.reference)
    for _ in range(_DRAWS):
        position, reference = (
            values + step * rng.uniform(-0.5, 0.5, len(values))
            for step, values in zip(steps, read, strict=True)
        )
        yield replace(along, ticks=replace(along.ticks, position=position, reference=reference))
