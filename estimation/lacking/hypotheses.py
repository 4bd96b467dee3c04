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

from axisid.estimation.signals import about_samples
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
        blocks = [declared.block(each.columns(each.places)) for each in found]
        own = [declared.test(block).values.any() for block in blocks]
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
    rows = _SignalRows(scores)
    longest = min(_LONGEST / scores.data.period, 0.1 * len(scores.data))
    late = np.unique(np.round(np.geomspace(1.0, max(longest, 2.0), _DELAYS)))
    delays = np.concatenate([-late[::-1], late])
    found = []
    for j, signal in enumerate(scores.data.axis.axis.signals):
        late_by, scaled = partial(rows.late, j), partial(_once, rows.scaled(j)[:, None])
        found += [
            Hypothesis(
                kind="late signal",
                parameter=signal.name,
                columns=late_by,
                places=delays,
                between=_between,
                is_whole=True,
            ),
            Hypothesis(kind="scaled signal", parameter=signal.name, columns=scaled),
        ]
    return found


def _moved(late: float, values: Array, at: Array) -> Array:
    return np.interp(at + late, at, values)


class _SignalRows:
    """What a model makes of recorded signals that are moved or scaled, less of them as they are."""

    def __init__(self, scores: RecordScores) -> None:
        self._scores = scores
        self._made = self._of(scores.signals.recorded)

    def late(self, index: int, samples: Array) -> Array:
        """Rows, (n, m, 1), of what is lacking where a signal was logged so late."""
        moved = (
            self._changed(index, partial(_moved, late))  # it belongs earlier
            for late in samples
        )
        return np.stack([*moved], axis=1)[:, :, None]

    def scaled(self, index: int) -> Array:
        """Rows, (n,), by a factor of a signal."""
        return self._changed(index, lambda values, _: (1 + _STEP) * values) / _STEP

    def _changed(self, index: int, change: Callable[[Array, Array], Array]) -> Array:
        recorded = list(self._scores.signals.recorded)
        values = recorded[index].copy()
        for first, last in self._scores.data.record.spans:
            at = np.arange(first, last, dtype=float)
            values[first:last] = change(values[first:last], at)
        recorded[index] = values
        return self._scores.data.reduce(self._of(tuple(recorded)) - self._made)

    def _of(self, recorded: tuple[Array, ...]) -> Array:
        """What the model leaves to the force, less the drive's own, at each sample, (N,)."""
        scores = self._scores
        made = scores.form.equations(replace(scores.signals, recorded=recorded))
        needed = made.intercept + made.regressor @ scores.physical
        return np.asarray(needed - self._driven(recorded), dtype=float)

    def _driven(self, recorded: tuple[Array, ...]) -> Array:
        """The force of the recorded control, (N,), where that is what was recorded."""
        data, s = self._scores.data, self._scores.signals
        if data.record.force is not None or data.acting_control is None:
            return np.zeros(len(s.position))
        motion = s.position, s.velocity, s.acceleration
        force = data.drive.force(data.acting_control, motion, recorded)
        if data.prefilter.hold != "zoh":
            return force
        return about_samples(force, [first for first, _ in data.record.spans])


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
    pulses = _Pulses(scores)
    return [
        Hypothesis(
            kind="outlier",
            parameter=role,
            columns=partial(pulses.columns, role),
            places=np.unique(places),
            least=chance,
            between=_every_sample,
        )
        for role in ("position", "velocity", "acceleration", "force", "control")
        if role in pulses.signals
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


class _Pulses:
    """What is left of rows by a pulse of one in one sample of a signal."""

    def __init__(self, scores: RecordScores) -> None:
        self._scores = scores
        record = scores.data.record
        every = record.channels()
        hidden = {"control"} if record.force is not None else set()
        self.signals = {role: v for role, v in every.items() if role not in hidden}
        self._left = self._of({})

    def columns(self, role: str, samples: Array) -> Array:
        """Of each sample, (n, m, 1)."""
        return np.stack([self._by(role, int(sample)) for sample in samples], axis=1)[:, :, None]

    def _by(self, role: str, sample: int) -> Array:
        values = self.signals[role].copy()
        pulse = _PULSE * (float(np.std(values)) or 1.0)
        values[sample] += pulse
        return np.asarray((self._of({role: values}) - self._left) / pulse)

    def _of(self, changed: dict[str, Array]) -> Array:
        """Residuals, (n,), of a record with other values."""
        scores = self._scores
        data = replace(scores.data, record=scores.data.record.with_motion(changed))
        rows = scores.form.equations(data.signals).reduced(data)
        left = rows.left - rows.intercept - rows.regressor @ scores.physical
        return np.asarray(left, dtype=float)
