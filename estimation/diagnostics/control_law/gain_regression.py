"""What a law leaves of the recorded control, regressed on the slopes by its gains.

No factor of a column says what a gain of a law does that is limited, filtered, adaptive, or has an
integral. The law is run along the record, with its gains a little off, and the slopes of its
control by each gain tell which gains are off; the least change of them that explains the control is
found by runs with the changed gains.

What the law read is not always in the log: it may round, or be slower than the law, whose positions
between the samples have a noise of their own. The law is run along what it may have read, drawn at
random, and what that changes of its control is left open.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.law_replay import (
    LAW_SETTLING,
    LIMIT,
    LawInputs,
    LawReplay,
    position_noise,
    two_clocks,
)
from axisid.estimation.records import Record, at_times, quantisation_step
from axisid.estimation.signals import RowTimes, as_logged, limit_in_log
from axisid.estimation.thresholds import (
    MAX_LAW_RESIDUAL,
    MAX_ROUNDED_SHARE,
    MAX_SCALE_ERROR,
    MIN_DISTANCE_FROM_NOISE,
    MIN_SAMPLES_PER_FACTOR,
)
from axisid.modeling.declaration import ControlLaw, gain
from axisid.support.arrays import Array, mask_of, relative_error_percent

from .control_residuals import (
    CONSTANT,
    DRIFT,
    INJECTED,
    MAX_FACTOR_ERROR,
    NO_GAINS,
    coloured_fit,
    comparison_filter,
    noisy_ticks,
    offset_and_drift,
    settling,
)

# of a control, and of what other gains do not change of it; less tells nothing of a gain
_MIN_GAIN_TOLD_APART = 1e-4
# residual with one gain changed, by that with another; up to it, either may be wrong
_MAX_SAME_RESIDUAL = 1.1

# what a law leaves of the control by what the log leaves open, up to which it may be right: of
# right laws behind logs that round to 1 to 20 um it is 0.6 to 1.1 times that
_MOST_OPEN = MIN_DISTANCE_FROM_NOISE.value
# constant, or half of a drift, beside the law, by the control's root mean square
_MAX_CONTROL_LEAN = 0.01
_SD_BY_MEDIAN = 1.4826  # standard deviation by the median of absolute ones, of normal noise
_DRAWS = 3  # of what the log leaves open
_COINCIDES = 1e-6  # of a sample
# of a constant, a drift or the law's control, less of which is apart from the start of a memory
_MIN_SHAPE_APART = 1e-3
# least deviation of a factor of a law that reads an ideal velocity, which is in no log: measured,
# up to 2.4e-4 off on twins without noise, 1e-5 to 1e-4 on whole ones
_FACTOR_BLUR = 1e-4


#: Names of what explains a control, beside the terms of the law.
GAINS, SCALE = "law's gains", "control's scale"
# What explains a control by itself, then with a constant beside it.
_KINDS = (
    (GAINS,),
    (SCALE,),
    (CONSTANT,),
    (CONSTANT, DRIFT),
    (GAINS, CONSTANT),
    (SCALE, CONSTANT),
    (GAINS, CONSTANT, DRIFT),
    (SCALE, CONSTANT, DRIFT),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation:
    """One way to explain how the recorded control differs from the declared law.

    Attributes
    ----------
    kind : tuple of str
        What differs: the law's gains, the scale of the control, a constant, a drift.
    values : mapping of str to float
        By how much, by term of the law (factor minus 1), and by `SCALE` (factor minus 1),
        `CONSTANT` and `DRIFT` over the record (in the unit of the control).
    deviations : mapping of str to float
        Of the values, each by itself.
    left_percent : float
        Residual with it, in percent of the recorded control.
    """

    kind: tuple[str, ...]
    values: Mapping[str, float]
    deviations: Mapping[str, float]
    left_percent: float

    @property
    def turns_a_sign(self) -> bool:
        """Whether a factor is zero or negative."""
        factors = (value for name, value in self.values.items() if name not in (CONSTANT, DRIFT))
        return min(factors, default=0.0) <= -1


def plausible(explanations: Sequence[Explanation], best: float) -> tuple[Explanation, ...]:
    """Explanations that the record cannot tell apart, without those that say more than they need.

    Parameters
    ----------
    explanations : sequence of Explanation
        The simple ones first.
    best : float
        Residual that any explanation reaches, in percent of the recorded control.
    """
    found: list[Explanation] = []
    for each in explanations:
        is_needless = any({*other.kind} <= {*each.kind} for other in found)
        if each.left_percent <= _MAX_SAME_RESIDUAL * best and not is_needless:
            found.append(each)
    return tuple(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class GainRegression:
    """A law beside the recorded control, and the regression of what it leaves on its gains.

    Attributes
    ----------
    along : LawReplay
        The law, with its declared gains, and the memory that the record's first controls show.
    declared : LawReplay
        With these gains too, and the memory of an axis at rest.
    compared : callable
        What is made of a control before it is compared.
    neighbours : RowTimes
        Of the rows that are compared.
    period : float
        Of the record, s.
    added : dict of str to (N,) array
        What is in the recorded control besides, by name: each may have another size. Of a law that
        is a sum of products of its gains, what none of them multiplies is the product ``1``.
    put_in : (N,) array of bool
        Samples of `along` whose control is the declared law's and not the recorded one; none is
        compared.
    possible : tuple of LawInputs
        What the law may have read, drawn at random; none where the log has that.
    between : bool
        Whether it reads between the samples of the log.
    free : tuple of str
        Gains that have other values than the declared ones.
    at_limit : dict of str to (float, float)
        How many times the drive's declared limit the control is where the law asks for more, and
        the deviation of that, by `LIMIT`; empty of a record that shows it in too few samples, or
        has a test signal.
    """

    along: LawReplay
    declared: LawReplay
    compared: Callable[[Array], Array]
    neighbours: RowTimes
    period: float
    added: Mapping[str, Array] = field(default_factory=dict)
    put_in: NDArray[np.bool_] | bool = False
    possible: tuple[LawInputs, ...] = ()
    between: bool = False
    free: tuple[str, ...] = ()
    at_limit: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        axis: GeneratedAxis,
        law: ControlLaw,
        record: Record,
        used: NDArray[np.bool_],
        limited: NDArray[np.bool_],
    ) -> "GainRegression":
        """A law beside a record of one piece, with a reference and a control.

        Parameters
        ----------
        axis : GeneratedAxis
            Under that law.
        law : ControlLaw
        record : Record
        used : (N,) array of bool
            Samples that are compared.
        limited : (N,) array of bool
            Samples whose control is not the law's, see `compared_with_law`.
        """
        smooth, (ticks, start) = comparison_filter(law, record), noisy_ticks(axis, record)
        declared = LawReplay.of(axis, law, ticks, record)
        along = replace(declared, start=start[: len(law.memory)])
        # A control that a converter's noise took from the limit is none that the law gave.
        limited = limited | (np.abs(along.output) > along.limit)
        used = used & ~limited
        # Clearly and mostly, as the law may read noise that the record does not have.
        noise = np.std((along.control - along.output)[used]) if used.any() else 0.0
        excess = np.abs(along.output) - along.limit
        asks_more = excess > MIN_DISTANCE_FROM_NOISE.value * noise
        unsettled = [(0, settling(law)), *((a, b + LAW_SETTLING) for a, b in record.masked)]
        asks_more &= ~mask_of(unsettled, len(record))
        shown = (np.sign(along.output) * record.control)[asks_more] / limit_in_log(axis)
        at_limit = {}
        # What is injected is at the limit along with the law.
        if len(shown) >= MIN_SAMPLES_PER_FACTOR.value and record.added_control is None:
            median = float(np.median(shown))
            deviation = _SD_BY_MEDIAN * float(np.median(np.abs(shown - median)))
            at_limit[LIMIT] = (median, deviation * (np.pi / 2 / len(shown)) ** 0.5)
        if law.takes_velocity:  # what the limit cut off would be spread far over the neighbours
            control = np.where(limited, along.output, along.control)
            declared, along = (replace(each, control=control) for each in (declared, along))
        added = {}
        if law.is_polynomial or not law.gains:
            added[NO_GAINS] = along.slope_by_rest
        if record.added_control is not None:
            added[INJECTED] = as_logged(axis, ticks.added_at_samples(law.delay))
        clocks = two_clocks(axis, record, (0, len(record)))
        times = np.arange(float(len(record))) if clocks is None else clocks.times
        between = not np.allclose(times, np.round(times), rtol=0, atol=_COINCIDES)
        return cls(
            along=along,
            declared=declared,
            compared=lambda control: np.asarray(smooth(control)[used]),
            neighbours=RowTimes(np.flatnonzero(used)),
            period=record.period,
            added=added,
            put_in=limited,
            possible=tuple(_possible(ticks, record, times if between else None)),
            between=between,
            at_limit=at_limit,
            # With noise the first controls show what is remembered less well than all of them do.
        ).best(())

    @property
    def gains(self) -> dict[str, float]:
        """That the law is run with, by name."""
        return dict(zip(self.along.law.gains, map(float, self.along.gains), strict=True))

    @property
    def times(self) -> dict[str, float]:
        """How many times the declared one each gain is that has another value."""
        declared, gains = self.along.law.gains, self.gains
        return {name: gains[name] / (declared[name] or 1.0) for name in self.free}

    def best(self, names: Sequence[str]) -> "GainRegression":
        """The same with the values of such gains that give the recorded control best."""
        free = [[*self.along.law.gains].index(name) for name in names]
        return replace(self, along=self.along.fitted(self.compared, free), free=tuple(names))

    def of_control(self, times: float) -> "GainRegression":
        """The same beside a control of which the recorded one is so many times."""
        control = np.where(self.put_in, self.along.control, self.along.control / times)
        along = replace(self.declared, control=control)
        return replace(self, along=along, at_limit={}).best(())

    @cached_property
    def control(self) -> Array:
        """The recorded control as it is compared, (n,)."""
        return self.compared(self.along.control)

    @cached_property
    def output(self) -> Array:
        """The law's, as it is compared, (n,)."""
        return self.compared(self.along.output)

    @cached_property
    def scale(self) -> "tuple[float, GainRegression] | None":
        """How many times the law's the recorded control is, where that explains it by any gains.

        With the law beside the control without it; -1 for one of the other sign.
        """
        output, control = self._besides_start(np.column_stack([self.output, self.control])).T
        power = float(output @ output)
        times = float(output @ control) / power if power > 0 else 0.0
        if not np.isfinite(times) or times == 0 or abs(times - 1) < MAX_SCALE_ERROR.value:
            return None
        times = times if times > 0 else -1.0
        scaled = self.of_control(times)
        if times < 0:  # of a fit's gains, or the declared ones
            scaled = scaled.best([*self.along.law.gains])
        # What the log rounds is open besides.
        allowed = max(MAX_LAW_RESIDUAL.value, _MOST_OPEN * self.open_percent)
        return (
            (times, scaled) if scaled.percent < allowed and (times < 0 or not scaled.off) else None
        )

    def unless_rounded(self) -> "GainRegression":
        """The same without a rounding that the record refutes.

        A reference that its maker computes in whole steps looks like one that the log rounded, and
        the law reads the steps of an encoder as they are. Such steps would leave of the control, by
        any gains, what they do, which jumps from sample to sample as no other fault does. Of a law
        that runs between the samples of the log, the log has none of the steps that the law read.
        """
        if _is_slower(self.along.ticks):
            return self
        for each in (self, self.best([*self.along.law.gains])):
            sizes = [np.linalg.norm(np.diff(off)) for off in each.left_open]
            if np.linalg.norm(np.diff(each.residuals)) < (
                max(sizes, default=0.0) / MIN_DISTANCE_FROM_NOISE.value
            ):
                return replace(self, possible=(), between=False)
        return self

    @property
    def is_hidden(self) -> bool:
        """Whether what the log leaves open hides whether the law is right."""
        return MAX_LAW_RESIDUAL.value <= self.percent < _MOST_OPEN * self.open_percent

    @cached_property
    def left_open(self) -> list[Array]:
        """By how much the output may differ for what the log leaves open, (n,) each."""
        outputs = (replace(self.along, ticks=each).output for each in self.possible)
        return [self.compared(each) - self.output for each in outputs]

    @property
    def open_percent(self) -> float:
        """How far the control of a right law may be off for it, percent of the control."""
        return max((relative_error_percent(e, self.control) for e in self.left_open), default=0.0)

    @cached_property
    def residuals(self) -> Array:
        """What the law leaves of the control, but for another start of its memory, (n,)."""
        return self._besides_start((self.control - self.output)[:, None])[:, 0]

    @property
    def percent(self) -> float:
        """The same in percent of the control."""
        return relative_error_percent(self.residuals, self.control)

    @cached_property
    def lean(self) -> dict[str, float]:
        """A constant and a drift over the record that stand out of what is left, by name."""
        rows = self.neighbours, self.period
        values, deviations = offset_and_drift(self.residuals, *rows)
        least = _MAX_CONTROL_LEAN * np.sqrt(np.mean(self.control**2)) * np.array([1.0, 2.0])
        # How large either may be for what the log does not write.
        left_open = [offset_and_drift(each, *rows)[0] for each in self.left_open]
        chance = np.abs([deviations, *left_open]).max(axis=0)
        far = np.abs(values) > np.maximum(least, MIN_DISTANCE_FROM_NOISE.value * chance)
        named = zip((CONSTANT, DRIFT), values, far, strict=True)
        return {name: float(value) for name, value, is_far in named if is_far}

    @cached_property
    def gain_steps(self) -> tuple[dict[str, float], Array, Array]:
        """Changes of gains that least squares asks for, their covariance, and what they leave.

        Of the logarithms of gains that show in the control, and are told from the others that do;
        and of what was added, by itself. What is left is (n,), to first order.
        """
        return self._gain_steps(self._names)

    @cached_property
    def off(self) -> list[str]:
        """Gains, and what was added, that are clearly off."""
        steps, covariance, _ = self.gain_steps
        far = MIN_DISTANCE_FROM_NOISE.value * np.sqrt(np.diag(covariance))
        allowed = dict(zip(steps, np.maximum(MAX_SCALE_ERROR.value, far), strict=True))
        if self.along.law.takes_velocity and INJECTED in allowed:
            # The velocity that is compared is not the sensor's to a hundredth.
            allowed[INJECTED] = max(allowed[INJECTED], MAX_FACTOR_ERROR)
        return [name for name, step in steps.items() if abs(step) > allowed[name]]

    @property
    def gains_off(self) -> list[str]:
        """Those of them that another value of a gain mends."""
        return [name for name in self.off if name in self.along.law.gains]

    @property
    def factors(self) -> dict[str, tuple[float, float]]:
        """How many times itself each term of the law should be, to first order; its deviation.

        And the drive's limit where the record shows it.
        By product of gains; by gain of a law that is no sum of such products.
        """
        steps, covariance, _ = self.gain_steps
        blur = _FACTOR_BLUR * self.along.law.takes_velocity  # of what is in no log
        factors = {}
        for term, of in self._weights_of_steps.items():
            deviation = float(np.hypot(np.sqrt(of @ covariance @ of), blur))
            factors[term] = (float(1 + of @ [*steps.values()]), deviation)
        return {**factors, **self.at_limit}

    @cached_property
    def _weights_of_steps(self) -> dict[str, Array]:
        """Logarithm of the factor of each term by the steps of the gains, (k,), where it shows."""
        steps, names, columns = self.gain_steps[0], self._names, self._columns
        # Of gains that show in one product alone the step of one is that of the product.
        told = columns[:, [names.index(name) for name in steps]]
        shares = np.linalg.lstsq(told, columns, rcond=None)[0]
        apart = np.linalg.norm(columns - told @ shares, axis=0)
        shares[:, apart > _MIN_GAIN_TOLD_APART * np.linalg.norm(columns, axis=0)] = 0.0
        weights = {}
        for term, powers in self.powers.items():
            of = np.array([powers.get(each, 0.0) for each in steps])
            shown = of @ shares[:, [names.index(each) for each in powers]]
            if np.allclose(shown, [*powers.values()], rtol=MAX_SCALE_ERROR.value):
                weights[term] = of
        return weights

    @cached_property
    def explanations(self) -> tuple[Explanation, ...]:
        """Ways to explain how the recorded control differs from the law's, the simple ones first.

        By least squares, to first order in the gains.
        """
        steps = self.gain_steps[0]
        time = self.neighbours.places - self.neighbours.places.mean()
        time = time / np.ptp(time)
        shapes = np.column_stack([self.output, np.ones(len(time)), time])
        # What the start of a memory explains as well is no explanation of its own.
        apart = self._besides_start(shapes)
        shown = np.linalg.norm(apart, axis=0) > _MIN_SHAPE_APART * np.linalg.norm(shapes, axis=0)
        blocks = {
            name: apart[:, [i]] for i, name in enumerate((SCALE, CONSTANT, DRIFT)) if shown[i]
        }
        if steps:
            blocks[GAINS] = self._columns[:, [self._names.index(name) for name in steps]]
        blur = _FACTOR_BLUR * self.along.law.takes_velocity
        size = float(np.sqrt(np.mean(self.control**2)))
        largest = {SCALE: 1.0, CONSTANT: size, DRIFT: 2 * size}
        deviations = {name: sd for name, (_, sd) in self.factors.items()}
        for name, block in blocks.items():
            if name != GAINS:
                of = self._deviation_of(block, name)
                deviations[name] = float(np.hypot(of, blur * largest[name]))
        found = []
        for kind in _KINDS:
            if not {*kind} <= {*blocks}:
                continue
            columns = np.hstack([blocks[name] for name in kind])
            sizes = np.linalg.norm(columns, axis=0)
            by_size = np.linalg.lstsq(columns / sizes, self.residuals, rcond=_MIN_GAIN_TOLD_APART)[
                0
            ]
            left = self.residuals - columns / sizes @ by_size
            theta = dict(zip(_names_of(kind, steps), by_size / sizes, strict=True))
            values = {name: float(theta[name]) for name in kind if name != GAINS}
            if GAINS in kind:
                told = np.array([theta[name] for name in steps])
                values |= {t: float(of @ told) for t, of in self._weights_of_steps.items()}
                values |= {name: factor - 1 for name, (factor, _) in self.at_limit.items()}
            percent = relative_error_percent(left, self.control)
            found.append(
                Explanation(
                    kind=kind,
                    values=values,
                    deviations={name: deviations[name] for name in values},
                    left_percent=percent,
                )
            )
        return tuple(found)

    def _deviation_of(self, column: Array, name: str) -> float:
        """Deviation of the factor of a column (n, 1), with what the log leaves open."""
        fit, covariance = coloured_fit(
            self.residuals, column, (name,), self.neighbours, self.period
        )
        moved = [float((fit.influence.T @ each)[0]) for each in self.left_open]
        return float(np.sqrt(covariance[0, 0] + np.mean(np.square([*moved, 0.0]))))

    @property
    def powers(self) -> dict[str, dict[str, float]]:
        """Powers of the gains, and of what was added, in each term of the law, by name."""
        law, alone = self.along.law, {name: {name: 1.0} for name in self.added}
        products = (
            [product for product, _ in law.terms if product.free_symbols]
            if law.is_polynomial
            else [gain(name) for name in law.gains]
        )
        return {
            str(each): {
                str(g): float(n) for g, n in each.as_powers_dict().items() if g.free_symbols
            }
            for each in products
        } | alone

    @property
    def _names(self) -> list[str]:
        """Names of the gains, and of what was added."""
        return [*self.along.law.gains, *self.added]

    @cached_property
    def _slopes(self) -> Array:
        """Of the output by each gain, (N, g)."""
        return self.along.jacobian_by_gain()

    @cached_property
    def _columns(self) -> Array:
        """Slopes of what is compared by each gain and what was added, (n, k)."""
        every = map(self.compared, (*self._slopes.T, *self.added.values()))
        return self._besides_start(np.column_stack([*every]))

    def covariance(self, names: Sequence[str]) -> Array:
        """Of the logarithms of gains that the control asks for, others being right, (k, k).

        Infinite variances of those that do not show in it apart from the others.
        """
        steps, told, _ = self._gain_steps(names, vague=True)
        covariance = np.diag(np.full(len(names), np.inf))
        covariance[np.ix_(*[[names.index(name) for name in steps]] * 2)] = told
        return covariance

    def _gain_steps(
        self, names: Sequence[str], *, vague: bool = False
    ) -> tuple[dict[str, float], Array, Array]:
        """The same of some, and of vague ones if asked.

        Vague is a gain that shows by what the log leaves open more than a little: it would be found
        too low. What the log leaves open is in the covariance.
        """
        free, columns = [self._names.index(name) for name in names], self._columns
        shown = columns
        if self.possible and not vague:
            rough = replace(self.along, ticks=self.possible[0]).jacobian_by_gain() - self._slopes
            noise = np.zeros(len(columns.T))
            noise[: len(rough.T)] = [np.linalg.norm(self.compared(each)) for each in rough.T]
            least = MAX_ROUNDED_SHARE.value * np.linalg.norm(columns, axis=0)
            shown = np.where(noise > least, 0.0, columns)
        told = [free[j] for j in _told_apart(shown[:, free], float(np.linalg.norm(self.control)))]
        if not told:
            return {}, np.zeros((0, 0)), self.residuals
        named = [self._names[i] for i in told]
        fit, covariance = coloured_fit(
            self.residuals, columns[:, told], named, self.neighbours, self.period
        )
        if self.left_open:
            moved = np.array([fit.influence.T @ each for each in self.left_open])
            covariance = covariance + moved.T @ moved / len(moved)
        return dict(zip(named, map(float, fit.theta), strict=True)), covariance, fit.residuals

    def least_change(self) -> "tuple[GainRegression, ...]":
        """The same with the fewest other gains with which none is off; the best if none is enough.

        Several where other single gains explain the control as well.
        """
        free, best = tuple[str, ...](), self
        while len(free) < len(self.along.law.gains):
            tried = [self.best((*free, name)) for name in self.along.law.gains if name not in free]
            best = min(tried, key=lambda each: each.percent)
            if not best.gains_off:
                most = _MAX_SAME_RESIDUAL * best.percent
                alike = [each for each in tried if each.percent <= most and not each.gains_off]
                return (best,) if free else tuple(sorted(alike, key=lambda each: each.percent))
            free = best.free
        return (best,)

    @cached_property
    def _besides_start(self) -> Callable[[Array], Array]:
        """What takes from columns, (n, k), all that another start of the memory explains."""
        by_start = self.along.slopes_by_start(self.compared)
        starts = np.column_stack([np.empty((len(self.control), 0)), *by_start])
        sizes = np.linalg.norm(starts, axis=0)
        unit = starts[:, sizes > 0] / sizes[sizes > 0]
        return lambda columns: np.asarray(
            columns - unit @ np.linalg.lstsq(unit, columns, rcond=_MIN_GAIN_TOLD_APART)[0]
        )


def _names_of(kind: Sequence[str], gains: Iterable[str]) -> list[str]:
    """Names of the columns of an explanation, those of gains among them."""
    names: list[str] = []
    for each in kind:
        names += [*gains] if each == GAINS else [each]
    return names


def _told_apart(columns: Array, size: float) -> list[int]:
    """Columns of gains that show in the control, and are told from the others that do."""
    sizes = np.linalg.norm(columns, axis=0)
    shown = np.flatnonzero(np.isfinite(sizes) & (sizes > _MIN_GAIN_TOLD_APART * size))
    if not len(shown):
        return []
    _, weights, order = qr(columns[:, shown] / sizes[shown], mode="economic", pivoting=True)
    clear = np.abs(np.diag(weights)) > _MIN_GAIN_TOLD_APART
    return sorted(int(shown[i]) for i in order[: len(clear)][clear])


def _is_slower(ticks: LawInputs) -> bool:
    """Whether the log is slower than the law, so that the law runs between its samples."""
    return len(ticks) > len(ticks.held)


def _possible(ticks: LawInputs, record: Record, times: Array | None) -> Iterator[LawInputs]:
    """What a law may have read, at its own times, (M,) samples, if those of none are.

    Position and reference as they may have been before the log rounded them, or as an encoder
    rounded them between the samples of a slow log. Without steps, the noise of the position between
    the samples was another one, and a cubic spline misses what is faster than they: by how much,
    one of every second sample tells.
    """
    position, reference = ticks.position, ticks.reference
    steps = [
        quantisation_step(values) for values in (record.position, np.asarray(record.reference))
    ]
    noise = 0.0
    if times is not None and not (steps[0] and _is_slower(ticks)):
        noise, some = position_noise(record.position), record.position[::2]
        position = at_times(times / 2, np.arange(float(len(some))), some, "spline")
    elif not any(steps):
        return
    rng = np.random.default_rng(0)
    for _ in range(_DRAWS):
        places, wanted = (
            values + step * rng.uniform(-0.5, 0.5, len(values))
            for step, values in zip(steps, (position, reference), strict=True)
        )
        places = places + noise * rng.normal(size=len(places))
        yield replace(ticks, position=places, reference=wanted)
