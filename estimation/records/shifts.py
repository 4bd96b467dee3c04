"""Columns that a logger wrote some samples too early or too late, moved against the others."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.records.columns import motion_role
from axisid.estimation.tables import Repair, Samples, label_unit
from axisid.modeling.declaration import ROLES
from axisid.modeling.quantities import parse_unit
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError
from axisid.support.real_numbers import is_real
from axisid.support.remedy import Remedy, Setting
from axisid.support.user_values import quoted

_MAX_PART_OF_A_SAMPLE = 0.01  # samples from a whole number: a time that is written with two digits

_AMOUNT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_GIVE = "give samples, such as 1, or a time with its unit, such as 2ms"


@dataclass(frozen=True, slots=True)
class Shift:
    """By how much a column is moved to later times.

    Attributes
    ----------
    amount : float
    in_seconds : bool
        Else in samples of the column.
    """

    amount: float
    in_seconds: bool = False

    def seconds(self, step: float) -> float:
        """For a column of so many seconds a sample."""
        return self.amount if self.in_seconds else self.amount * step


def checked_shifts(shifts: object) -> dict[str, Shift]:
    """Shifts by role or signal: samples, or a time with its unit as a text.

    Raises
    ------
    UsageError
        The time is to be moved, or an amount is neither samples nor a time.
    """
    if not isinstance(shifts, Mapping):
        raise UsageError(
            f"the shift is {quoted(shifts)}; give samples by role: {{'control': 1}}.", code="shifts"
        )
    for role in shifts:
        if role == "time" or not isinstance(role, str):
            raise _unmovable(role)
    return {role: _shift(role, amount) for role, amount in shifts.items()}


def advised_shift(role: str, late: float, apart: float) -> Remedy:
    """What moves a column into step that is so many samples late.

    Parameters
    ----------
    role : str
        Or the name of a signal.
    late : float
        Samples; negative for early.
    apart : float
        Samples by which a whole number may be missed.
    """
    whole = round(late)
    if whole and abs(late - whole) <= apart:
        return Remedy.of("move it there (", Setting("shift", f"{role}={-whole:d}"), ")")
    return Remedy.of(
        "move it there by part of a sample (",
        Setting("shift", f"{role}={-late:.2f}"),
        Setting("resample", "auto"),
        ")",
    )


def _unmovable(role: object, columns: Iterable[str] = ()) -> UsageError:
    movable = dict.fromkeys(role for role in (*ROLES, *columns) if role != "time")
    return UsageError(
        f"{role!r} is no column that can be moved; those are {', '.join(movable)}.",
        code="unmovable-column",
    )


def _shift(role: str, amount: object) -> Shift:
    if isinstance(amount, Shift):
        return amount
    number, unit = (amount, "") if is_real(amount) else _parts(amount)
    found = label_unit(unit) if unit else None
    timed = found is not None and str(found[1]) == str(parse_unit("s"))
    if not is_real(number) or not math.isfinite(number) or (unit and not timed):
        raise UsageError(
            f"the {role} is to be shifted by {quoted(amount)}; {_GIVE}.", code="shift-amount"
        )
    return Shift(float(number) * (found[0] if found else 1.0), in_seconds=timed)


def _parts(amount: object) -> tuple[float, str]:
    match = _AMOUNT.fullmatch(amount) if isinstance(amount, str) else None
    return (float(match[1]), match[2]) if match else (math.nan, "")


def shifted(
    source: str, columns: Mapping[str, Samples], shifts: Mapping[str, Shift], *, uneven: bool
) -> tuple[dict[str, Samples], list[Repair]]:
    """Columns moved to later times, and what is said of it.

    Parameters
    ----------
    source : str
        For messages.
    columns : mapping of str to Samples
        Each with its clock.
    shifts : mapping of str to Shift
    uneven : bool
        Whether the columns are resampled after this, so that any amount will do.

    Raises
    ------
    DataError
        There is no such column.
    UsageError
        It is neither a role nor a signal.
        The amount is no whole number of samples, or more than there are.
    """
    for role in shifts:
        if role not in columns and role not in ROLES:
            raise _unmovable(role, (name for name in columns if name.isidentifier()))
        if role not in columns:
            raise DataError(
                f"{source}: the {role} is to be shifted, and there is no such column; ",
                Remedy.of("name it with ", Setting("columns", f"{role}=NAME"), "."),
                code="nothing-to-shift",
            )
    if uneven:
        moved = {role: _later(columns[role], shift) for role, shift in shifts.items()}
        return {**columns, **{role: m for role, (m, _) in moved.items()}}, [
            _shift_repair(role, step, shifts[role], len(columns[role].values), 0)
            for role, (_, step) in moved.items()
        ]
    clock = columns[motion_role(columns)].clock
    assert clock is not None  # noqa: S101  # every column has one by now
    step = _step(clock)
    samples = {
        role: whole_samples(source, role, shift, step, len(clock)) for role, shift in shifts.items()
    }
    if any(len(s.values) != len(clock) for s in columns.values()):
        return dict(columns), []  # whose lengths are refused next
    partners, kept = _partners(clock, samples, step)
    made = {
        role: replace(
            s,
            values=s.values[partners[role][kept]] if role in partners else s.values[kept],
            clock=None if s.clock is None else s.clock[kept],
        )
        for role, s in columns.items()
    }
    lost = len(clock) - int(kept.sum())
    return made, [
        _shift_repair(role, step, shift, len(clock) - lost, lost) for role, shift in shifts.items()
    ]


def _step(clock: Array) -> float:
    finite = clock[np.isfinite(clock)]
    return float(np.median(np.diff(finite))) if finite.size > 1 else 0.0


def _later(samples: Samples, shift: Shift) -> tuple[Samples, float]:
    """Samples with a later clock, and the step of their own."""
    clock = samples.clock
    assert clock is not None  # noqa: S101
    step = _step(clock)
    return replace(samples, clock=clock + shift.seconds(step)), step


def whole_samples(source: str, role: str, shift: Shift, step: float, length: int) -> int:
    """A shift in samples, where it is a whole number of them."""
    samples = shift.amount / step if shift.in_seconds and step > 0 else shift.amount
    if not abs(samples) < length:
        raise UsageError(
            f"{source}: the {role} is to be shifted by {samples:g} samples, and has {length}.",
            code="long-shift",
        )
    whole = round(samples)
    if abs(samples - whole) > _MAX_PART_OF_A_SAMPLE or (samples != 0 and whole == 0):
        raise UsageError(
            f"{source}: the {role} is to be shifted by {samples:.4g} samples; ",
            Remedy.of(
                "give a whole number of them, a time as in 2ms, or resample the log (",
                Setting("resample", "auto"),
                ").",
            ),
            code="part-of-a-sample",
        )
    return whole


def _partners(
    clock: Array, samples: Mapping[str, int], step: float
) -> tuple[dict[str, NDArray[np.int64]], NDArray[np.bool_]]:
    """For each moved column the samples that come to stand at each one, and which have all.

    Across a gap a sample has no partner.
    """
    places = np.arange(len(clock))
    kept = np.ones(len(clock), dtype=bool)
    partners = {}
    for role, count in samples.items():
        wanted = places - count
        there = (wanted >= 0) & (wanted < len(clock))
        partners[role] = np.clip(wanted, 0, len(clock) - 1)
        off = np.abs(clock - clock[partners[role]] - count * step)
        kept &= there & ~(off > step / 2)  # a sample without a time is refused by its name later
    return partners, kept


def _shift_repair(role: str, step: float, shift: Shift, moved: int, lost: int) -> Repair:
    seconds = shift.seconds(step)
    samples = seconds / step if step > 0 else 0.0
    way = "later" if seconds >= 0 else "earlier"
    named = f"{abs(samples):.4g} sample{'s' * (abs(samples) != 1)}"
    text = f"{role} moved {named} ({1e3 * abs(seconds):.4g} ms) {way}"
    if lost:
        text += f"; {lost} row{'s' * (lost > 1)} without a partner left out"
    return Repair(kind="shift", count=moved if samples else 0, text=text)
