"""Repair of columns that a logger wrote too early or too late, or not in every sample.

A drive that measures its velocity every fourth cycle writes one value into four samples, or leaves
three of them empty. A velocity that is held for four samples is one and a half samples late on
average.
"""

import math
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.findings import Finding
from axisid.estimation.raw_tables import Repair, Samples, exact_unit
from axisid.estimation.records.columns import RoleColumns
from axisid.support.arrays import Array
from axisid.support.checks import check_among, is_real, refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.settings import setting
from axisid.support.wording import quoted

# Smallest number of written values of a column; fewer may be at even distances by chance.
_MIN_SELDOM_CHANGES = 20

#: Interpolation of a column between its written values.
Interpolation = Literal["spline", "linear", "held"]
BETWEEN: tuple[Interpolation, ...] = ("spline", "linear", "held")
#: Roles that can be interpolated.
SELDOM_ROLES = ("velocity", "acceleration", "force")


def checked_between(between: object) -> dict[str, Interpolation]:
    """Return the interpolation of columns by role, as the user gave it, checked.

    Raises
    ------
    UsageError
        The argument is not a mapping, a role is not in `SELDOM_ROLES`, or an interpolation is not
        in `BETWEEN`.
    """
    if not isinstance(between, Mapping):
        raise UsageError(
            f"between is {quoted(between)}. Give an interpolation by role, as in "
            "{'velocity': 'linear'}.",
            code="shift",
        )
    for role, how in between.items():
        check_among(
            ("column that can be interpolated", role, SELDOM_ROLES),
            (f"interpolation of the {role}", how, BETWEEN),
        )
    return {role: cast(Interpolation, how) for role, how in between.items()}


def samples_apart(values: Array) -> int:
    """Return the number of samples from one written value to the next; 1 if all are written.

    Parameters
    ----------
    values : (N,) array
        Column with NaN, or the last value again, in samples that were not written.
    """
    return _written(values)[1]


def _written(values: Array) -> tuple[NDArray[np.intp], int]:
    """Return the samples in which a value was written, (k,), and their distance in samples.

    In a column without empty cells these are samples at an even distance, at which nearly all
    changes of the column are; all samples if there is no such distance.
    """
    filled = np.isfinite(values)
    # Samples with a value, or with another value than the sample before.
    rows = np.flatnonzero(filled) if not filled.all() else np.flatnonzero(np.diff(values)) + 1
    distance, first = 1, 0
    if len(rows) >= _MIN_SELDOM_CHANGES:
        distance = int(np.median(np.diff(rows)))
        phases = np.bincount(rows % distance)
        first = int(phases.argmax())
        if phases[first] < 0.95 * len(rows):  # a rounded column changes at any sample
            distance, first = 1, 0
    return np.arange(first, len(values), distance) if filled.all() else rows, distance


def seldom_notes(samples: Mapping[str, Samples]) -> list[str]:
    """Return notes on measured columns that hold each value for several samples."""
    ordinals = {2: "second", 3: "third"}
    notes = []
    for role in SELDOM_ROLES:
        distance = samples_apart(samples[role].values) if role in samples else 1
        if distance > 1:
            notes.append(
                f"the {role} is updated only in every {ordinals.get(distance, f'{distance}th')} "
                f"sample and held in between, so it is {(distance - 1) / 2:g} samples late on "
                f"average. Interpolate the {role} ({advised_interpolation(role)})"
            )
    return notes


def drawn_between(
    columns: RoleColumns, between: Mapping[str, Interpolation], *, uneven: bool
) -> RoleColumns:
    """Return columns that are interpolated between their written values.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, each with its times.
    between : mapping of str to {"spline", "linear", "held"}
        Interpolation by role.
    uneven : bool
        True if the columns are resampled later: samples that were not written are then left out,
        and the resampling interpolates.

    Raises
    ------
    DataError
        There is no column of a given role, or it has too few values.
    """
    for role, how in between.items():
        if role not in columns.samples:
            raise DataError(
                f"{columns.source}: the {role} cannot be interpolated, because there is no column "
                f"of the {role}. Name the column with {setting('columns', {role: 'NAME'})}.",
                code="shift",
            )
        samples = columns.samples[role]
        fresh, _ = _written(samples.values)
        if len(fresh) < _MIN_SELDOM_CHANGES:
            raise DataError(
                f"{columns.source}: the {role} has {len(fresh)} values, but interpolation needs "
                f"{_MIN_SELDOM_CHANGES} or more. Omit between for the {role} in run.toml, or give "
                "a longer log.",
                code="too-short",
            )
        written, count = samples.taken(fresh), len(samples.values)
        if not uneven:
            written = replace(
                samples, values=at_times(samples.times, written.times, written.values, how)
            )
        phrases = {"spline": "interpolated by a cubic spline", "linear": "interpolated linearly"}
        phrase = phrases.get(how, "each held until the next value")
        repair = Repair(
            kind="between",
            count=count - len(fresh),
            text=f"{role}: {len(fresh)} values for {count} samples, {phrase}",
        )
        columns = columns.repaired({role: written}, repair)
    return columns


def at_times(times: Array, clock: Array, values: Array, how: Interpolation) -> Array:
    """Return values interpolated at given times, (n,).

    Before the first and after the last sample, the first and last value are returned.

    Parameters
    ----------
    times : (n,) array
        Times to interpolate at, s.
    clock, values : (N,) array
        Times, s, and values of the samples.
    how : {"spline", "linear", "held"}
        Interpolation.
    """
    if how == "linear":
        return np.interp(times, clock, values)
    if how == "held":
        return np.asarray(values[np.maximum(np.searchsorted(clock, times, "right") - 1, 0)])
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(clock, values)(np.clip(times, clock[0], clock[-1])), dtype=float)


def advised_interpolation(role: str) -> str:
    """Return the line of run.toml that interpolates a column between its written values.

    A velocity is smooth and is interpolated by a spline; an acceleration or force may jump and is
    interpolated linearly.
    """
    how = "spline" if role == "velocity" else "linear"
    return f'between.{role} = "{how}" in run.toml'


#: Numbers of rows, (n,).
Rows = NDArray[np.intp]

#: Pattern of a number, and of the unit after it.
_AMOUNT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


@dataclass(frozen=True, slots=True)
class Shift:
    """Shift of a column to later times.

    Attributes
    ----------
    amount : float
        Size of the shift; negative to earlier times.
    in_seconds : bool
        True for an amount in s, False for samples of the column.
    """

    amount: float
    in_seconds: bool = False

    def seconds(self, step: float) -> float:
        """Return the shift in seconds for a column with this sampling period."""
        return self.amount if self.in_seconds else self.amount * step


def checked_shifts(shifts: object) -> dict[str, Shift]:
    """Return shifts by role or name of a signal, as the user gave them, checked.

    A shift is given as a number of samples, or as a text with a time and its unit.

    Raises
    ------
    UsageError
        The argument is not a mapping, the time is to be shifted, or an amount is neither a number
        of samples nor a time.
    """
    if not isinstance(shifts, Mapping):
        raise UsageError(
            f"the shift is {quoted(shifts)}. Give a number of samples by role, as in "
            "{'control': 1}.",
            code="shift",
        )
    if "time" in shifts:
        raise UsageError("the time cannot be shifted. Shift the other columns.", code="shift")
    return {role: _shift(role, amount) for role, amount in shifts.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class AdvisedShift(Finding):
    """Shift of a column that aligns the column with the other columns.

    Attributes
    ----------
    role : str
        Role, or name of a signal.
    samples : float
        Shift in addition to the present one, in samples; negative to earlier times.
    is_whole : bool
        True for a whole number of samples; otherwise the log has to be resampled.
    """

    role: str
    samples: float
    is_whole: bool


def shift_into_time(role: str, late: float, apart: float) -> AdvisedShift:
    """Return the shift that aligns a late column with the other columns.

    The shift is a whole number of samples, not 0, if the delay is close enough to it. Otherwise the
    shift is the delay with the opposite sign.

    Parameters
    ----------
    role : str
        Role, or name of a signal.
    late : float
        Delay in samples; negative for an early column.
    apart : float
        Largest difference from a whole number of samples for a shift by that number.
    """
    whole = round(late)
    if whole and abs(late - whole) <= apart:
        return AdvisedShift(role=role, samples=float(-whole), is_whole=True)
    return AdvisedShift(role=role, samples=float(-late), is_whole=False)


def _shift(role: str, amount: object) -> Shift:
    """Return the shift of a column from a number of samples, or from a text with a time and a unit.

    Raises
    ------
    UsageError
        The amount is neither a number of samples nor a time.
    """
    if isinstance(amount, Shift):
        return amount
    match = _AMOUNT.fullmatch(amount) if isinstance(amount, str) else None
    number, unit = (float(match[1]), match[2]) if match else (amount, "")
    unit_of = exact_unit(unit) if unit else None
    timed = unit_of is not None and str(unit_of.unit) == "s"
    if not is_real(number) or not math.isfinite(number) or (unit and not timed):
        raise UsageError(
            f"the shift of the {role} is {quoted(amount)}. Give a number of samples, such as 1, or "
            "a time with its unit, such as 2ms.",
            code="shift",
        )
    return Shift(float(number) * (float(unit_of) if unit_of else 1.0), in_seconds=timed)


def check_movable(source: str, columns: Collection[str], shifts: Iterable[str]) -> None:
    """Refuse to shift a column that does not exist.

    Parameters
    ----------
    source : str
        Name of the log, for messages.
    columns : collection of str
        Roles and names of the columns that exist.
    shifts : iterable of str
        Roles and names of the columns to shift.

    Raises
    ------
    DataError
        There is no column of a role or name.
    """
    refuse(
        DataError,
        *(
            (
                role not in columns,
                f"{source}: the {role} cannot be shifted, because there is no column of the "
                f"{role}. Name the column with {setting('columns', {role: 'NAME'})}",
            )
            for role in shifts
        ),
        code="shift",
    )


def shifted(columns: RoleColumns, shifts: Mapping[str, Shift], *, uneven: bool) -> RoleColumns:
    """Return columns shifted to later times.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, each with its times.
    shifts : mapping of str to Shift
        Shifts by role.
    uneven : bool
        True if the columns are resampled later, so that any amount is possible.

    Raises
    ------
    DataError
        There is no column of a role, or the columns differ in length and are not resampled later.
    UsageError
        A shift is not possible without resampling, see `shifted_rows`.
    """
    if not shifts:
        return columns
    samples, source, clock = columns.samples, columns.source, columns.motion.times
    check_movable(source, samples, shifts)
    if uneven:
        # Shift the times; the resampling interpolates later.
        steps = {role: _step(samples[role].times) for role in shifts}
        return columns.repaired(
            {
                role: replace(s, clock=s.times + shifts[role].seconds(steps[role]))
                for role, s in samples.items()
                if role in shifts
            },
            *(
                _shift_repair(role, steps[role], shift, len(samples[role].values), 0)
                for role, shift in shifts.items()
            ),
        )
    if any(len(column.values) != len(clock) for column in samples.values()):
        raise DataError(
            f"{source}: the columns differ in length, so no column can be shifted. Resample the "
            f"columns with {setting('resample', 'auto')}.",
            code="shift",
        )
    # The columns have one clock: shift the values by whole rows.
    kept, partners, repairs = shifted_rows(source, clock, shifts)
    return columns.repaired(
        {
            role: replace(column.taken(kept), values=column.values[partners.get(role, kept)])
            for role, column in samples.items()
        },
        *repairs,
    )


def shifted_rows(
    source: str, clock: Array, shifts: Mapping[str, Shift]
) -> tuple[Rows, dict[str, Rows], list[Repair]]:
    """Return the rows that remain after shifts of columns, and their counterparts in these columns.

    The counterpart of a row is the row of a shifted column that the shift moves to it. A row at an
    end of the log, or across a gap, has no counterpart and is left out.

    Parameters
    ----------
    source : str
        Name of the log, for messages.
    clock : (N,) array
        Time of all columns, s.
    shifts : mapping of str to Shift
        Shifts by role.

    Returns
    -------
    (n,) array of int
        Rows that are kept.
    dict of str to (n,) array of int
        Counterparts of these rows in the shifted columns, by role.
    list of Repair
        Repairs that report the shifts.

    Raises
    ------
    UsageError
        A shift is not a whole number of samples, or is not shorter than the log.
    """
    step, rows = _step(clock), np.arange(len(clock))
    kept, partners = np.ones(len(clock), dtype=bool), {}
    for role, shift in shifts.items():
        samples = shift.amount / step if shift.in_seconds and step > 0 else shift.amount
        count = round(samples)
        fraction = abs(samples - count)
        if abs(count) >= len(clock) or fraction > 0.01 or (samples != 0 and count == 0):
            raise UsageError(
                f"{source}: the shift of the {role} is {samples:.6g} of {len(clock)} samples. Give "
                "a whole number of samples, or a time that is a whole number of samples. Or "
                f"resample the log ({setting('resample', 'auto')}), with which any shift is "
                "possible.",
                code="shift",
            )
        partners[role] = np.clip(rows - count, 0, len(clock) - 1)
        # A counterpart is kept if it exists, and if no gap lies between. A sample without a time is
        # kept too, as it is refused later with a message.
        deviation = np.abs(clock - clock[partners[role]] - count * step)
        kept &= (partners[role] == rows - count) & ~(deviation > step / 2)
    lost = len(clock) - int(kept.sum())
    repairs = [
        _shift_repair(r, step, shift, len(clock) - lost, lost) for r, shift in shifts.items()
    ]
    return (
        rows[kept],
        {role: partner_rows[kept] for role, partner_rows in partners.items()},
        repairs,
    )


def _step(clock: Array) -> float:
    """Return the median time step of a column, s; 0 with fewer than two finite times."""
    finite = clock[np.isfinite(clock)]
    return float(np.median(np.diff(finite))) if finite.size > 1 else 0.0


def _shift_repair(role: str, step: float, shift: Shift, count: int, lost: int) -> Repair:
    """Return the repair that reports the shift of a column.

    Parameters
    ----------
    role : str
    step : float
        Sampling period of the column, s.
    shift : Shift
    count, lost : int
        Number of shifted rows, and of rows left out.
    """
    seconds = shift.seconds(step)
    samples = seconds / step if step > 0 else 0.0
    way = "later" if seconds >= 0 else "earlier"
    named = f"{abs(samples):.4g} sample{'s' * (abs(samples) != 1)}"
    text = f"the {role} is shifted by {named} ({1e3 * abs(seconds):.4g} ms) to {way} times"
    if lost:
        are = "s without a counterpart are" if lost > 1 else " without a counterpart is"
        text += f"; {lost} row{are} left out"
    return Repair(kind="shift", count=count if samples else 0, text=text)
