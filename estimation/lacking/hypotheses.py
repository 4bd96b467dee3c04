"""Hypotheses of what a model may lack: columns beside it, each with a name and where it has places.

Terms of the motion, parameters that change in time, recorded signals that are late or of another
unit, and single samples of a signal that leave its course.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.special import stdtr

from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError
from axisid.support.user_values import quoted

from .scores import ColumnTests, RecordScores
from .terms import Along, Term, terms_for

#: What stands for a parameter where it is the drive's gain that changes.
GAIN = "the drive gain"

_TIMES = 15  # of a change, in the middle 70 % of the record
_TRIMMED = 0.15
_LONGEST = 0.5  # s, of a signal's delay
_DELAYS = 14  # of either sign
_STEP = 1e-3  # of a factor
_FINER = 65  # places between those of a grid, once it is told

_PULSE = 1e-4  # of a signal's size: so small that it moves no sign
_PLACES = 5  # from one row to the next but one


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hypothesis:
    """Columns that a model may lack.

    Attributes
    ----------
    kind : str
    columns : callable
        Of places (m,): (n, m, g).
    parameter : str
        As of `Lack`.
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
    """

    kind: str
    columns: Callable[[Array], Array]
    parameter: str = ""
    places: Array = field(default_factory=lambda: np.array([np.nan]))
    measured: Callable[[Array], Array] | None = None
    between: Callable[[Array, float], Array] | None = None
    is_positive: bool = False
    least: float = 0.0
    is_whole: bool = False

    def taken(self, tested: ColumnTests) -> Array:
        """Mean square that each place takes of the residuals, (m,)."""
        if not self.is_whole:
            return tested.powers
        values = np.where(tested.values[:, 0] == 0, np.inf, tested.values[:, 0])
        return np.asarray(tested.powers * (2 / values - 1 / values**2))

    def chances(self, tested: ColumnTests) -> Array:
        """That noise has as much of it at each place, over all of them, (m,)."""
        told = np.clip(tested.p_values * len(self.places), self.least, 1.0)
        return np.where(tested.values[:, 0] <= 0, 1.0, told) if self.is_positive else told


def hypotheses_of(scores: RecordScores) -> list[Hypothesis]:
    """All that is looked for: terms of the motion, what is held or changes in time, signals."""
    data = scores.data
    axis, drive = data.axis.axis, data.axis.axis.drive
    commanded = data.record.force is None and drive.is_gain and not drive.logs_what_acts
    terms = terms_for(axis, commanded=commanded)
    found = [_of_term(scores, t) for t in terms if scores.twins or not t.is_of_force]
    if held := _held(scores):  # of what is declared the parameter is told, not the term
        declared = scores.beside(np.hstack([each.columns(each.places)[:, 0] for each in held]))
        own = [declared.test(each.columns(each.places)).values.any() for each in found]
        found = [each for each, is_own in zip(found, own, strict=True) if is_own]
    found += held
    found += _changing(scores, commanded=commanded and bool(scores.twins))
    found += _of_signals(scores) if axis.signals else []
    return [each for each in found if len(each.places)]


def _of_term(scores: RecordScores, term: Term) -> Hypothesis:
    most = scores.twins - 1 if scores.twins else len(scores.along.place)
    return Hypothesis(
        kind=term.kind,
        places=_of_user(term, lambda: term.places(scores.along)),
        columns=partial(_columns, term, most, scores.along),
        measured=partial(_columns, term, most, scores.measured),
        between=None if term.between is None else partial(_near, term, term.between),
        is_positive=term.is_positive,
    )


def _near(term: Term, between: Callable[[Array, float], Array], grid: Array, at: float) -> Array:
    """Places about one of a term's grid; that one where it gives none."""
    found = _of_user(term, lambda: between(grid, at))
    return found if found.ndim == 1 and len(found) else np.array([at])


def _of_user(term: Term, made: Callable[[], Array]) -> Array:
    """What a term makes, which may be a user's own and raise."""
    try:
        return np.asarray(made(), dtype=float)
    except Exception as error:
        said = f"{type(error).__name__}: {error}".rstrip(": ")
        raise EstimationError(
            f"the candidate {quoted(term.kind)} makes no columns or places ({said}); mend it, or "
            "take it out of axisid.candidates.TERMS.",
            code="candidate-raises",
        ) from error


def _columns(term: Term, most: int, along: Along, places: Array) -> Array:
    """Columns of a term, (n, m, g), which a user's own may give otherwise; so many at most."""
    found = _of_user(term, lambda: term.columns(along, places))
    rows, finite = len(along.place), bool(np.isfinite(found).all())
    is_block = found.ndim == 3 and found.shape[:2] == (rows, len(places))
    if not (is_block and 0 < found.shape[2] <= most and finite):
        raise EstimationError(
            f"the columns of the candidate {quoted(term.kind)} have the shape {found.shape}"
            f"{', and are not all finite' * (not finite)}; give finite ones of {rows} rows, "
            f"{len(places)} places and one or a few of each, {most} at most, as "
            "motion.reduce(force)[:, None, None] for a force without places.",
            code="candidate-columns",
        )
    return found


def _held(scores: RecordScores) -> list[Hypothesis]:
    """Parameters that have a value which the record did not tell."""
    return [
        Hypothesis(kind="held", parameter=q.name, columns=partial(_once, scores.regressor[:, [j]]))
        for j, q in enumerate(scores.data.axis.parameters)
        if j not in scores.free
    ]


def _changing(scores: RecordScores, *, commanded: bool) -> list[Hypothesis]:
    """Each parameter, and the drive gain, as it drifts or is another from some time on."""
    of = {q.name: scores.regressor[:, j] for j, q in enumerate(scores.data.axis.parameters)}
    if commanded:
        of[GAIN] = scores.along.reduce(scores.along.force)
    times = scores.data.times_of_rows
    places = times[0] + (times[-1] - times[0]) * np.linspace(_TRIMMED, 1 - _TRIMMED, _TIMES)
    found = []
    for name, column in of.items():
        if not column.any():  # nothing that these rows could show of it changes
            continue
        drifting = partial(_once, column[:, None] * drifts(times))
        stepping = partial(_from, column, times)
        found += [
            Hypothesis(kind="drift", parameter=name, columns=drifting),
            Hypothesis(
                kind="change", parameter=name, columns=stepping, places=places, between=_between
            ),
        ]
    return found


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
    return np.linspace(grid[max(place - 1, 0)], grid[min(place + 1, len(grid) - 1)], _FINER)


def _of_signals(scores: RecordScores) -> list[Hypothesis]:
    """Each recorded signal that makes a force, late or early, and of another size."""
    rows = _ChangedRows(scores, scores.quiet)
    longest = min(_LONGEST / scores.data.period, 0.1 * len(scores.data))
    late = np.unique(np.round(np.geomspace(1.0, max(longest, 2.0), _DELAYS)))
    delays = np.concatenate([-late[::-1], late])
    found = []
    for signal in scores.data.axis.axis.signals:
        larger = (1 + _STEP) * rows.columns[signal.name]
        scaled = -rows.by(signal.name, larger)[:, None] / _STEP
        found += [
            Hypothesis(
                kind="late signal",
                parameter=signal.name,
                columns=partial(_of_late, rows, signal.name),
                places=delays,
                between=_between,
                is_whole=True,
            ),
            Hypothesis(kind="scaled signal", parameter=signal.name, columns=partial(_once, scaled)),
        ]
    return found


def _of_late(rows: "_ChangedRows", name: str, delays: Array) -> Array:
    """Rows, (n, m, 1), of what is lacking where a signal was logged so many samples late."""
    moved = np.repeat(rows.columns[name][None], len(delays), axis=0)
    for first, last in rows.data.record.spans:
        at = np.arange(first, last, dtype=float)
        for own, late in zip(moved, delays, strict=True):  # it belongs earlier
            own[first:last] = np.interp(at + late, at, own[first:last])
    return -np.stack([rows.by(name, own) for own in moved], axis=1)[:, :, None]


class _ChangedRows:
    """What is left of rows more where a column of a record is another.

    Attributes
    ----------
    data : FilteredRecord
    columns : dict of str to (N,) array
        Of its record, by role, and recorded signals by name.
    """

    def __init__(self, scores: RecordScores, data: FilteredRecord) -> None:
        self._scores, self.data = scores, data
        self.columns = data.record.channels()
        self._left = self._of({})

    def by(self, role: str, values: Array) -> Array:
        """Of each row, (n,)."""
        return np.asarray(self._of({role: values}) - self._left)

    def _of(self, changed: dict[str, Array]) -> Array:
        scores, record = self._scores, self.data.record
        other = replace(self.data, record=record.with_channels({**self.columns, **changed}))
        rows = scores.form.equations(other.signals).reduced(scores.data)
        left = rows.left - rows.intercept - rows.regressor @ scores.physical
        return np.asarray(left, dtype=float)


def outliers_of(scores: RecordScores) -> list[Hypothesis]:
    """A pulse in each signal that was measured, about the row of which most is left.

    None without twins: the variance by HAC is that of the very samples.
    """
    if not scores.twins:
        return []
    data = scores.data
    rows = data.row_numbers.astype(np.int64)
    left = np.abs(scores.nets)
    worst, chance = int(np.argmax(left[:, 0])), _chance(left.max(axis=0))
    width = data.prefilter.decimate
    near = np.round(np.linspace(-width, width, _PLACES if width > 1 else 3))
    places = np.clip(rows[worst] + near, 0, len(data.record) - 1)
    changed = _ChangedRows(scores, data)
    hidden = {"control"} if data.record.force is not None else set()
    return [
        Hypothesis(
            kind="outlier",
            parameter=role,
            columns=partial(_pulses, changed, role),
            places=np.unique(places),
            least=chance,
            between=_every_sample,
        )
        for role in ("position", "velocity", "acceleration", "force", "control")
        if role in changed.columns.keys() - hidden
    ]


def _chance(largest: Array) -> float:
    """That noise leaves as much in the row of which most is left: by twins', log-normal."""
    sizes = np.log(np.maximum(largest, np.finfo(float).tiny))
    own, twins = sizes[0], sizes[1:]
    spread = float(np.std(twins, ddof=1)) * math.sqrt(1 + 1 / len(twins))
    beyond = (own - twins.mean()) / spread if spread else np.inf
    return float(stdtr(len(twins) - 1, -beyond))


def _every_sample(grid: Array, at: float) -> Array:
    step = int(np.diff(grid).max(initial=0)) // 2
    return np.asarray(np.clip(np.arange(at - step, at + step + 1), grid[0], grid[-1]))


def _pulses(rows: _ChangedRows, role: str, samples: Array) -> Array:
    """By a pulse of one in each sample of a column, (n, m, 1)."""
    values = rows.columns[role]
    pulse = _PULSE * (float(np.std(values)) or 1.0)
    alone = (pulse * (np.arange(len(values)) == sample) for sample in samples)
    return np.stack([rows.by(role, values + each) / pulse for each in alone], axis=1)[:, :, None]
