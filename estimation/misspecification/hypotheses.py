"""What a model may lack: columns beside it, each with a name and where it has places.

Terms of the motion, parameters that change in time, recorded signals that are late or of another
unit, and single samples of a signal that leave their course.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from axisid.estimation.records import Record
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array
from axisid.support.errors import CandidateError, quoted

from .scores import RecordScores
from .terms import TERMS, Along, Term

#: What stands for a parameter where it is the drive's gain that changes.
GAIN = "the drive gain"


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
    is_lost : bool
        Whether they are a part of the force that was not given.
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
    is_lost: bool = False


def hypotheses_of(scores: RecordScores) -> list[Hypothesis]:
    """All that is looked for: terms of the motion, what is held or changes in time, signals."""
    data = scores.data
    axis, drive = data.axis, data.axis.drive
    commanded = data.record.force is None and drive.is_gain and not drive.logs_what_acts
    is_turning = axis.coordinate.unit == "rad"
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
            is_whole=term.is_lost,
            is_lost=term.is_lost,
        )
        for term in TERMS.values()
        if (is_turning or term.kind != "turn")
        and (commanded or not term.is_of_command)
        and (scores.twins or not term.is_of_force)
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
_VALUES_AT_ONCE = 2**19  # of candidates' columns at all samples: 4 MB


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
    """Return the columns of a term, (n, m, g), which may be a user's own and of another shape.

    Raises
    ------
    CandidateError
        They are not blocks of at most `most` finite columns for each place.
    """
    # A few places at a time: columns of all samples at every place would take much memory.
    few = max(1, _VALUES_AT_ONCE // len(along.time))
    parts = [places[first : first + few] for first in range(0, len(places), few)] or [places]
    each, rows = [_of_user(term, term.columns, along, part) for part in parts], len(along.place)
    wanted = [(rows, len(part), *each[0].shape[2:]) for part in parts]
    is_block = [columns.shape for columns in each] == wanted and each[0].ndim == 3
    found = np.concatenate(each, axis=1) if is_block else each[0]
    finite = bool((np.abs(found) < _HUGE).all())
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
        if name in {signal.name for signal in scores.data.axis.signals}
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
