"""Hypotheses on a misspecified model: additional columns with a name and a grid of places.

The place of a hypothesis is the number that its columns depend on nonlinearly: a speed, a period, a
frequency, a force, a time or a delay. Each place of the grid is tested.

The hypotheses are terms of the motion, parameters that change in time, recorded signals that are
late or in another unit, and single samples of a signal that are outliers.
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
from axisid.support.errors import CandidateError
from axisid.support.wording import quoted

from .scores import RecordScores
from .terms import TERMS, Along, Term

#: Name instead of a parameter, if the gain of the drive changes.
GAIN = "the drive gain"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hypothesis:
    """Columns that the model may lack, with a grid of places at which they are tested.

    Attributes
    ----------
    kind : str
        Kind of hypothesis: the name of a term in `TERMS`, or ``held``, ``drift``, ``change``,
        ``late signal``, ``scaled signal`` or ``outlier``.
    columns : callable
        Returns g columns in the n rows for each of m places, from the places (m,): (n, m, g).
    parameter : str
        Parameter, signal or column that the hypothesis is on; empty for a term.
    places : (m,) array
        Grid of places, such as speeds, periods or times; NaN for a hypothesis without a place.
    measured : callable or None
        Returns the columns of the measured motion, with which the best place between the places of
        the grid is found; None if `columns` are used for this search.
    between : callable or None
        Returns places near a place of the grid, from the grid and this place, for the refined
        search about a significant place; None if the grid is not refined.
    is_positive : bool
        True if the factor of the columns must be positive, as for friction or a mass.
    least : float
        Lower limit of the p-value, for places that were chosen by the residuals.
    is_whole : bool
        True if the missing force is the column itself, with a factor of 1, so that the place alone
        determines its size.
    is_lost : bool
        True if the columns are a part of the commanded force that the drive did not give.
    unit : str
        Unit of the factor; empty if no size is reported.
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
    """Return all hypotheses that the record can show, except outliers.

    They are missing terms, parameters with a wrong given value, parameters that change in time, and
    recorded signals that are late or scaled wrongly.
    """
    data = scores.data
    axis, drive = data.axis, data.axis.drive
    commanded = data.record.force is None and drive.is_gain and not drive.logs_what_acts
    is_turning = axis.coordinate.unit == "rad"
    # Terms of the table that apply to this axis, with their columns along the motion. A term may
    # have fewer columns than there are replicas, as their scores give a covariance.
    most = scores.twins - 1 if scores.twins else len(scores.along.place)
    found = [
        Hypothesis(
            kind=term.kind,
            unit=term.unit.format(force=axis.coordinate.force_unit, unit=axis.coordinate.unit),
            places=_called(term, term.places, scores.along),
            columns=partial(_columns, term, most, scores.along),
            measured=partial(_columns, term, most, scores.measured),
            between=None if term.between is None else partial(_called, term, term.between),
            is_positive=term.is_positive,
            is_whole=term.is_lost,
            is_lost=term.is_lost,
        )
        for term in TERMS.values()
        if (is_turning or term.kind != "turn")
        and (commanded or not term.is_of_command)
        and (scores.twins or not term.is_of_force)
    ]
    held = [  # parameters with a value that was not estimated from the record
        Hypothesis(
            kind="held",
            parameter=q.name,
            unit=str(q.unit),
            columns=partial(_at_single_place, scores.regressor[:, [j]]),
        )
        for j, q in enumerate(data.axis.parameters)
        if j not in scores.free
    ]
    # A term whose columns these parameters span is tested as the parameter.
    if held:
        declared = scores.with_columns(
            np.hstack([each.columns(each.places)[:, 0] for each in held])
        )
        found = [e for e in found if declared.test(e.columns(e.places)).values.any()]
    # Parameters that change in time, and faulty recorded signals.
    changing = _changing(scores, commanded=commanded and bool(scores.twins))
    of_signals = _of_signals(scores) if axis.signals else []
    return [each for each in (*found, *held, *changing, *of_signals) if len(each.places)]


_HUGE = 1e100  # its square is still finite
_VALUES_AT_ONCE = 2**19  # of candidates' columns at all samples: 4 MB


def _called(term: Term, function: Callable[..., Array], *arguments: Any) -> Array:
    """Return the result of a term's function for some arguments, as an array.

    The term may be a user's own. If the function fails, the error names the term.

    Raises
    ------
    CandidateError
        The function raised an error.
    """
    try:
        with np.errstate(all="ignore"):
            return np.atleast_1d(np.asarray(function(*arguments), dtype=float))
    except MemoryError:
        raise
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".rstrip(": ")
        raise CandidateError(
            f"the candidate {quoted(term.kind)} cannot return its columns or places ({reason}). "
            "Correct its functions, or remove the candidate from axisid.candidates.TERMS.",
        ) from error


def _columns(term: Term, most: int, along: Along, places: Array) -> Array:
    """Return the columns of a term at places (m,), (n, m, g), checked for their shape and size.

    Parameters
    ----------
    term : Term
        A built-in term or a user's own.
    most : int
        Largest number g of columns for each place.
    along : Along
        Motion that the columns are made from.
    places : (m,) array

    Raises
    ------
    CandidateError
        The columns are not an array (n, m, g) of finite numbers with at most `most` columns for
        each place.
    """
    # A few places at a time: columns of all samples at every place would take much memory.
    few = max(1, _VALUES_AT_ONCE // len(along.time))
    parts = [places[first : first + few] for first in range(0, len(places), few)] or [places]
    each, rows = [_called(term, term.columns, along, part) for part in parts], len(along.place)
    # The columns of all places, if those of each part have the shape (rows, places of the part, g).
    wanted = [(rows, len(part), *each[0].shape[2:]) for part in parts]
    is_block = [columns.shape for columns in each] == wanted and each[0].ndim == 3
    found = np.concatenate(each, axis=1) if is_block else each[0]
    finite = bool((np.abs(found) < _HUGE).all())
    if not (is_block and found.size and found.shape[2] <= most and finite):
        raise CandidateError(
            f"the columns of the candidate {quoted(term.kind)} have the shape {found.shape}"
            f"{f', and are not all below {_HUGE:g}' * (not finite)}. Return an array of {rows} "
            f"rows, {len(places)} places, and 1 to {most} columns for each place, such as "
            "motion.reduce(force)[:, None, None] for a force without places.",
        )
    return found


def _changing(scores: RecordScores, *, commanded: bool) -> list[Hypothesis]:
    """Return hypotheses of a drift and of a step in time, for each parameter and the drive gain.

    The drive gain is included if `commanded` is True: the force is then the gain times the recorded
    control.
    """
    # Column of each parameter in the rows, by its name and unit. The column of the drive gain is
    # the force along the motion, filtered and decimated to the rows: a relative change of the gain
    # scales this force.
    columns = {
        (q.name, str(q.unit)): column
        for q, column in zip(scores.data.axis.parameters, scores.regressor.T, strict=True)
    }
    if commanded:
        columns[GAIN, "times"] = scores.along.reduce(scores.along.force)
    # The places are candidate times of a step, in the middle part of the record. `between` gives
    # the times near the best of them, among which the time of the step is refined.
    times = scores.data.times_of_rows
    step_times = times[0] + (times[-1] - times[0]) * np.linspace(0.15, 0.85, 15)
    hypotheses: list[Hypothesis] = []
    for (name, unit), column in columns.items():
        if not column.any():  # these rows cannot show a change of a zero column
            continue
        hypotheses += [
            Hypothesis(
                kind="drift",
                parameter=name,
                unit=unit,
                columns=partial(_at_single_place, column[:, None] * drifts(times)),
            ),
            Hypothesis(
                kind="change",
                parameter=name,
                unit=unit,
                columns=partial(_steps_at, column, times),
                places=step_times,
                between=_places_between,
            ),
        ]
    return hypotheses


def drifts(times: Array) -> Array:
    """Return the shapes of a drift over the times of the rows, (n,), as three columns, (n, 3).

    They are a line from 0 to 1, and sine and cosine with the length of the record as period.
    """
    part = (times - times[0]) / (times[-1] - times[0])
    return np.column_stack([part, np.sin(2 * np.pi * part), np.cos(2 * np.pi * part)])


def _at_single_place(columns: Array, _: Array) -> Array:
    """Return columns, (n, g), as the columns of a hypothesis without places, (n, 1, g)."""
    return columns[:, None]


def _steps_at(column: Array, times: Array, places: Array) -> Array:
    """Return a column, (n,), set to zero before each of m times, (n, m, 1).

    `times`, (n,), are the times of the rows, and `places`, (m,), the times of the steps.
    """
    return np.where(times[:, None] >= places, column[:, None], 0.0)[:, :, None]


def _places_between(grid: Array, at: float) -> Array:
    """Return 65 equally spaced places between the two neighbours of the grid's place `at`."""
    place = int(np.argmin(np.abs(grid - at)))
    return np.linspace(grid[max(place - 1, 0)], grid[min(place + 1, len(grid) - 1)], 65)


def _of_signals(scores: RecordScores) -> list[Hypothesis]:
    """Return hypotheses of a delay and of a wrong scale, for each recorded signal of the model."""
    change_by, record = _residual_change(scores, scores.quiet), scores.quiet.record
    longest = min(0.5 / scores.data.period, 0.1 * len(scores.data))  # half a second
    late = np.unique(np.round(np.geomspace(1.0, max(longest, 2.0), 14)))
    declared = {signal.name for signal in scores.data.axis.signals}
    hypotheses: list[Hypothesis] = []
    for name, values in record.signals.items():
        if name not in declared:
            continue
        by_scale = -change_by(name, 1.001 * values)[:, None] / 1e-3
        hypotheses += [
            Hypothesis(
                kind="late signal",
                parameter=name,
                columns=partial(_force_by_delays, change_by, record, name),
                places=np.concatenate([-late[::-1], late]),
                between=_places_between,
                is_whole=True,
            ),
            Hypothesis(
                kind="scaled signal",
                parameter=name,
                columns=partial(_at_single_place, by_scale),
            ),
        ]
    return hypotheses


def _force_by_delays(
    change_by: Callable[[str, Array], Array], record: Record, name: str, delays: Array
) -> Array:
    """Return the missing force in the rows if a recorded signal is late, (n, m, 1).

    Parameters
    ----------
    change_by : callable
        Returns the change of the residual, (n,), by other values of a column, see
        `_residual_change`.
    record : Record
    name : str
        Name of the signal.
    delays : (m,) array
        Delays of the signal, samples.
    """
    # The signal with each delay removed, within each stretch between gaps.
    moved = np.repeat(record.channels()[name][None], len(delays), axis=0)
    for first, last in record.spans:
        at = np.arange(first, last, dtype=float)
        for own, late in zip(moved, delays, strict=True):  # a late signal is moved earlier
            own[first:last] = np.interp(at + late, at, own[first:last])
    return -np.stack([change_by(name, own) for own in moved], axis=1)[:, :, None]


def _residual_change(scores: RecordScores, data: FilteredRecord) -> Callable[[str, Array], Array]:
    """Return a function that returns the change of the residual, (n,), by a changed column.

    The arguments of that function are the name of the column and its other values, (N,). `data` is
    the record whose column is changed.
    """

    def residuals_with(**changed: Array) -> Array:
        """Return the residual of the model, (n,), with some columns of the record changed."""
        record = data.record.with_channels({**data.record.channels(), **changed})
        rows = scores.form.equations(replace(data, record=record).signals).reduced(scores.data)
        return rows.residuals(scores.physical)

    unchanged = residuals_with()
    return lambda role, values: residuals_with(**{role: values}) - unchanged


def outliers_of(scores: RecordScores) -> list[Hypothesis]:
    """Return the hypothesis of an outlier in each measured column, near the largest residual.

    The column of a hypothesis is the effect of a unit pulse in one sample. Its places are samples
    about the row with the largest residual. Their p-values are not below the probability of such a
    residual by noise. Empty without replicas, because a HAC variance contains the outliers
    themselves.
    """
    if not scores.twins:
        return []
    data, residuals = scores.data, np.abs(scores.net_residuals)
    worst = int(np.argmax(residuals[:, 0]))
    largest, *of_twins = residuals.max(axis=0)
    # Probability of such a residual by noise, by Gumbel's distribution of a largest value: it is
    # fitted to the largest residuals of the replicas.
    spread = np.std(of_twins, ddof=1) * math.sqrt(6 * (1 + 1 / len(of_twins))) / math.pi
    beyond = (largest - np.mean(of_twins)) / spread + np.euler_gamma if spread else np.inf
    width = data.prefilter.decimate
    near = data.sampling.rows[worst] + np.round(np.linspace(-width, width, 5 if width > 1 else 3))
    change_by, columns = _residual_change(scores, data), data.record.channels()
    return [
        Hypothesis(
            kind="outlier",
            parameter=role,
            columns=partial(_pulses, change_by, columns[role], role),
            places=np.unique(np.clip(near, 0, len(data.record) - 1)),
            least=-math.expm1(-math.exp(-beyond)),
            between=_every_sample,
        )
        for role in ("position", "velocity", "acceleration", "force", "control")
        if role in columns and (role != "control" or data.record.force is None)
    ]


def _every_sample(grid: Array, at: float) -> Array:
    """Return every sample within half a step of the grid about the sample `at`."""
    step = int(np.diff(grid).max(initial=0)) // 2
    return np.asarray(np.clip(np.arange(at - step, at + step + 1), grid[0], grid[-1]))


def _pulses(
    change_by: Callable[[str, Array], Array], values: Array, role: str, samples: Array
) -> Array:
    """Return the change of the residual by a unit pulse in one sample of a column, (n, m, 1).

    Parameters
    ----------
    change_by : callable
        Returns the change of the residual, (n,), by other values of a column, see
        `_residual_change`.
    values : (N,) array
        Recorded values of the column.
    role : str
        Role of the column.
    samples : (m,) array
        Samples of the pulses, one for each place.
    """
    pulse = 1e-4 * (float(np.std(values)) or 1.0)  # too small to change a sign of the velocity
    alone = (pulse * (np.arange(len(values)) == sample) for sample in samples)
    changes = [change_by(role, values + each) / pulse for each in alone]
    return np.stack(changes, axis=1)[:, :, None]
