"""Regression of the residual of the recorded control on the derivatives of the law by its gains.

The residual is the recorded control minus the control that the law computes from the recorded
signals.

The effect of a gain is not the factor of a column where the law is limited, filtered or adaptive,
or has an integral. The law is therefore run along the record with slightly changed gains. The
derivatives of its control by the gains show which gains are wrong. The smallest change of gains
that explains the control is found by runs with the changed gains.

The values that the law read are not always in the log: the log may be rounded, or slower than the
law, whose positions between the samples have noise of their own. The law is therefore also run
along values that it may have read, drawn at random. The change of its control is its uncertainty
by the log.
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
    coloured_covariance,
    coloured_fit,
    comparison_filter,
    noisy_ticks,
    offset_and_drift,
    settling,
)

# least effect of a gain relative to the control, and least part of this effect that other gains do
# not explain, for a gain that the record identifies
_MIN_DISTINCT_EFFECT = 1e-4
# residual with one gain changed, relative to that with another, up to which either may be wrong
_MAX_SAME_RESIDUAL = 1.1

# residual of a law relative to the uncertainty of its control by the log, up to which the law may
# be correct: the ratio is 0.6 to 1.1 for correct laws with logs that are rounded to 1 to 20 um
_MAX_UNCERTAINTY_RATIO = MIN_DISTANCE_FROM_NOISE.value
# constant, or half of a drift, next to the law, relative to the rms of the control
_MAX_CONTROL_LEAN = 0.01
_SD_BY_MEDIAN = 1.4826  # standard deviation relative to the median absolute value of normal noise
_DRAWS = 3  # of values that the law may have read
_COINCIDES = 1e-6  # difference of times in samples, up to which they are the same
# least part of a constant, a drift or the law's control that the initial state of the law does not
# explain, for an explanation that is tried
_MIN_DISTINCT_SHAPE = 1e-3
# least standard error of a factor of a law that reads an ideal velocity, which no log contains:
# measured errors are up to 2.4e-4 on twins without noise, and 1e-5 to 1e-4 on twins with noise
_FACTOR_BLUR = 1e-4


#: Names of explanations of a control, in addition to `CONSTANT` and `DRIFT`.
GAINS, SCALE = "law's gains", "control's scale"
# Single explanations of a control, then those with a constant added.
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
    """One explanation of the difference between the recorded control and the declared law.

    Attributes
    ----------
    kind : tuple of str
        Names of what differs, of `GAINS`, `SCALE`, `CONSTANT` and `DRIFT`: the law's gains, the
        scale of the control, a constant or a drift.
    values : mapping of str to float
        Sizes of the differences. For gains: the factor of each term of the law minus 1, by term.
        For `SCALE`: the factor minus 1. For `CONSTANT`, and for `DRIFT` (the change over the
        record): in the unit of the control.
    deviations : mapping of str to float
        Standard errors of the values; each is that of a separate estimate.
    left_percent : float
        Residual with this explanation, in percent of the recorded control.
    """

    kind: tuple[str, ...]
    values: Mapping[str, float]
    deviations: Mapping[str, float]
    left_percent: float

    @property
    def turns_a_sign(self) -> bool:
        """True if a factor, of a term of the law or of the control's scale, is 0 or negative."""
        factors = (value for name, value in self.values.items() if name not in (CONSTANT, DRIFT))
        return min(factors, default=0.0) <= -1


def plausible(explanations: Sequence[Explanation], best: float) -> tuple[Explanation, ...]:
    """Return explanations with nearly the smallest residual, without needlessly complex ones.

    The record cannot distinguish these explanations. An explanation is needlessly complex if a
    simpler one with a part of its `kind` suffices.

    Parameters
    ----------
    explanations : sequence of Explanation
        Simple explanations first.
    best : float
        Smallest residual of all explanations, in percent of the recorded control.
    """
    found: list[Explanation] = []
    for each in explanations:
        is_needless = any({*other.kind} <= {*each.kind} for other in found)
        if each.left_percent <= _MAX_SAME_RESIDUAL * best and not is_needless:
            found.append(each)
    return tuple(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class GainRegression:
    """Regression of the residual between a recorded control and its law on the gains of the law.

    The n rows are the samples of the record that are compared. The k columns are the derivatives of
    the control by the logarithms of the gains, and the other parts of the control in `added`. The
    gains are the declared ones, except those in `free`, which were fitted.

    Attributes
    ----------
    along : LawReplay
        The law along the record with the present gains and a fitted initial state.
    declared : LawReplay
        The law with its declared gains and the initial state of an axis at rest.
    compared : callable
        Function that maps a control at all samples, (N,), to the rows, (n,): a filter and a
        selection.
    neighbours : RowTimes
        Times of the compared rows.
    period : float
        Sample period of the record, s.
    added : dict of str to (N,) array
        Other parts of the recorded control by name, each of which may have another size: a test
        signal, and the part of a law that no gain multiplies. The latter has the name ``1``, as a
        product of no gains.
    put_in : (N,) array of bool
        True for samples at the start, at a limit or masked, which are not compared. If the law
        reads an ideal velocity, the declared law's control replaces the recorded control there.
    possible : tuple of LawInputs
        Inputs that the law may have read, drawn at random; empty where the log shows what it read.
    between : bool
        Whether the law reads values between the samples of the log.
    free : tuple of str
        Gains that were fitted, and so differ from their declared values.
    at_limit : dict of str to (float, float)
        By the name `LIMIT`: the ratio of the recorded control to the declared limit of the drive
        where the law exceeds the limit, and the standard error of this ratio. Empty for a record
        with too few such samples, and with a test signal.
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
        """Return the regression for a law and a record, with the declared gains.

        Only the initial state of the law is fitted.

        Parameters
        ----------
        axis : GeneratedAxis
            Axis with this law.
        law : ControlLaw
        record : Record
            Record without gaps, with a reference and a control.
        used : (N,) array of bool
            Samples that are compared.
        limited : (N,) array of bool
            Samples whose control is not the law's, see `compared_with_law`.
        """
        # The law along the record, with declared gains and the initial state of the controls.
        smooth, (ticks, start) = comparison_filter(law, record), noisy_ticks(axis, record)
        declared = LawReplay.of(axis, law, ticks, record)
        along = replace(declared, start=start[: len(law.memory)])
        # Near the limit, the noise of a converter may hide that the control is limited.
        limited = limited | (np.abs(along.output) > along.limit)
        used = used & ~limited
        # Ratio of the control to the drive's limit, in samples where the law exceeds the limit. The
        # law must exceed it clearly, because the law may read noise that the record does not have.
        noise = np.std((along.control - along.output)[used]) if used.any() else 0.0
        excess = np.abs(along.output) - along.limit
        exceeds = excess > MIN_DISTANCE_FROM_NOISE.value * noise
        unsettled = [(0, settling(law)), *((a, b + LAW_SETTLING) for a, b in record.masked)]
        exceeds &= ~mask_of(unsettled, len(record))
        ratios = (np.sign(along.output) * record.control)[exceeds] / limit_in_log(axis)
        at_limit = {}
        # A test signal is limited together with the output of the law.
        if len(ratios) >= MIN_SAMPLES_PER_FACTOR.value and record.added_control is None:
            median = float(np.median(ratios))
            deviation = _SD_BY_MEDIAN * float(np.median(np.abs(ratios - median)))
            at_limit[LIMIT] = (median, deviation * (np.pi / 2 / len(ratios)) ** 0.5)
        if law.takes_velocity:  # the filter would spread the saturated part over the neighbours
            control = np.where(limited, along.output, along.control)
            declared, along = (replace(each, control=control) for each in (declared, along))
        # Parts of the control that no gain multiplies.
        added = {}
        if law.is_polynomial or not law.gains:
            added[NO_GAINS] = along.slope_by_rest
        if record.added_control is not None:
            added[INJECTED] = as_logged(axis, ticks.added_at_samples(law.delay))
        # Times of the law's evaluations, in samples of the log.
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
            # With noise, all controls show the initial state better than the first controls do.
        ).best(())

    @property
    def gains(self) -> dict[str, float]:
        """Present values of all gains of the law, by name."""
        return dict(zip(self.along.law.gains, map(float, self.along.gains), strict=True))

    @property
    def times(self) -> dict[str, float]:
        """Ratio of each fitted gain to its declared value, by name of the gain.

        For a declared value of 0, which has no ratio, the fitted gain itself.
        """
        declared, gains = self.along.law.gains, self.gains
        return {name: gains[name] / (declared[name] or 1.0) for name in self.free}

    def best(self, names: Sequence[str]) -> "GainRegression":
        """Return the regression with the named gains fitted to the recorded control.

        The initial state of the law is fitted too. Other gains keep their present values.
        """
        free = [[*self.along.law.gains].index(name) for name in names]
        return replace(self, along=self.along.fitted(self.compared, free), free=tuple(names))

    def of_control(self, times: float) -> "GainRegression":
        """Return the regression of the recorded control divided by the factor `times`.

        The gains are the declared ones; only the initial state of the law is fitted.
        """
        control = np.where(self.put_in, self.along.control, self.along.control / times)
        along = replace(self.declared, control=control)
        return replace(self, along=along, at_limit={}).best(())

    @cached_property
    def control(self) -> Array:
        """Recorded control in the compared rows, (n,)."""
        return self.compared(self.along.control)

    @cached_property
    def output(self) -> Array:
        """Output of the law in the compared rows, (n,)."""
        return self.compared(self.along.output)

    @cached_property
    def scale(self) -> "tuple[float, GainRegression] | None":
        """Scale of the recorded control, and the regression of the control divided by it.

        A control of the opposite sign has the scale -1, and all gains are then fitted. None if the
        scale does not differ from 1, or does not explain the control with the declared gains.
        """
        # Scale by least squares, without the part that the initial state of the law explains.
        output, control = self._without_start(np.column_stack([self.output, self.control])).T
        power = float(output @ output)
        times = float(output @ control) / power if power > 0 else 0.0
        if not np.isfinite(times) or times == 0 or abs(times - 1) < MAX_SCALE_ERROR.value:
            return None
        times = times if times > 0 else -1.0
        scaled = self.of_control(times)
        if times < 0:
            scaled = scaled.best([*self.along.law.gains])
        # Rounding of the log makes the control uncertain as well.
        allowed = max(MAX_LAW_RESIDUAL.value, _MAX_UNCERTAINTY_RATIO * self.open_percent)
        if scaled.percent < allowed and (times < 0 or not scaled.off):
            return times, scaled
        return None

    def unless_rounded(self) -> "GainRegression":
        """Return the regression without `possible` inputs, if the record shows that they are wrong.

        Steps of the logged columns do not prove that the log rounded them: a reference may be
        computed in whole steps, and the law may read the steps of an encoder as they are logged. If
        the log had rounded the columns, the residual of the control would contain the effect of the
        rounding with any gains, and jump from sample to sample as with no other fault. If it does
        not jump, with the declared or with fitted gains, the law read the logged values. Otherwise
        the regression is returned unchanged, and always for a law that runs between the samples of
        the log, because the log does not contain the steps that the law read.
        """
        if _is_slower(self.along.ticks):
            return self
        for each in (self, self.best([*self.along.law.gains])):
            jumps_of_rounding = [
                np.linalg.norm(np.diff(change)) for change in each.possible_changes
            ]
            jumps = np.linalg.norm(np.diff(each.residuals))
            if jumps < max(jumps_of_rounding, default=0.0) / MIN_DISTANCE_FROM_NOISE.value:
                return replace(self, possible=(), between=False)
        return self

    @property
    def is_hidden(self) -> bool:
        """True if the residual is too large, but the uncertainty by the log may be its cause.

        The record then does not show whether the law is correct.
        """
        return MAX_LAW_RESIDUAL.value <= self.percent < _MAX_UNCERTAINTY_RATIO * self.open_percent

    @cached_property
    def possible_changes(self) -> list[Array]:
        """Changes of the output with each of the `possible` inputs of the law, (n,) each."""
        outputs = (replace(self.along, ticks=each).output for each in self.possible)
        return [self.compared(each) - self.output for each in outputs]

    @property
    def open_percent(self) -> float:
        """Uncertainty of the law's output, in percent of the control (rms).

        The output is uncertain if the log does not show exactly what the law read, because it
        rounds or samples the inputs of the law. The uncertainty is the largest of the
        `possible_changes`; 0 if there are none.
        """
        percents = [relative_error_percent(each, self.control) for each in self.possible_changes]
        return max(percents, default=0.0)

    @cached_property
    def residuals(self) -> Array:
        """Recorded control minus output of the law, (n,), in the unit of the control.

        The part that another initial state of the law explains is removed.
        """
        return self._without_start((self.control - self.output)[:, None])[:, 0]

    @property
    def percent(self) -> float:
        """Root mean square of `residuals` in percent of the recorded control."""
        return relative_error_percent(self.residuals, self.control)

    @cached_property
    def lean(self) -> dict[str, float]:
        """Significant constant and drift of the residual, by name, in the unit of the control.

        The drift is the change over the record. A constant must exceed 1 % of the control (rms), a
        drift 2 %. Both must also exceed three standard errors, and three times the effect of the
        uncertainty by the log.
        """
        fit = offset_and_drift(self.residuals, self.neighbours)
        least = _MAX_CONTROL_LEAN * np.sqrt(np.mean(self.control**2)) * np.array([1.0, 2.0])
        relevant = np.abs(fit.theta) > least
        if not relevant.any():  # standard errors take most of the time
            return {}
        deviations = np.sqrt(np.diag(coloured_covariance(fit, self.period)))
        # Constants and drifts that the uncertainty by the log may cause.
        by_log = [fit.influence.T @ each for each in self.possible_changes]
        chance = np.abs([deviations, *by_log]).max(axis=0)
        is_far = np.abs(fit.theta) > MIN_DISTANCE_FROM_NOISE.value * chance
        named = zip((CONSTANT, DRIFT), fit.theta, relevant & is_far, strict=True)
        return {name: float(value) for name, value, is_significant in named if is_significant}

    @cached_property
    def gain_steps(self) -> tuple[dict[str, float], Array, Array]:
        """Least-squares changes of gains and added parts, their covariance, and the residual.

        The changes, by name, are those of the logarithms of the gains, and relative changes of the
        parts in `added`. Only gains and parts that the control identifies are included. The
        covariance is in the same order. The residual, (n,), is that with these changes, to first
        order.
        """
        return self._gain_steps(self._names)

    @cached_property
    def off(self) -> list[str]:
        """Names of gains and `added` parts that differ significantly from their declared values.

        A difference must exceed 1 % and three standard errors.
        """
        steps, covariance, _ = self.gain_steps
        far = MIN_DISTANCE_FROM_NOISE.value * np.sqrt(np.diag(covariance))
        allowed = dict(zip(steps, np.maximum(MAX_SCALE_ERROR.value, far), strict=True))
        if self.along.law.takes_velocity and INJECTED in allowed:
            # The velocity in the comparison differs from that of the sensor by about 1 %.
            allowed[INJECTED] = max(allowed[INJECTED], MAX_FACTOR_ERROR)
        return [name for name, step in steps.items() if abs(step) > allowed[name]]

    @property
    def gains_off(self) -> list[str]:
        """Names of gains that differ significantly from their declared values."""
        return [name for name in self.off if name in self.along.law.gains]

    @property
    def factors(self) -> dict[str, tuple[float, float]]:
        """Factor of each term with which the law gives the control, and its standard error.

        The name of a term is its product of gains, or a gain for a law that is not a sum of such
        products. The factors are to first order in the gains; 1 is correct. The factor of the
        drive's limit is included where the record shows it.
        """
        steps, covariance, _ = self.gain_steps
        blur = _FACTOR_BLUR * self.along.law.takes_velocity  # 0 for a law of logged values
        factors = {}
        for term, weights in self._weights_of_steps.items():
            deviation = float(np.hypot(np.sqrt(weights @ covariance @ weights), blur))
            factors[term] = (float(1 + weights @ [*steps.values()]), deviation)
        return {**factors, **self.at_limit}

    @cached_property
    def _weights_of_steps(self) -> dict[str, Array]:
        """Weights of the changes of `gain_steps` in the logarithm of a term's factor, by term.

        Each array has one weight for each change. Only terms whose factor the identified changes
        determine are included.
        """
        steps, names, columns = self.gain_steps[0], self._names, self._columns
        # Columns of all gains as combinations of the identified ones. If gains act only in one
        # product, the change of one of them is that of the product.
        identified = columns[:, [names.index(name) for name in steps]]
        shares = np.linalg.lstsq(identified, columns, rcond=None)[0]
        unexplained = np.linalg.norm(columns - identified @ shares, axis=0)
        shares[:, unexplained > _MIN_DISTINCT_EFFECT * np.linalg.norm(columns, axis=0)] = 0.0
        # The powers of the identified gains must give the powers of all gains of the term.
        weights_by_term = {}
        for term, powers in self.powers.items():
            weights = np.array([powers.get(each, 0.0) for each in steps])
            implied = weights @ shares[:, [names.index(each) for each in powers]]
            if np.allclose(implied, [*powers.values()], rtol=MAX_SCALE_ERROR.value):
                weights_by_term[term] = weights
        return weights_by_term

    @cached_property
    def explanations(self) -> tuple[Explanation, ...]:
        """Explanations of the difference between recorded control and law, simple ones first.

        They are combinations of other gains, another scale of the control, a constant and a drift.
        Their sizes are found by least squares, to first order in the gains.
        """
        # Columns of each single explanation.
        steps = self.gain_steps[0]
        time = self.neighbours.places - self.neighbours.places.mean()
        time = time / np.ptp(time)
        shapes = np.column_stack([self.output, np.ones(len(time)), time])
        # A shape that the initial state of the law explains as well is not tried.
        distinct = self._without_start(shapes)
        least = _MIN_DISTINCT_SHAPE * np.linalg.norm(shapes, axis=0)
        is_distinct = np.linalg.norm(distinct, axis=0) > least
        blocks = {}
        for i, name in enumerate((SCALE, CONSTANT, DRIFT)):
            if is_distinct[i]:
                blocks[name] = distinct[:, [i]]
        if steps:
            blocks[GAINS] = self._columns[:, [self._names.index(name) for name in steps]]
        # Standard errors of the factors of the terms, and of the sizes of the shapes.
        blur = _FACTOR_BLUR * self.along.law.takes_velocity
        size = float(np.sqrt(np.mean(self.control**2)))
        largest = {SCALE: 1.0, CONSTANT: size, DRIFT: 2 * size}
        deviations = {name: sd for name, (_, sd) in self.factors.items()}
        for name, block in blocks.items():
            if name != GAINS:
                by_residual = self._deviation_of(block, name)
                deviations[name] = float(np.hypot(by_residual, blur * largest[name]))
        # Least squares for each combination of explanations.
        found = []
        for kind in _KINDS:
            if not {*kind} <= {*blocks}:
                continue
            columns = np.hstack([blocks[name] for name in kind])
            sizes = np.linalg.norm(columns, axis=0)
            unit = columns / sizes
            solution = np.linalg.lstsq(unit, self.residuals, rcond=_MIN_DISTINCT_EFFECT)[0]
            residuals = self.residuals - unit @ solution
            theta = dict(zip(_names_of(kind, steps), solution / sizes, strict=True))
            values = {name: float(theta[name]) for name in kind if name != GAINS}
            if GAINS in kind:
                identified = np.array([theta[name] for name in steps])
                for term, weights in self._weights_of_steps.items():
                    values[term] = float(weights @ identified)
                values |= {name: factor - 1 for name, (factor, _) in self.at_limit.items()}
            percent = relative_error_percent(residuals, self.control)
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
        """Return the standard error of the factor of a column, (n, 1), in the residual.

        It includes the uncertainty by the log. `name` is that of the column.
        """
        fit, covariance = coloured_fit(
            self.residuals, column, (name,), self.neighbours, self.period
        )
        moved = [float((fit.influence.T @ each)[0]) for each in self.possible_changes]
        return float(np.sqrt(covariance[0, 0] + np.mean(np.square([*moved, 0.0]))))

    @property
    def powers(self) -> dict[str, dict[str, float]]:
        """Powers of the gains in each term of the law, by term; 1 for each part in `added`.

        If the law is not a sum of products of its gains, each gain counts as a term.
        """
        law = self.along.law
        if law.is_polynomial:
            products = [product for product, _ in law.terms if product.free_symbols]
        else:
            products = [gain(name) for name in law.gains]
        powers: dict[str, dict[str, float]] = {}
        for product in products:
            factors = product.as_powers_dict().items()
            powers[str(product)] = {str(g): float(n) for g, n in factors if g.free_symbols}
        return powers | {name: {name: 1.0} for name in self.added}

    @property
    def _names(self) -> list[str]:
        """Names of all gains, then of the parts in `added`, in the order of the k columns."""
        return [*self.along.law.gains, *self.added]

    @cached_property
    def _slopes(self) -> Array:
        """Derivatives of the output by the logarithms of the g gains of the law, (N, g)."""
        return self.along.jacobian_by_gain()

    @cached_property
    def _columns(self) -> Array:
        """Derivatives of the compared output by the gains and by the parts in `added`, (n, k).

        The derivatives are those by the logarithms of the gains. The part that another initial
        state of the law explains is removed.
        """
        every = map(self.compared, (*self._slopes.T, *self.added.values()))
        return self._without_start(np.column_stack([*every]))

    def covariance(self, names: Sequence[str]) -> Array:
        """Return the covariance of the logarithms of the k named gains, (k, k), in their order.

        The other gains are assumed to be correct. A gain that the control does not identify has an
        infinite variance.
        """
        steps, of_identified, _ = self._gain_steps(names, vague=True)
        covariance = np.diag(np.full(len(names), np.inf))
        covariance[np.ix_(*[[names.index(name) for name in steps]] * 2)] = of_identified
        return covariance

    def _gain_steps(
        self, names: Sequence[str], *, vague: bool = False
    ) -> tuple[dict[str, float], Array, Array]:
        """Return the changes of the named gains and parts, their covariance, and the residual.

        They are as in `gain_steps`; the covariance includes the uncertainty by the log.

        Parameters
        ----------
        names : sequence of str
            Names of gains and of parts in `added`.
        vague : bool
            Whether to include gains whose effect on the control is largely uncertain by the log,
            so that their estimates are too low.
        """
        # Columns, with zeros for those that are too uncertain by the log.
        free, columns = [self._names.index(name) for name in names], self._columns
        shown = columns
        if self.possible and not vague:
            other = replace(self.along, ticks=self.possible[0]).jacobian_by_gain()
            changes = (other - self._slopes).T
            noise = np.zeros(len(columns.T))
            noise[: len(changes)] = [np.linalg.norm(self.compared(each)) for each in changes]
            least = MAX_ROUNDED_SHARE.value * np.linalg.norm(columns, axis=0)
            shown = np.where(noise > least, 0.0, columns)
        # Least squares with the columns that the control identifies.
        distinct = _distinct_columns(shown[:, free], float(np.linalg.norm(self.control)))
        identified = [free[j] for j in distinct]
        if not identified:
            return {}, np.zeros((0, 0)), self.residuals
        named = [self._names[i] for i in identified]
        fit, covariance = coloured_fit(
            self.residuals, columns[:, identified], named, self.neighbours, self.period
        )
        if self.possible_changes:
            moved = np.array([fit.influence.T @ each for each in self.possible_changes])
            covariance = covariance + moved.T @ moved / len(moved)
        return dict(zip(named, map(float, fit.theta), strict=True)), covariance, fit.residuals

    def least_change(self) -> "tuple[GainRegression, ...]":
        """Return the regressions with the fewest changed gains that explain the control.

        One gain after the other is added to those that are fitted, each time the gain with the
        smallest residual. Several regressions are returned where different single gains explain the
        control equally well, the best first. If no change is enough, the regression with all gains
        fitted is returned.
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
    def _without_start(self) -> Callable[[Array], Array]:
        """Function that removes the effect of another initial state of the law, (n, k) to (n, k).

        The removed part of a column is its projection on the derivatives of the output by the
        initial state.
        """
        by_start = self.along.slopes_by_start(self.compared)
        starts = np.column_stack([np.empty((len(self.control), 0)), *by_start])
        sizes = np.linalg.norm(starts, axis=0)
        unit = starts[:, sizes > 0] / sizes[sizes > 0]
        return lambda columns: np.asarray(
            columns - unit @ np.linalg.lstsq(unit, columns, rcond=_MIN_DISTINCT_EFFECT)[0]
        )


def _names_of(kind: Sequence[str], gains: Iterable[str]) -> list[str]:
    """Return the names of the columns of an explanation, in order.

    They are the names in `kind`, with the names in `gains` in place of `GAINS`.
    """
    names: list[str] = []
    for each in kind:
        names += [*gains] if each == GAINS else [each]
    return names


def _distinct_columns(columns: Array, size: float) -> list[int]:
    """Return the indices of columns with a visible effect that other columns do not explain.

    The columns are selected by a pivoting QR decomposition.

    Parameters
    ----------
    columns : (n, k) array
    size : float
        Norm of the control, relative to which an effect is visible.
    """
    sizes = np.linalg.norm(columns, axis=0)
    shown = np.flatnonzero(np.isfinite(sizes) & (sizes > _MIN_DISTINCT_EFFECT * size))
    if not len(shown):
        return []
    _, weights, order = qr(columns[:, shown] / sizes[shown], mode="economic", pivoting=True)
    clear = np.abs(np.diag(weights)) > _MIN_DISTINCT_EFFECT
    return sorted(int(shown[i]) for i in order[: len(clear)][clear])


def _is_slower(ticks: LawInputs) -> bool:
    """Return True if the log is slower than the law, so that the law runs between its samples."""
    return len(ticks) > len(ticks.held)


def _possible(ticks: LawInputs, record: Record, times: Array | None) -> Iterator[LawInputs]:
    """Yield random draws of the inputs that the law may have read where the log cannot show them.

    Nothing is yielded where the log shows the inputs. Position and reference are varied within
    their rounding: the log may have rounded them, or an encoder may have rounded the position
    between the samples of a slow log. If the law runs between the samples, the position also gets
    noise as in the log, and the error of a cubic spline, unless a slow log has a quantised
    position. The spline misses motion that is faster than the samples. The difference from a spline
    of every second sample shows by how much; that spline replaces the position.

    Parameters
    ----------
    ticks : LawInputs
        Inputs of the law at its M evaluations, by interpolation of the log.
    record : Record
    times : (M,) array or None
        Times of the evaluations, in samples of the log; None if the law does not run between the
        samples.
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
        drawn_position, drawn_reference = (
            values + step * rng.uniform(-0.5, 0.5, len(values))
            for step, values in zip(steps, (position, reference), strict=True)
        )
        drawn_position = drawn_position + noise * rng.normal(size=len(drawn_position))
        yield replace(ticks, position=drawn_position, reference=drawn_reference)
