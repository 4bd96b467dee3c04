"""What a model lacks: columns beside it, each against the twins; the name that explains most.

A hypothesis is columns, each with a name and where it has places: terms of the motion, parameters
that change in time, recorded signals that are late or of another unit, and single samples of a
signal that leave its course. All are tested at once, their level by Holm's rule, and what is told
must matter too: more than 1 % of the force, or a parameter by more than its interval. Of what
fails, the name is the one that makes the largest part of the force; it is taken into the model, and
the others are asked again.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import takewhile
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostic_checks import DEFAULT_LEVELS, Levels
from axisid.estimation.estimates import Estimate
from axisid.estimation.records import Record
from axisid.estimation.records.columns import expected_units
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array
from axisid.support.errors import CandidateError, Missing, first_case, quoted, unless_missing

from .scores import RecordScores, scores_of
from .terms import TERMS, Along, Term

#: What stands for a parameter where it is the drive's gain that changes.
GAIN = "the drive gain"

# residuals less the filter's own, by the left side, up to which their look is a note: measured,
# at most 4e-7 without noise, 5e-3 and more on wrong models that residuals tell
_NEGLIGIBLE_RESIDUAL = 1e-4
#: By kind of what is no term: the check that tells it.
_CHECKS = {
    "late signal": "recorded signals",
    "scaled signal": "recorded signals",
    "outlier": "outliers",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hypothesis:
    """Columns that a model may lack.

    Attributes
    ----------
    kind : str
    columns : callable
        Of places (m,): (n, m, g).
    parameter : str
        As of `Misspecification`.
    places : (m,) array
        NaN where there is one place alone.
    measured : callable or None
        The same of the measured motion, which says where it is between the places of the grid.
    between : callable or None
        Places about one of the grid, that it is looked for at once it is told.
    is_positive : bool
        Whether it must be: friction, a mass.
    least : float
        That its chance is no smaller than: of places that were chosen by what is left.
    is_whole : bool
        Whether the columns are the whole of it, so that its place alone tells how much.
    unit : str
        Of its size; empty where none is told.
    """

    kind: str
    columns: Callable[[Array], Array]
    parameter: str = ""
    unit: str = ""
    places: Array = field(default_factory=lambda: np.array([np.nan]))
    measured: Callable[[Array], Array] | None = None
    between: Callable[[Array, float], Array] | None = None
    is_positive: bool = False
    least: float = 0.0
    is_whole: bool = False


def hypotheses_of(scores: RecordScores) -> list[Hypothesis]:
    """All that is looked for: terms of the motion, what is held or changes in time, signals."""
    data = scores.data
    axis, drive = data.axis.axis, data.axis.axis.drive
    commanded = data.record.force is None and drive.is_gain and not drive.logs_what_acts
    # A turn is told of an angle, a dead band of what is commanded.
    possible = {"turn": axis.coordinate.unit == "rad", "dead band": commanded}
    most = scores.twins - 1 if scores.twins else len(scores.along.place)
    found = [
        Hypothesis(
            kind=term.kind,
            unit=term.unit.format(force=axis.coordinate.force_unit, unit=axis.coordinate.unit),
            places=_of_user(term, term.places, scores.along),
            columns=partial(_columns, term, most, scores.along),
            measured=partial(_columns, term, most, scores.measured),
            between=None if term.between is None else partial(_of_user, term, term.between),
            is_positive=term.is_positive,
        )
        for term in TERMS.values()
        if possible.get(term.kind, True) and (scores.twins or not term.is_of_force)
    ]
    held = [  # parameters that have a value which the record did not tell
        Hypothesis(
            kind="held",
            parameter=q.name,
            unit=str(q.unit),
            columns=partial(_once, scores.regressor[:, [j]]),
        )
        for j, q in enumerate(data.axis.parameters)
        if j not in scores.free
    ]
    if held:  # of what is declared the parameter is told, not the term
        declared = scores.with_columns(
            np.hstack([each.columns(each.places)[:, 0] for each in held])
        )
        found = [e for e in found if declared.test(e.columns(e.places)).values.any()]
    changing = _changing(scores, commanded=commanded and bool(scores.twins))
    of_signals = _of_signals(scores) if axis.signals else []
    return [each for each in (*found, *held, *changing, *of_signals) if len(each.places)]


_HUGE = 1e100  # whose square is finite still


def _of_user(term: Term, make: Callable[..., Array], *arguments: Any) -> Array:
    """What a term makes, which may be a user's own and raise."""
    try:
        with np.errstate(all="ignore"):
            return np.atleast_1d(np.asarray(make(*arguments), dtype=float))
    except MemoryError:
        raise
    except Exception as error:
        said = f"{type(error).__name__}: {error}".rstrip(": ")
        raise CandidateError(
            f"the candidate {quoted(term.kind)} makes no columns or places ({said}); mend it, or "
            "take it out of axisid.candidates.TERMS.",
        ) from error


def _columns(term: Term, most: int, along: Along, places: Array) -> Array:
    """Columns of a term, (n, m, g), which a user's own may give otherwise; so many at most."""
    found, rows = _of_user(term, term.columns, along, places), len(along.place)
    finite, is_block = bool((np.abs(found) < _HUGE).all()), found.shape[:-1] == (rows, len(places))
    if not (is_block and found.size and found.shape[2] <= most and finite):
        raise CandidateError(
            f"the columns of the candidate {quoted(term.kind)} have the shape {found.shape}"
            f"{f', and are not all below {_HUGE:g}' * (not finite)}; give such ones of {rows} "
            f"rows, {len(places)} places and one or a few of each, {most} at most, as "
            "motion.reduce(force)[:, None, None] for a force without places.",
        )
    return found


def _changing(scores: RecordScores, *, commanded: bool) -> list[Hypothesis]:
    """Each parameter, and the drive gain, as it drifts or is another from some time on."""
    of = {
        (q.name, str(q.unit)): column
        for q, column in zip(scores.data.axis.parameters, scores.regressor.T, strict=True)
    }
    if commanded:
        of[GAIN, "times"] = scores.along.reduce(scores.along.force)
    times = scores.data.times_of_rows
    middle = times[0] + (times[-1] - times[0]) * np.linspace(0.15, 0.85, 15)
    return [
        hypothesis
        for (name, unit), column in of.items()
        if column.any()  # else nothing that these rows could show of it changes
        for hypothesis in (
            Hypothesis(
                kind="drift",
                parameter=name,
                unit=unit,
                columns=partial(_once, column[:, None] * drifts(times)),
            ),
            Hypothesis(
                kind="change",
                parameter=name,
                unit=unit,
                columns=partial(_from, column, times),
                places=middle,
                between=_between,
            ),
        )
    ]


def drifts(times: Array) -> Array:
    """Courses over the rows' times, (n, 3): a line, and one slow swing."""
    part = (times - times[0]) / (times[-1] - times[0])
    return np.column_stack([part, np.sin(2 * np.pi * part), np.cos(2 * np.pi * part)])


def _once(columns: Array, _: Array) -> Array:
    """Columns (n, g) of one place."""
    return columns[:, None]


def _from(column: Array, times: Array, places: Array) -> Array:
    """A column from each time on, (n, m, 1)."""
    return np.where(times[:, None] >= places, column[:, None], 0.0)[:, :, None]


def _between(grid: Array, at: float) -> Array:
    """Places about one of a grid."""
    place = int(np.argmin(np.abs(grid - at)))
    return np.linspace(grid[max(place - 1, 0)], grid[min(place + 1, len(grid) - 1)], 65)


def _of_signals(scores: RecordScores) -> list[Hypothesis]:
    """Each recorded signal that makes a force, late or early, and of another size."""
    by, record = _by_change(scores, scores.quiet), scores.quiet.record
    longest = min(0.5 / scores.data.period, 0.1 * len(scores.data))  # half a second
    late = np.unique(np.round(np.geomspace(1.0, max(longest, 2.0), 14)))
    return [
        hypothesis
        for name, values in record.signals.items()
        if name in {signal.name for signal in scores.data.axis.axis.signals}
        for hypothesis in (
            Hypothesis(
                kind="late signal",
                parameter=name,
                columns=partial(_of_late, by, record, name),
                places=np.concatenate([-late[::-1], late]),
                between=_between,
                is_whole=True,
            ),
            Hypothesis(
                kind="scaled signal",
                parameter=name,
                columns=partial(_once, -by(name, 1.001 * values)[:, None] / 1e-3),
            ),
        )
    ]


def _of_late(by: Callable[[str, Array], Array], record: Record, name: str, delays: Array) -> Array:
    """Rows, (n, m, 1), of what is lacking where a signal was logged so many samples late."""
    moved = np.repeat(record.channels()[name][None], len(delays), axis=0)
    for first, last in record.spans:
        at = np.arange(first, last, dtype=float)
        for own, late in zip(moved, delays, strict=True):  # it belongs earlier
            own[first:last] = np.interp(at + late, at, own[first:last])
    return -np.stack([by(name, own) for own in moved], axis=1)[:, :, None]


def _by_change(scores: RecordScores, data: FilteredRecord) -> Callable[[str, Array], Array]:
    """What rows leave more, (n,), where a record has other values of a column, by its role."""

    def left(**changed: Array) -> Array:
        record = data.record.with_channels({**data.record.channels(), **changed})
        rows = scores.form.equations(replace(data, record=record).signals).reduced(scores.data)
        return rows.residuals(scores.physical)

    whole = left()
    return lambda role, values: left(**{role: values}) - whole


def outliers_of(scores: RecordScores) -> list[Hypothesis]:
    """A pulse in each signal that was measured, about the row of which most is left.

    None without twins: the variance by HAC is that of the very samples.
    """
    if not scores.twins:
        return []
    data, residuals = scores.data, np.abs(scores.net_residuals)
    worst, (largest, *of_twins) = int(np.argmax(residuals[:, 0])), residuals.max(axis=0)
    # That noise leaves as much: by Gumbel's law of the twins' largest.
    spread = np.std(of_twins, ddof=1) * math.sqrt(6 * (1 + 1 / len(of_twins))) / math.pi
    beyond = (largest - np.mean(of_twins)) / spread + np.euler_gamma if spread else np.inf
    width = data.prefilter.decimate
    near = data.sampling.rows[worst] + np.round(np.linspace(-width, width, 5 if width > 1 else 3))
    by, columns = _by_change(scores, data), data.record.channels()
    return [
        Hypothesis(
            kind="outlier",
            parameter=role,
            unit=expected_units(role, data.axis.axis)[0],
            columns=partial(_pulses, by, columns[role], role),
            places=np.unique(np.clip(near, 0, len(data.record) - 1)),
            least=-math.expm1(-math.exp(-beyond)),
            between=_every_sample,
        )
        for role in ("position", "velocity", "acceleration", "force", "control")
        if role in columns and (role != "control" or data.record.force is None)
    ]


def _every_sample(grid: Array, at: float) -> Array:
    step = int(np.diff(grid).max(initial=0)) // 2
    return np.asarray(np.clip(np.arange(at - step, at + step + 1), grid[0], grid[-1]))


def _pulses(by: Callable[[str, Array], Array], values: Array, role: str, samples: Array) -> Array:
    """By a pulse of one in each sample of a column, (n, m, 1)."""
    pulse = 1e-4 * (float(np.std(values)) or 1.0)  # so small that it moves no sign
    alone = (pulse * (np.arange(len(values)) == sample) for sample in samples)
    return np.stack([by(role, values + each) / pulse for each in alone], axis=1)[:, :, None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Misspecification:
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
    unit : str
        Of its size; empty where none is told.
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

    @property
    def size(self) -> float:
        """How much of it there is, in its unit: of several columns that of all."""
        return self.values[0] if len(self.values) == 1 else float(np.linalg.norm(self.values))

    @property
    def check(self) -> str:
        """Name of the check that tells it: a signal, or a sample of one, may be wrong."""
        return _CHECKS.get(self.kind, "missing terms")


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


def scores_at(
    data: FilteredRecord, preferred: Estimate, *, by_loop: bool = False
) -> RecordScores | Missing:
    """Residuals of a record and of its twins at the judged estimate, as by `scores_of`."""
    chain = next(iter(preferred.inference.chains), None)
    at = preferred.physical if chain is None else preferred.corrected
    return scores_of(data, at, chain, range(len(at)), by_loop=by_loop)


@unless_missing
def find_misspecification(
    scores: RecordScores,
    half_widths: Array,
    records: int = 1,
    levels: Levels = DEFAULT_LEVELS,
) -> tuple[Misspecification, ...]:
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
    lasting = [(each, each.columns(each.places)) for each in hypotheses_of(scores)]
    # Without twins nothing tells what the filter itself moves the parameters by.
    half = half_widths[scores.free] if scores.twins else np.full(len(scores.free), np.inf)
    level, lacks = levels.level / records, list[Misspecification]()
    while len(lacks) < 3:
        every = [*lasting, *((each, each.columns(each.places)) for each in outliers_of(scores))]
        tests = [_tested(scores, *each, half, level / len(every)) for each in every]
        tests.sort(key=lambda each: each.p_value)
        holm = zip(tests, level / np.arange(len(tests), 0, -1), strict=True)
        # Any part of the force, or more than rounding and moves a parameter.
        most = max(
            (
                each
                for each, _ in takewhile(lambda pair: pair[0].p_value <= pair[1], holm)
                if each.share > levels.least_share
                or (each.moved > 1 and each.share > _NEGLIGIBLE_RESIDUAL)
            ),
            key=lambda each: each.share,
            default=None,
        )
        if most is None or (lacks and most.share <= levels.least_share):
            break
        found = _located(scores, most)
        lacks.append(_told(scores, found))
        scores = scores.with_columns(found.columns)
    return tuple(lacks)


def _tested(
    scores: RecordScores, hypothesis: Hypothesis, columns: Array, half: Array, sure: float
) -> TestedHypothesis:
    """It at the place that takes most of those that are sure, else at the surest."""
    tested = scores.test(columns)
    first, taken = tested.values[:, 0], tested.powers
    if hypothesis.is_whole:
        sizes = np.where(first == 0, np.inf, first)
        taken = taken * (2 / sizes - 1 / sizes**2)
    p_values = np.clip(tested.p_values * len(hypothesis.places), hypothesis.least, 1.0)
    p_values[hypothesis.is_positive & (first <= 0)] = 1.0
    told = p_values <= sure
    best = int(np.argmax(np.where(told, taken, -np.inf)) if told.any() else np.argmin(p_values))
    moved = np.abs(scores.moved_by(columns[:, best], tested.values[best]))
    far = np.divide(moved, half, out=np.zeros_like(moved), where=half > 0)
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
    columns = hypothesis.columns(near)
    best = (
        int(np.argmax(scores.test(columns).powers))
        if hypothesis.measured is None
        else scores.nearest(columns, hypothesis.measured(near))
    )
    if hypothesis.is_positive and scores.test(columns[:, [best]]).values[0, 0] <= 0:
        return found
    return replace(found, at=float(near[best]), columns=columns[:, best])


def _told(scores: RecordScores, name: TestedHypothesis) -> Misspecification:
    """What is found, as it is told: a change, a delay, a factor, or how much of each column.

    What a parameter is before it changes is told beside: the estimate is in between.
    """
    kind, parameter, columns = name.hypothesis.kind, name.hypothesis.parameter, name.columns
    tested = scores.test(columns[:, None])
    factors, covariance = tested.values[0], tested.covariances[0]
    values, begun, before = factors, 0.0, 0.0
    if kind == "late signal":
        step = name.hypothesis.columns(np.array([name.at - 0.5, name.at + 0.5])) @ factors
        slope = scores.test((step[:, 1:] - step[:, :1])[:, :, None])
        values, covariance = np.array([name.at]), slope.covariances[0]
    elif kind == "drift":  # from its lowest to its highest, in the order of time
        shapes = drifts(scores.data.times_of_rows)
        course = shapes @ factors
        first, last = sorted((int(np.argmin(course)), int(np.argmax(course))))
        change = shapes[last] - shapes[first]
        values, begun = np.array([change @ factors]), float(course[first])
        covariance = np.array([[change @ covariance @ change]])
    elif kind == "scaled signal":
        values = 1 + values
    names = [q.name for q in scores.data.axis.parameters]
    if parameter == GAIN:  # what it makes is on the other side
        values, before = -values, 1.0
    elif parameter in names:
        estimate = scores.physical.copy()
        estimate[scores.free] += scores.moved_by(columns, factors)
        before = float(estimate[names.index(parameter)] + begun)
    size = float(np.linalg.norm(values))
    return Misspecification(
        kind=kind,
        parameter=parameter,
        values=tuple(map(float, values)),
        deviation=math.sqrt(max(float(values @ covariance @ values), 0.0)) / (size or 1.0),
        before=before,
        at=name.at,
        share=float(np.linalg.norm(columns @ factors) / (np.linalg.norm(scores.force) or 1.0)),
        own_share=name.share,
        p_value=name.p_value,
        unit=name.hypothesis.unit,
    )


def sentence(lack: Misspecification, axis: GeneratedAxis, record: Record) -> str:
    """What is missing, changes or is logged wrongly, how much of it, and what to do about it."""
    size, deviation, unit = lack.size, lack.deviation, lack.unit
    kind, name, share = lack.kind, lack.parameter, f"{100 * lack.share:.2g} % of the force is this"
    part = share if lack.share <= 1 else "this is more than the force"
    by = f"{size:+.3g} +- {deviation:.1g} {unit}".rstrip()
    if not name:
        term, drive = TERMS[kind], axis.axis.drive
        what, advice = term.opposite if term.opposite and size < 0 else (term.what, term.declare)
        if kind == "stribeck" and axis.axis.has_stribeck:
            advice = "another velocity or exponent of stribeck"
        words = {
            "q": axis.axis.coordinate.name,
            "unit": axis.axis.coordinate.unit,
            "drive": drive.unit,
            "at": lack.at,
            "rigid": lack.at / 3,  # of an antiresonance
            "band": drive.deadband + size / abs(drive.gain) if kind == "dead band" else 0.0,
        }
        return f"{what}{f', {by}' * bool(unit)}: {advice} ({part})".format(**words)
    changed = by + (f" ({100 * size / lack.before:+.2g} %)" if lack.before else "")
    sample = int(lack.at) if kind == "outlier" else 0
    return first_case(
        (
            kind == "scaled signal",
            f"the model needs {size:.4g} +- {deviation:.1g} times the recorded {name} ({part})",
        ),
        (
            kind == "late signal",
            f"the {name} is logged {abs(size):.4g} +- {max(deviation, 0.01):.1g} samples "
            f"({1e3 * abs(size) * record.period:.4g} ms) {'late' if size > 0 else 'early'} beside "
            f"the force that it makes ({part})",
        ),
        (
            kind == "outlier",
            f"the {name} leaves its course by {size:+.3g} +- {deviation:.1g} {unit} at sample "
            f"{sample + 1}, {record.time[sample] - record.time[0]:.6g} s after the first ({part})",
        ),
        (
            kind == "held",
            f"another {name} than was given, {by[1:]} {'more' if size > 0 else 'less'}",
        ),
        (
            kind == "drift",
            f"{name} changes with time, by {changed} over the record, little by little: record "
            "when the axis is warm, or identify parts of the record by themselves",
        ),
        (
            True,
            f"{name} changes by {changed} from about {lack.at:.3g} s on: identify what is before "
            "and after by itself, or find what was changed there",
        ),
    )
