"""Search for misspecifications: test of each hypothesis with simulated replicas.

All hypotheses are tested together at a level by Holm's rule. A reported hypothesis must also be
relevant: it makes more than 1 % of the force, or changes a parameter by more than half the width of
its interval. Of the significant and relevant hypotheses, the one with the largest part of the force
is reported and added to the model. The others are then tested again.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from axisid.estimation.records.columns import expected_units
from axisid.estimation.thresholds import MIN_MODEL_SHARE
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Levels
from axisid.support.arrays import Array
from axisid.support.missing import unless_missing

from .hypotheses import GAIN, Hypothesis, drifts, hypotheses_of, outliers_of
from .scores import ColumnTests, RecordScores
from .terms import TERMS

# Part of the force up to which residuals, minus those of the filter, count as rounding. Measured:
# at most 4e-7 without noise, 5e-3 and more for wrong models.
_NEGLIGIBLE_RESIDUAL = 1e-4
# Share of a column's norm: two columns that differ by less are the same, as the filter rounds
# reversals.
_SAME_COLUMN = 0.05
# Part of the force above which a change of a parameter by another term is reported.
_LARGE_PART = 0.1
# Share of the force relative to that of the term that explains most, from which another term may be
# the cause as well.
_NEARLY = 0.9
#: Checks that report hypotheses that are not terms, by kind.
_CHECKS = {
    "late signal": "recorded signals",
    "scaled signal": "recorded signals",
    "outlier": "outliers",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Misspecification:
    """A misspecification of the model: a missing term, a changed parameter or a faulty signal.

    Attributes
    ----------
    kind : str
        Name of the missing term, or ``held``, ``drift``, ``change``, ``late signal``,
        ``scaled signal`` or ``outlier``.
    parameter : str
        Parameter that changes in time or has a wrong given value, or the faulty signal or column;
        empty for a missing term.
    values : tuple of float
        Factors of the columns of a missing term; the change of a parameter; the delay in samples or
        the scale of a signal; or the size of an outlier.
    deviation : float
        Standard error of `size`, by simulated replicas.
    before : float
        Value of a changing parameter before its step, or at the start of its drift; 0 for a term.
    at : float
        Place of the hypothesis: speed, period, frequency, time of the change in s since the first
        row, delay in samples, or sample of an outlier; NaN for a hypothesis without a place.
    share : float
        Part of the force that the misspecification makes, root mean square, relative to the force.
    own_share : float
        The part of it that the parameters do not explain, which is compared with the threshold.
    p_value : float
        P-value over all values of `at` that were tried.
    unit : str
        Unit of `size`; empty if no size is reported.
    parameters : mapping of str to tuple of float
        Values of the free parameters with this and all misspecifications found before in the model.
        A parameter that then differs between directions has two values, forward and backward.
    moved : str
        Name of the parameter that changes most, relative to its value, with the misspecification in
        the model; empty if no change counts. A change counts if it is more than half the width of
        the parameter's interval and makes a large part of the force; for a parameter that itself
        changes in the record, the least share of the force is enough.
    moved_percent : float
        Change of this parameter, percent of its value.
    moved_value : float
        Value of this parameter without the misspecification and those found before; NaN for no
        parameter.
    at_the_end : bool
        True if a delay is at the end of its search range, so that the true delay is not known.
    others : tuple of (str, float)
        Kinds of other terms that explain nearly as much of the force, each with its value of `at`.
    """

    kind: str
    parameter: str
    values: tuple[float, ...]
    deviation: float
    before: float
    at: float
    share: float
    own_share: float
    p_value: float
    unit: str = ""
    parameters: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    moved: str = ""
    moved_percent: float = 0.0
    moved_value: float = math.nan
    at_the_end: bool = False
    others: tuple[tuple[str, float], ...] = ()

    @property
    def size(self) -> float:
        """Reported size, in `unit`: the value, or the norm of several values."""
        return self.values[0] if len(self.values) == 1 else float(np.linalg.norm(self.values))

    @property
    def is_term(self) -> bool:
        """True for a missing force of the motion, not a changed parameter or a faulty signal."""
        return not self.parameter

    @property
    def check(self) -> str:
        """Name of the check that reports the misspecification.

        It is ``recorded signals`` or ``outliers`` for faulty signals, otherwise ``missing terms``.
        """
        return _CHECKS.get(self.kind, "missing terms")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TestedHypothesis:
    """A hypothesis at its best place, tested as an addition to a model.

    Attributes
    ----------
    hypothesis : Hypothesis
    at : float
        The best place: the speed, period, time or other number that the columns depend on; NaN for
        a hypothesis without a place.
    columns : (n, g) array
        Columns at this place.
    p_value : float
        P-value over all places.
    share : float
        Part of the force that the columns explain and the parameters do not, root mean square,
        relative to the force.
    moved : float
        Largest change of a parameter, relative to the half width of its interval.
    at_the_end : bool
        True if a delay is at the end of its search range, so that the true delay is not known.
    """

    hypothesis: Hypothesis
    at: float
    columns: Array
    p_value: float
    share: float
    moved: float
    at_the_end: bool


@unless_missing
def find_misspecification(
    scores: RecordScores,
    half_widths: Array,
    records: int = 1,
    levels: Levels = DEFAULT_LEVELS,
) -> tuple[Misspecification, ...]:
    """Return the misspecifications of a model on a record, the one that explains most first.

    In each round all hypotheses are tested. Of the hypotheses that are significant by Holm's rule
    and relevant, the one with the largest part of the force is located between the places of its
    grid, reported, and added to the model. There are at most three rounds.

    Parameters
    ----------
    scores : RecordScores
        Residuals of the record and of its replicas at the estimate.
    half_widths : (p,) array
        Half widths of the intervals of the parameters.
    records : int
        Number of records that are searched separately; the level is divided by this number.
    levels : Levels
        Level of all tests together, and least share of the force that is relevant.
    """
    hypotheses = hypotheses_of(scores)
    # Without replicas the effect of the filter on the parameters is unknown.
    half = half_widths[scores.free] if scores.twins else np.full(len(scores.free), np.inf)
    level, lacks = levels.level / records, list[Misspecification]()
    revised = scores.physical[scores.free]
    while len(lacks) < 3:
        every = [*hypotheses, *outliers_of(scores)]
        tests = [_tested(scores, each, half, level / len(every)) for each in every]
        tests.sort(key=lambda each: each.p_value)
        # The significant hypotheses, by Holm's rule: from the smallest p-value, up to the first one
        # above its level. Relevant are those that make enough of the force, and those that change a
        # parameter and are no rounding.
        relevant: list[TestedHypothesis] = []
        for each, level_of_each in zip(tests, level / np.arange(len(tests), 0, -1), strict=True):
            if not each.p_value <= level_of_each:
                break
            changes_parameter = each.moved > 1 and each.share > _NEGLIGIBLE_RESIDUAL
            if each.share > levels.least_share or changes_parameter:
                relevant.append(each)
        # The relevant hypothesis with the largest part of the force. A delay at the end of its
        # range may be the effect of another fault, so that other hypotheses come first.
        most = max(relevant, key=lambda each: (not each.at_the_end, each.share), default=None)
        if most is None or (lacks and most.share <= levels.least_share):
            break
        # Its best place, the parameters with it in the model, and terms that explain as much.
        found = _located(scores, most)
        factors = scores.test(found.columns[:, None]).values[0]
        revised = revised + scores.moved_by(found.columns, factors)
        with_it = _values_with(scores, found, revised, float(factors[0]))
        others = tuple(
            (each.hypothesis.kind, each.at)
            for each in tests
            if each.hypothesis.kind in TERMS
            and each is not most
            and each.p_value <= level
            and each.share >= _NEARLY * most.share
        )
        lack = _misspecification_of(scores, found, half_widths, levels)
        if lacks and lack.moved in lacks[-1].parameters:
            moved_value = float(np.mean(lacks[-1].parameters[lack.moved]))
            lack = replace(lack, moved_value=moved_value)
        lacks.append(replace(lack, parameters=with_it, others=others))
        scores = scores.with_columns(found.columns)
    return tuple(lacks)


def _tested(
    scores: RecordScores, hypothesis: Hypothesis, half: Array, sure: float
) -> TestedHypothesis:
    """Return a hypothesis at its best place, with its test.

    The best place is the significant place that explains most of the residual. If no place is
    significant, the best place is that with the smallest p-value.

    Parameters
    ----------
    scores : RecordScores
    hypothesis : Hypothesis
    half : (k,) array
        Half widths of the intervals of the free parameters; infinite if the effect on the
        parameters is not to be judged.
    sure : float
        P-value up to which a place is significant.
    """
    places = hypothesis.places
    columns = hypothesis.columns(places)
    tested = scores.test(columns)
    explained = _explained_power(scores, hypothesis, tested, columns)
    if hypothesis.is_lost:
        # Without replicas, the p-value is that of the place that explains most.
        one = [int(np.argmax(explained))]
        places, columns, explained = places[one], columns[:, one], explained[one]
        tested = scores.test(columns)
    # P-values over all places, and 1 for places whose factor has the wrong sign.
    first = tested.values[:, 0]
    p_values = np.clip(tested.p_values * len(hypothesis.places), hypothesis.least, 1.0)
    p_values[hypothesis.is_positive & (first <= 0)] = 1.0
    p_values[hypothesis.is_lost & (explained <= 0)] = 1.0
    significant = p_values <= sure
    if significant.any():
        best = int(np.argmax(np.where(significant, explained, -np.inf)))
    else:
        best = int(np.argmin(p_values))
    # Largest effect on a parameter, relative to its interval.
    moved = np.abs(scores.moved_by(columns[:, best], tested.values[best]))
    far = np.divide(moved, half, out=np.zeros_like(moved), where=half > 0)
    return TestedHypothesis(
        hypothesis=hypothesis,
        at=float(places[best]),
        columns=columns[:, best].copy(),
        p_value=float(p_values[best]),
        share=float(np.sqrt(tested.powers[best])) / (float(np.std(scores.force)) or 1.0),
        moved=float(far.max(initial=0.0)),
        at_the_end=hypothesis.kind == "late signal" and best in (0, len(hypothesis.places) - 1),
    )


def _explained_power(
    scores: RecordScores, hypothesis: Hypothesis, tested: ColumnTests, columns: Array
) -> Array:
    """Return the mean square of the residuals that each of m places explains, (m,).

    For most hypotheses the columns have the fitted factors. If the place alone determines the
    missing force, the column has a factor of 1.

    If a part of the commanded force is lost, the residuals become smaller because the force does.
    The residuals are therefore taken relative to the remaining force, and a place explains nothing
    unless it explains most of the residuals: ``e'e - (e'e - w) f'f / (f - c)'(f - c)``, with w the
    part of the residuals e that the columns c explain, and f the force.
    """
    if not hypothesis.is_whole:
        return tested.powers
    if not hypothesis.is_lost:
        return tested.whole_powers
    left = float(np.mean(scores.net_residuals[:, 0] ** 2))
    given = np.sum((scores.force[:, None] - columns[:, :, 0]) ** 2, axis=0)
    ratio = float(np.sum(scores.force**2)) / np.maximum(given, np.finfo(float).tiny)
    taken = left - (left - tested.whole_powers) * ratio
    return np.where(taken > MIN_MODEL_SHARE.value * left, taken, 0.0)


def _located(scores: RecordScores, found: TestedHypothesis) -> TestedHypothesis:
    """Return a tested hypothesis at its best place between those of the grid.

    The hypothesis is unchanged if its grid is not refined, or if its columns at the best place are
    those of a term that was found before or have a factor of the wrong sign.
    """
    hypothesis = found.hypothesis
    if hypothesis.between is None:
        return found
    near = hypothesis.between(hypothesis.places, found.at)
    columns = hypothesis.columns(near)
    if hypothesis.is_lost:
        best = int(np.argmax(_explained_power(scores, hypothesis, scores.test(columns), columns)))
    elif hypothesis.measured is None:
        best = int(np.argmax(scores.test(columns).powers))
    else:
        best = scores.nearest(columns, hypothesis.measured(near))
    values = scores.test(columns[:, [best]]).values[0]
    # The factor is 0 at a place of which the model already has the columns.
    if not values.any() or (hypothesis.is_positive and values[0] <= 0):
        return found
    at = float(near[best])
    ends = hypothesis.places[0], hypothesis.places[-1]
    at_the_end = found.at_the_end and at in ends
    return replace(found, at=at, columns=columns[:, best], at_the_end=at_the_end)


def _values_with(
    scores: RecordScores, found: TestedHypothesis, revised: Array, size: float
) -> dict[str, tuple[float, ...]]:
    """Return the values of the free parameters with a hypothesis in the model, by name.

    A parameter that the hypothesis makes differ between directions has two values, forward and
    backward.

    Parameters
    ----------
    scores : RecordScores
    found : TestedHypothesis
        The hypothesis.
    revised : (k,) array
        Free parameters with the hypothesis in the model.
    size : float
        Factor of the first column of the hypothesis.
    """
    every = scores.data.axis.parameters
    values: dict[str, tuple[float, ...]] = {
        every[j].name: (float(v),) for j, v in zip(scores.free, revised, strict=True)
    }
    term = TERMS.get(found.hypothesis.kind)
    if term is None or not term.is_by_direction:
        return values
    # The term's column is half of the parameter's column, with the same sign in both directions.
    halves, column = np.abs(scores.regressor[:, scores.free]) / 2, np.abs(found.columns[:, :1])
    apart = np.linalg.norm(halves - column, axis=0)
    nearest = int(np.argmin(apart))
    if apart[nearest] <= _SAME_COLUMN * np.linalg.norm(column):
        value = float(revised[nearest])
        values[every[scores.free[nearest]].name] = (value + size / 2, value - size / 2)
    return values


def _misspecification_of(
    scores: RecordScores, found: TestedHypothesis, half_widths: Array, levels: Levels
) -> Misspecification:
    """Return the misspecification of a tested hypothesis, with its size and its effects.

    The size is a factor of the columns, a delay, a scale, or the change of a parameter. For a
    parameter that changes, the value before the change is returned too: the estimate lies between
    the values before and after the change.

    Parameters
    ----------
    scores : RecordScores
    found : TestedHypothesis
        The hypothesis at its best place.
    half_widths : (p,) array
        Half widths of the intervals of the parameters.
    levels : Levels
    """
    # Size and its covariance, in the quantity that is reported.
    kind, parameter, columns = found.hypothesis.kind, found.hypothesis.parameter, found.columns
    tested = scores.test(columns[:, None])
    factors, covariance = tested.values[0], tested.covariances[0]
    values, begun, before = factors, 0.0, 0.0
    if kind == "late signal":  # the delay, with the derivative of the force by the delay
        step = found.hypothesis.columns(np.array([found.at - 0.5, found.at + 0.5])) @ factors
        slope = scores.test((step[:, 1:] - step[:, :1])[:, :, None])
        values, covariance = np.array([found.at]), slope.covariances[0]
    elif kind == "drift":  # between its lowest and highest value, in the order of time
        shapes = drifts(scores.data.times_of_rows)
        course = shapes @ factors
        first, last = sorted((int(np.argmin(course)), int(np.argmax(course))))
        change = shapes[last] - shapes[first]
        values, begun = np.array([change @ factors]), float(course[first])
        covariance = np.array([[change @ covariance @ change]])
    elif kind == "scaled signal":
        values = 1 + values
    # Changes of the parameters, and the largest one that matters.
    names = [q.name for q in scores.data.axis.parameters]
    moved = np.zeros(len(names))
    moved[scores.free] = scores.moved_by(columns, factors)
    if parameter == GAIN:  # the commanded force is on the left side
        values, before = -values, 1.0
    elif parameter in names:
        place = names.index(parameter)
        before = float(scores.physical[place] + moved[place] + begun)
        moved[place] = max(abs(moved[place]), abs(values[0]))
    # A small offset may change by a multiple of itself, which hardly changes the force.
    least = np.full(len(names), _LARGE_PART)
    if parameter in names:
        least[names.index(parameter)] = levels.least_share
    effects = np.linalg.norm(scores.regressor * moved, axis=0)
    matters = effects > least * float(np.linalg.norm(scores.force))
    matters &= np.abs(moved) > half_widths
    sizes = np.where(matters & (scores.physical != 0), np.abs(scores.physical), np.inf)
    percents = 100 * np.abs(moved) / sizes
    most = int(np.argmax(percents))
    unit = found.hypothesis.unit
    if kind == "outlier":
        unit = expected_units(parameter, scores.data.axis.axis)[0]
    return Misspecification(
        kind=kind,
        parameter=parameter,
        values=tuple(map(float, values)),
        deviation=math.sqrt(max(float(values @ covariance @ values), 0.0))
        / (float(np.linalg.norm(values)) or 1.0),
        before=before,
        at=found.at,
        share=float(np.linalg.norm(columns @ factors) / (np.linalg.norm(scores.force) or 1.0)),
        own_share=found.share,
        p_value=found.p_value,
        unit=unit,
        moved=names[most] if percents[most] else "",
        moved_percent=float(percents[most]),
        moved_value=float(scores.physical[most]) if percents[most] else math.nan,
        at_the_end=found.at_the_end,
    )
