"""What uneven sampling does to an estimate: the same rows at even times, by the record's stamps.

A record is taken as sampled evenly. Where its stamps say otherwise, its columns are interpolated
to the even times that fit them best, position and reference by cubic splines, the others by
straight lines, as `--resample` does; the estimate of that, by the same instruments, is held beside
its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.records import Record
from axisid.estimation.regression import Form
from axisid.support.arrays import Array, relative_error_percent

from .problem import Problem
from .solver import Solver


@dataclass(frozen=True, slots=True, kw_only=True)
class EvenTimes:
    """An estimate from records that are interpolated to even times.

    Attributes
    ----------
    physical : (p,) array
    equation_error_percent : float
        Of that.
    own_error_percent : float
        Of the records as they are, by the same regression.
    """

    physical: Array
    equation_error_percent: float
    own_error_percent: float


def jitter_of(record: Record) -> Array:
    """How far the samples of a record are from even times, (N,), s: what a line leaves of them."""
    pieces = []
    for first, last in record.spans:
        count, own = np.arange(last - first, dtype=float), record.time[first:last]
        pieces.append(own - np.polyval(np.polyfit(count, own - own[0], 1), count) - own[0])
    return np.concatenate(pieces)


def at_even_times(problem: Problem, form: Form, solver: Solver) -> EvenTimes:
    """Estimate from the records at even times.

    Parameters
    ----------
    problem : Problem
    form : Form
        Of the estimate, at its point.
    solver : callable
        Of the estimate.

    Raises
    ------
    DataError, EstimationError
        The interpolated records cannot be filtered or solved.
    """
    own = problem.reduced(form, [data.signals for data in problem.data])
    even = [replace(data, record=evenly(data.record)) for data in problem.data]
    rows = problem.reduced(form, [data.signals for data in even])
    solution = solver(form, rows)
    return EvenTimes(
        physical=form.physical(solution.theta)[0],
        equation_error_percent=relative_error_percent(solution.residuals, rows.left),
        own_error_percent=relative_error_percent(solver(form, own).residuals, own.left),
    )


def evenly(record: Record, roles: Sequence[str] = ()) -> Record:
    """A record at the even times that fit its own best, by its stamps.

    Parameters
    ----------
    record : Record
    roles : sequence of str
        The columns that are moved there; all by default. Position and reference go by cubic
        splines, as does what was added to the reference, and others by straight lines.
    """
    from scipy.interpolate import CubicSpline

    even = record.time - jitter_of(record)
    splined = ("position", "reference") + ("injected",) * (record.injected_at == "reference")
    columns = {**record.channels()}
    for name in columns.keys() & {*(roles or columns)} - {"time"}:
        values, moved = columns[name], np.empty(len(record))
        for first, last in record.spans:
            at, own, piece = even[first:last], record.time[first:last], values[first:last]
            moved[first:last] = (
                CubicSpline(own, piece)(at) if name in splined else np.interp(at, own, piece)
            )
        columns[name] = moved
    return record.with_channels(columns)
