"""What a model lacks: columns beside it, each against the twins; the name that explains most.

A hypothesis is one line: columns of the motion, over a grid of places where it has one. All are
tested at once, their level by Holm's rule, and what is told must matter too: more than 1 % of the
force, or a parameter by more than its interval. Of what fails, the name is the one that makes the
largest part of the force; it is taken into the model, and the others are asked again.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import DEFAULT_LEVELS, Levels
from axisid.estimation.estimates import Estimate
from axisid.estimation.records import Record
from axisid.estimation.records.columns import expected_units
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array
from axisid.support.missing import Missing

from .hypotheses import GAIN, Hypothesis, drifts, hypotheses_of, outliers_of
from .scores import ColumnTests, RecordScores, scores_of
from .terms import TERMS, said_of

# residuals less the filter's own, by the left side, up to which their look is a note: measured,
# at most 4e-7 without noise, 5e-3 and more on wrong models that residuals tell
_NEGLIGIBLE_RESIDUAL = 1e-4

_MOST = 3  # that are told


@dataclass(frozen=True, slots=True, kw_only=True)
class Lack:
    """Something that the model lacks.

    Attributes
    ----------
    kind : str
    parameter : str
        What changes in time or is held at a wrong value, or the signal; empty for a term.
    values : tuple of float
        Factors of its columns; of a parameter by what it changes.
    deviation : float
        Of their size, as they scatter in twins.
    before : float
        Of a parameter that changes: its value before, or at the start; 0 for a term.
    at : float
        Speed, period, frequency, time of the change in s since the first row, or sample of an
        outlier; NaN for none.
    share : float
        Of the force that is its part of it, root mean square.
    own_share : float
        The same beside what the parameters make of it, by which it matters.
    p_value : float
        Over all its places.
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

    @property
    def is_of_signal(self) -> bool:
        """Whether a recorded signal is wrong, and not the model."""
        return self.kind in ("late signal", "scaled signal")

    @property
    def is_outlier(self) -> bool:
        """Whether it is a single sample of a signal, and not the model."""
        return self.kind == "outlier"


#: A hypothesis and its columns.
Prepared: TypeAlias = tuple[Hypothesis, Array]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TestedHypothesis:
    """A hypothesis at its best place, tested beside a model.

    Attributes
    ----------
    hypothesis : Hypothesis
    at : float
        That place.
    columns : (n, g) array
        There.
    p_value : float
        Over all places.
    share : float
        Of the force that it makes beside what the parameters make of it, root mean square.
    moved : float
        By how much of its interval it moves the parameter that it moves most.
    """

    hypothesis: Hypothesis
    at: float
    columns: Array
    p_value: float
    share: float
    moved: float

    def matters(self, least_share: float) -> bool:
        """Whether it is any part of the force, or more than rounding and moves a parameter."""
        moves = self.moved > 1 and self.share > _NEGLIGIBLE_RESIDUAL
        return self.share > least_share or moves


def scores_at(
    data: FilteredRecord, preferred: Estimate, *, by_loop: bool = False
) -> RecordScores | Missing:
    """Residuals of a record and of its twins at the judged estimate, as by `scores_of`."""
    chains = preferred.inference.chains
    at = preferred.corrected if chains else preferred.physical
    chain = chains[0] if chains else None
    return scores_of(data, at, chain, range(len(at)), by_loop=by_loop)


def lacking(
    scores: RecordScores | Missing,
    preferred: Estimate,
    records: int = 1,
    levels: Levels = DEFAULT_LEVELS,
) -> tuple[Lack, ...] | Missing:
    """What the judged estimate's model lacks on a record, one of several, the strongest first."""
    if isinstance(scores, Missing):
        return scores
    half = np.array([np.ptp(value.interval) / 2 for value in preferred.parameters.values()])
    return found_beside(scores, half, records, levels)


def found_beside(
    scores: RecordScores,
    half_widths: Array,
    records: int,
    levels: Levels,
) -> tuple[Lack, ...]:
    """What is found beside a model, the name that explains most first.

    Parameters
    ----------
    scores : RecordScores
    half_widths : (p,) array
        Of its intervals.
    records : int
        How many are searched by themselves, which share the level.
    levels : Levels
    """
    own = replace(levels, level=levels.level / records)
    lasting = [(each, each.columns(each.places)) for each in hypotheses_of(scores)]
    # Without twins nothing tells what the filter itself moves the parameters by.
    half = half_widths[scores.free] if scores.twins else np.full(len(scores.free), np.inf)
    named, beside = list[Lack](), scores
    while len(named) < _MOST:
        single = [(each, each.columns(each.places)) for each in outliers_of(beside)]
        failing = findings(beside, [*lasting, *single], half, own)
        if not failing:
            break
        name = _located(beside, failing[0])
        if named and name.share <= own.least_share:
            break
        named.append(_told(beside, name))
        beside = beside.beside(name.columns)
    return tuple(named)


def findings(
    scores: RecordScores, hypotheses: Sequence[Prepared], half: Array, levels: Levels
) -> list[TestedHypothesis]:
    """What is there and matters, by its part of the force, the largest first."""
    sure = levels.level / max(len(hypotheses), 1)
    every = [_finding(scores, *each, half, sure) for each in hypotheses]
    every.sort(key=lambda each: each.p_value)
    there = []
    for place, each in enumerate(every):
        if each.p_value > levels.level / (len(every) - place):
            break
        there.append(each)
    return sorted((e for e in there if e.matters(levels.least_share)), key=lambda each: -each.share)


def _finding(
    scores: RecordScores, hypothesis: Hypothesis, columns: Array, half: Array, sure: float
) -> TestedHypothesis:
    """It at the place that takes most of those that are sure, else at the surest."""
    tested = scores.test(columns)
    p_values = hypothesis.chances(tested)
    told = p_values <= sure
    taken = np.where(told, hypothesis.taken(tested), -np.inf)
    best = int(np.argmax(taken) if told.any() else np.argmin(p_values))
    values = tested.values[best]
    moved = np.abs(scores.moved_by(columns[:, best], values))
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.nan_to_num(moved / half, nan=0.0, posinf=0.0)
    return TestedHypothesis(
        hypothesis=hypothesis,
        at=float(hypothesis.places[best]),
        columns=columns[:, best],
        p_value=float(p_values[best]),
        share=float(np.sqrt(tested.powers[best])) / (float(np.std(scores.force)) or 1.0),
        moved=float(far.max(initial=0.0)),
    )


def _located(scores: RecordScores, found: TestedHypothesis) -> TestedHypothesis:
    """The same at the best place between those of its grid."""
    hypothesis = found.hypothesis
    if hypothesis.between is None:
        return found
    near = hypothesis.between(hypothesis.places, found.at)
    made = hypothesis.columns(near)
    if hypothesis.measured is None:
        best = int(np.argmax(scores.test(made).powers))
    else:
        best = scores.nearest(made, hypothesis.measured(near))
    values = scores.test(made[:, [best]]).values[0]
    if hypothesis.is_positive and values[0] <= 0:
        return found
    return replace(found, at=float(near[best]), columns=made[:, best])


def _told(scores: RecordScores, name: TestedHypothesis) -> Lack:
    """What is found, as it is told."""
    hypothesis, at, columns = name.hypothesis, name.at, name.columns
    tested = scores.test(columns[:, None])
    values, covariance = _amounts(scores, hypothesis, at, tested)
    size = float(np.linalg.norm(values))
    made_by = columns @ tested.values[0]
    return Lack(
        kind=hypothesis.kind,
        parameter=hypothesis.parameter,
        values=tuple(map(float, values)),
        deviation=math.sqrt(max(float(values @ covariance @ values), 0.0)) / (size or 1.0),
        before=_before(scores, hypothesis, columns, tested.values[0]),
        at=at,
        share=float(np.linalg.norm(made_by) / (np.linalg.norm(scores.force) or 1.0)),
        own_share=name.share,
        p_value=name.p_value,
    )


def _amounts(
    scores: RecordScores, hypothesis: Hypothesis, at: float, tested: ColumnTests
) -> tuple[Array, Array]:
    """How much of it there is, and its covariance: a change, a delay, a factor, or each column."""
    values, covariance = tested.values[0], tested.covariances[0]
    if hypothesis.kind == "late signal":
        step = hypothesis.columns(np.array([at - 0.5, at + 0.5])) @ values
        slope = scores.test((step[:, 1:] - step[:, :1])[:, :, None])
        return np.array([at]), slope.covariances[0]
    if hypothesis.kind == "drift":
        first, last = _extremes(scores, values)
        change = last - first
        values = np.array([change @ values])
        covariance = np.array([[change @ covariance @ change]])
    if hypothesis.parameter == GAIN:  # what it makes is on the other side
        values = -values
    if hypothesis.kind == "scaled signal":
        values = 1 + values
    return values, covariance


def _extremes(scores: RecordScores, values: Array) -> tuple[Array, Array]:
    """Shapes of a drift at its lowest and highest, in the order of time."""
    shapes = drifts(scores.data.times_of_rows)
    course = shapes @ values
    first, last = sorted((int(np.argmin(course)), int(np.argmax(course))))
    return shapes[first], shapes[last]


def _before(scores: RecordScores, hypothesis: Hypothesis, columns: Array, values: Array) -> float:
    """What a parameter is before it changes: the estimate is in between; 0 of what is none."""
    names = [q.name for q in scores.data.axis.parameters]
    if hypothesis.parameter == GAIN:
        return 1.0
    if hypothesis.parameter not in names:
        return 0.0
    place = names.index(hypothesis.parameter)
    moved = np.zeros(len(names))
    moved[scores.free] = scores.moved_by(columns, values)
    begun = _extremes(scores, values)[0] @ values if hypothesis.kind == "drift" else 0.0
    return float(scores.physical[place] + moved[place] + begun)


def sentence(lack: Lack, axis: GeneratedAxis, record: Record) -> str:
    """What is missing, changes or is logged wrongly, how much of it, and what to do about it."""
    if lack.is_of_signal:
        return _signal(lack, record.period)
    size, deviation, unit = amount(lack, axis)
    if lack.is_outlier:
        sample, part = int(lack.at), of_force(lack.share)
        return (
            f"the {lack.parameter} leaves its course by {size:+.3g} +- {deviation:.1g} {unit} at "
            f"sample {sample + 1}, {record.time[sample] - record.time[0]:.6g} s after the first "
            f"({part})"
        )
    if not lack.parameter:
        what, advice = said_of(TERMS[lack.kind], lack.at, axis.axis, size)
        told = f", {size:+.3g} +- {deviation:.1g} {unit}" if unit else ""
        return f"{what}{told}: {advice} ({of_force(lack.share)})"
    if lack.kind == "held":
        by = f"{abs(size):.3g} +- {deviation:.1g} {unit}".rstrip()
        return f"another {lack.parameter} than was given, {by} {'more' if size > 0 else 'less'}"
    share = f" ({100 * size / lack.before:+.2g} %)" if lack.before else ""
    by = f"{size:+.3g} +- {deviation:.1g} {unit}".rstrip() + share
    if lack.kind == "drift":
        return (
            f"{lack.parameter} changes with time, by {by} over the record, little by little: "
            "record when the axis is warm, or identify parts of the record by themselves"
        )
    return (
        f"{lack.parameter} changes by {by} from about {lack.at:.3g} s on: identify what is before "
        "and after by itself, or find what was changed there"
    )


def amount(lack: Lack, axis: GeneratedAxis) -> tuple[float, float, str]:
    """How much of it there is, its deviation, and their unit."""
    values, deviation = np.array(lack.values), lack.deviation
    size = float(np.linalg.norm(values)) if len(values) > 1 else float(values[0])
    if lack.is_outlier:
        return size, deviation, expected_units(lack.parameter, axis.axis)[0]
    if lack.parameter:
        units = {q.name: str(q.unit) for q in axis.parameters} | {GAIN: "times"}
        return size, deviation, units.get(lack.parameter, "")
    q, unit = axis.axis.coordinate, TERMS[lack.kind].unit
    return size, deviation, unit.format(force=q.force_unit, unit=q.unit)


def of_force(share: float) -> str:
    """How much of the force something makes; a share beyond all of it says no more than that."""
    beyond = share > 1
    return "this is more than the force" if beyond else f"{100 * share:.2g} % of the force is this"


def _signal(lack: Lack, period: float) -> str:
    """How late or how much too small a recorded signal is, beside the force that it makes."""
    value, deviation = lack.values[0], lack.deviation
    if lack.kind == "scaled signal":
        said = f"the model needs {value:.4g} +- {deviation:.1g} times the recorded {lack.parameter}"
    else:
        way = "late" if value > 0 else "early"
        said = (
            f"the {lack.parameter} is logged {abs(value):.4g} +- {max(deviation, 0.01):.1g} "
            f"samples ({1e3 * abs(value) * period:.4g} ms) {way} beside the force that it makes"
        )
    return f"{said} ({of_force(lack.share)})"
