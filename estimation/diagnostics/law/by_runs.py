"""A law that is no sum of products of its gains against the recorded control.

Limited, filtered, adaptive, with an integral: no factor of a column says what a gain does. The law
is run along the record instead, with its gains a little off, and the slopes of its control by each
gain tell which gains are off; the least change of them that explains the control is found by runs
with the changed gains.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import first_case
from axisid.estimation.loops import LawAlong, LawPoint
from axisid.estimation.records import Record, quantisation_step
from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import (
    MAX_LAW_RESIDUAL,
    MAX_ROUNDED_SHARE,
    MAX_SCALE_ERROR,
    MIN_DISTANCE_FROM_NOISE,
)
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent

from .sentences import off_text, scale_text
from .terms import compared_as, hac_fit, noisy_ticks

# of a control, and of what other gains do not change of it; less tells nothing of a gain
_MIN_GAIN_TOLD_APART = 1e-4
# residual with one gain changed, by that with another; up to it, either may be wrong
_MAX_SAME_RESIDUAL = 1.1

# what a law leaves of the control by what the log leaves open, up to which it may be right: of
# right laws behind logs that round to 1 to 20 um it is 0.6 to 1.1 times that
MOST_OPEN = MIN_DISTANCE_FROM_NOISE.value
_DRAWS = 3  # of what the log's last digit leaves open
_LARGEST = 5.0  # logarithm of a change that is told to first order


@dataclass(frozen=True, kw_only=True, eq=False)
class LawByGains:
    """A law beside the recorded control, by its gains.

    Attributes
    ----------
    along : LawAlong
        The law.
    point : LawPoint
        Its declared gains, and the memory that the record's first controls show.
    compared : callable
        What is made of a control before it is compared.
    neighbours : RowTimes
        Of the rows that are compared.
    rounded : tuple of LawAlong
        The law along what may have been before the log rounded it, drawn at random; none where it
        rounds nothing.
    free : tuple of str
        Gains that have other values than the declared ones.
    """

    along: LawAlong
    point: LawPoint
    compared: Callable[[Array], Array]
    neighbours: RowTimes
    rounded: tuple[LawAlong, ...] = ()
    free: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        axis: GeneratedAxis,
        law: ControlLaw,
        record: Record,
        used: NDArray[np.bool_],
    ) -> "LawByGains":
        """A law beside a record of one piece, with a reference and a control.

        Parameters
        ----------
        axis : GeneratedAxis
            Under that law.
        law : ControlLaw
        record : Record
        used : (N,) array of bool
            Samples that are compared.
        """
        smooth = compared_as(law, record)
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
            neighbours=RowTimes(np.flatnonzero(used)),
            rounded=tuple(_rounded(along, record)),
        )

    @property
    def gains(self) -> dict[str, float]:
        """By name, at the point."""
        return dict(zip(self.along.law.gains, map(float, self.point.gains), strict=True))

    @property
    def times(self) -> dict[str, float]:
        """How many times the declared one each gain is that has another value."""
        declared, gains = self.along.law.gains, self.gains
        return {name: gains[name] / (declared[name] or 1.0) for name in self.free}

    def best(self, names: Sequence[str]) -> "LawByGains":
        """The same with the values of such gains that give the recorded control best."""
        every = [*self.along.law.gains]
        free = [every.index(name) for name in names]
        point = self.along.fitted(self.point, self.compared, free)
        return replace(self, point=point, free=tuple(names))

    def of_control(self, times: float) -> "LawByGains":
        """The same beside a control of which the recorded one is so many times."""
        along = replace(self.along, control=self.along.control / times)
        return replace(self, along=along, point=along.fitted(along.declared, self.compared, ()))

    @cached_property
    def scale(self) -> "tuple[float, LawByGains] | None":
        """How many times the law's the recorded control is, where that explains it by any gains.

        With the law beside the control without it; -1 for one of the other sign.
        """
        every = map(self.compared, (self.along.output(self.point), self.along.control))
        output, control = self._besides_start(np.column_stack([*every])).T
        power = float(output @ output)
        times = float(output @ control) / power if power > 0 else 0.0
        if not np.isfinite(times) or times == 0 or abs(times - 1) < MAX_SCALE_ERROR.value:
            return None
        times = times if times > 0 else -1.0
        scaled = self.of_control(times)
        # What the log rounds is open besides.
        most = max(MAX_LAW_RESIDUAL.value, MOST_OPEN * self.open_percent)
        explains = scaled.percent < most and (times < 0 or not scaled.off)
        return (times, scaled) if explains else None

    def unless_rounded(self) -> "LawByGains":
        """The same without a rounding that the record refutes.

        A reference that its maker computes in whole steps looks like one that the log rounded, and
        the law reads the steps of an encoder as they are. Such steps would leave of the control, by
        any gains, what they do, which jumps from sample to sample as no other fault does.
        """
        for each in (self, self.best([*self.along.law.gains])):
            sizes = [np.linalg.norm(np.diff(off)) for off in each.left_open]
            jumps = np.linalg.norm(np.diff(each.left))
            if jumps < max(sizes, default=0.0) / MIN_DISTANCE_FROM_NOISE.value:
                return replace(self, rounded=())
        return self

    @cached_property
    def left_open(self) -> list[Array]:
        """By how much the output may differ for what is rounded, drawn at random, (n,) each."""
        undisturbed = self.along.output(self.point)
        return [self.compared(each.output(self.point) - undisturbed) for each in self.rounded]

    @property
    def open_percent(self) -> float:
        """How far the control of a right law may be off for it, percent of the control."""
        control = self.compared(self.along.control)
        off = (relative_error_percent(each, control) for each in self.left_open)
        return max(off, default=0.0)

    @cached_property
    def left(self) -> Array:
        """What the law leaves of the control, but for another start of its memory, (n,)."""
        return self._besides_start(self._off[:, None])[:, 0]

    @property
    def percent(self) -> float:
        """The same in percent of the control."""
        return relative_error_percent(self.left, self.compared(self.along.control))

    @cached_property
    def asked(self) -> dict[str, tuple[float, bool]]:
        """How many times each gain should be what it is, to first order, and if it is clearly off.

        Of the gains that show in the control, and are told from the others that do.
        """
        return {
            name: (
                float(np.exp(min(step, _LARGEST))),
                abs(step) > max(MAX_SCALE_ERROR.value, MIN_DISTANCE_FROM_NOISE.value * deviation),
            )
            for name, (step, deviation) in self.steps.items()
        }

    @property
    def off(self) -> list[str]:
        """Gains that are clearly off."""
        return [name for name, (_, clear) in self.asked.items() if clear]

    @property
    def steps(self) -> dict[str, tuple[float, float]]:
        """Change of the logarithm of each such gain that least squares asks for; its deviation."""
        told, steps, scatter = self._asked([*self.along.law.gains])
        found = zip(steps, np.sqrt(np.diag(scatter)), strict=True)
        return {name: (float(s), float(d)) for name, (s, d) in zip(told, found, strict=True)}

    def covariance(self, names: Sequence[str]) -> Array:
        """Of the logarithms of gains that the control asks for, others being right, (k, k).

        Infinite variances of those that do not show in it apart from the others.
        """
        told, _, scatter = self._asked(names, vague=True)
        found, places = np.diag(np.full(len(names), np.inf)), [names.index(name) for name in told]
        found[np.ix_(places, places)] = scatter
        return found

    def _asked(
        self, names: Sequence[str], *, vague: bool = False
    ) -> tuple[list[str], Array, Array]:
        """Gains among some that the control tells, vague ones too if asked; steps, covariance.

        Vague is a gain that shows by what the log rounds more than a little: it would be found too
        low. What the log rounds is in the covariance.
        """
        every = [*self.along.law.gains]
        free = [every.index(name) for name in names]
        slopes = self.along.slopes_by_gain(self.point)
        both = np.column_stack([*map(self.compared, slopes.T), self._off])
        both = self._besides_start(both)
        columns, left = both[:, :-1], both[:, -1]
        shown = columns
        if self.rounded and not vague:
            rough = self.rounded[0].slopes_by_gain(self.point) - slopes
            noise = np.linalg.norm(np.column_stack([*map(self.compared, rough.T)]), axis=0)
            most = MAX_ROUNDED_SHARE.value * np.linalg.norm(columns, axis=0)
            shown = np.where(noise > most, 0.0, columns)
        size = float(np.linalg.norm(self.compared(self.along.control)))
        told = [free[j] for j in _told_apart(shown[:, free], size)]
        named = [every[i] for i in told]
        if not told:
            return named, np.zeros(0), np.zeros((0, 0))
        fit, scatter = hac_fit(left, columns[:, told], named, self.neighbours)
        if self.left_open:
            moved = [fit.influence.T @ each for each in self.left_open]
            scatter = scatter + np.mean([np.outer(m, m) for m in moved], axis=0)
        return named, fit.theta, scatter

    def least_change(self) -> "tuple[LawByGains, ...]":
        """The same with the fewest other gains with which none is off; the best if none is enough.

        Several where other single gains explain the control as well.
        """
        free, best = tuple[str, ...](), self
        while len(free) < len(self.along.law.gains):
            tried = [self.best((*free, name)) for name in self.along.law.gains if name not in free]
            best = min(tried, key=lambda each: each.percent)
            if not best.off:
                most = _MAX_SAME_RESIDUAL * best.percent
                alike = [each for each in tried if each.percent <= most and not each.off]
                return (best,) if free else tuple(sorted(alike, key=lambda each: each.percent))
            free = best.free
        return (best,)

    @cached_property
    def _off(self) -> Array:
        return self.compared(self.along.control) - self.compared(self.along.output(self.point))

    def _besides_start(self, columns: Array) -> Array:
        """Columns without what another start of the memory explains."""
        by_start = self.along.slopes_by_start(self.point)
        starts = np.column_stack([np.empty((len(columns), 0)), *map(self.compared, by_start.T)])
        shown = starts[:, np.any(starts != 0, axis=0)]
        if not shown.shape[1]:
            return columns
        basis, triangle = np.linalg.qr(shown / np.linalg.norm(shown, axis=0))
        turned, effect, _ = np.linalg.svd(triangle)
        basis = basis @ turned[:, effect > _MIN_GAIN_TOLD_APART * effect.max()]
        return np.asarray(columns - basis @ (basis.T @ columns))


def said_of_gains(by_gains: LawByGains) -> tuple[str, LawByGains | None]:
    """The least change of gains that explains the control, in words, and the law with it.

    A control that is recorded with another scale is what such a gain may make of it too.
    """
    declared, said = by_gains.along.law.gains, ""
    changes = by_gains.least_change() if declared else ()
    best = changes[0] if changes else None
    if best is not None and best.percent < MAX_LAW_RESIDUAL.value and not best.off:
        ways = "; or ".join(
            " and ".join(
                f"{name} is {times:.4g} times the declared one, {change.gains[name]:.5g} for "
                f"{declared[name]:.5g}"
                for name, times in change.times.items()
            )
            for change in changes
        )
        these = "that" if len(best.free) == 1 else "these"
        rest = first_case(
            (len(changes) > 1, "the record does not tell which"),
            (
                len(declared) > len(best.free),
                f"and every other gain is right; declare {these}",
            ),
            (True, f"declare {these}"),
        )
        said = f"{ways}, {rest}"
    else:
        best = None
    if by_gains.scale is not None:
        times, scaled = by_gains.scale
        other = scale_text(times, f", with which it would be {off_text(scaled.percent)}")
        said = (
            f"{said}; or {scale_text(times)}: the law alone does not tell which" if said else other
        )
    return said, best


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
    steps = [
        quantisation_step(values) for values in (record.position, np.asarray(record.reference))
    ]
    if not any(steps):
        return
    rng, read = np.random.default_rng(0), (along.ticks.position, along.ticks.reference)
    for _ in range(_DRAWS):
        position, reference = (
            values + step * rng.uniform(-0.5, 0.5, len(values))
            for step, values in zip(steps, read, strict=True)
        )
        yield replace(along, ticks=replace(along.ticks, position=position, reference=reference))
