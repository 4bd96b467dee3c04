"""Columns that are written more seldom than the log's samples: found, told, and drawn between.

A drive that measures its velocity every fourth cycle writes one value into four samples, or leaves
three of them empty. Taken as it stands the first is one and a half samples late in the mean.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.choices import check_among
from axisid.estimation.tables import Repair, Samples
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError
from axisid.support.remedy import Note, Remedy, Setting
from axisid.support.user_values import quoted

_MIN_SELDOM_CHANGES = 20  # values of a column; fewer come at even distances by chance
# of a column's changes come at one even distance; of a rounded one they come at any
_MIN_SAME_PHASE = 0.95

#: What a column is between the values that were written.
Between = Literal["spline", "linear", "held"]
BETWEEN: tuple[Between, ...] = ("spline", "linear", "held")
#: Roles of which that can be said.
SELDOM_ROLES = ("velocity", "acceleration", "force")


def checked_between(between: object) -> dict[str, Between]:
    """What columns are between their values, by role.

    Raises
    ------
    UsageError
        A role is none of `SELDOM_ROLES`, or what is said of it none of `BETWEEN`.
    """
    if not isinstance(between, Mapping):
        raise UsageError(
            f"what columns are between their values is {quoted(between)}; give it by role: "
            "{'velocity': 'linear'}.",
            code="between",
        )
    for role, how in between.items():
        if role not in SELDOM_ROLES:
            raise UsageError(
                f"{role!r} is no column that may be written more seldom than the log's samples; "
                f"those are {', '.join(SELDOM_ROLES)}.",
                code="between-role",
            )
        check_among((f"way of the {role} between its values", how, BETWEEN))
    return {role: cast(Between, how) for role, how in between.items()}


def samples_apart(values: Array) -> int:
    """Samples from one value that was written to the next; 1 of a column that is written in each.

    Parameters
    ----------
    values : (N,) array
        Empty cells, or the last value again, where nothing was written.
    """
    return _written(values)[1]


def _written(values: Array) -> tuple[NDArray[np.intp], int]:
    """Samples in which a value was written, and how far one is from the next.

    Of a column without empty cells these are the samples at an even distance in which most of its
    changes are; every sample where there is no such distance.
    """
    filled = np.isfinite(values)
    rows = np.flatnonzero(filled) if not filled.all() else np.flatnonzero(np.diff(values)) + 1
    apart, first = 1, 0
    if len(rows) >= _MIN_SELDOM_CHANGES:
        apart = int(np.median(np.diff(rows)))
        phases = np.bincount(rows % apart)
        first = int(phases.argmax())
        if phases[first] < _MIN_SAME_PHASE * len(rows):
            apart, first = 1, 0
    return np.arange(first, len(values), apart) if filled.all() else rows, apart


def seldom_notes(samples: Mapping[str, Samples]) -> list[Note]:
    """What is said of measured columns that hold each value for several samples."""
    notes = []
    for role in SELDOM_ROLES:
        apart = samples_apart(samples[role].values) if role in samples else 1
        if apart > 1:
            nth = {2: "second", 3: "third"}.get(apart, f"{apart}th")
            notes.append(
                Note(
                    f"the {role} is written anew in every {nth} sample alone and held "
                    f"between, {(apart - 1) / 2:g} samples late in the mean: ",
                    Remedy.of("draw it between its values (", advised_between(role), ")"),
                )
            )
    return notes


def drawn_between(
    source: str, columns: Mapping[str, Samples], between: Mapping[str, Between], *, uneven: bool
) -> tuple[dict[str, Samples], list[Repair]]:
    """Columns between the values that were written.

    Parameters
    ----------
    source : str
        For messages.
    columns : mapping of str to Samples
        By role, each with its clock.
    between : mapping of str to {"spline", "linear", "held"}
    uneven : bool
        Whether the columns are resampled after this: then no more is done than to leave out the
        samples in which nothing was written.

    Raises
    ------
    DataError
        There is no such column, or it has too few values.
    """
    found, made = dict(columns), []
    for role, how in between.items():
        if role not in columns:
            raise DataError(
                f"{source}: nothing is to be drawn between values of the {role}, as there is no "
                "such column; ",
                Remedy.of("name it with ", Setting("columns", f"{role}=NAME"), "."),
                code="nothing-between",
            )
        samples = columns[role]
        fresh, _ = _written(samples.values)
        if len(fresh) < _MIN_SELDOM_CHANGES:
            raise DataError(
                f"{source}: the {role} has {len(fresh)} values, too few to draw it between them.",
                code="few-between",
            )
        found[role] = samples.taken(fresh)
        if not uneven:
            values = at_times(samples.times, found[role].times, found[role].values, how)
            found[role] = replace(samples, values=values)
        count, ways = len(samples.values), {"spline": "by a cubic spline", "linear": "straight"}
        text = f"{role}: {len(fresh)} values for {count} samples, {ways.get(how, 'held')} between"
        made.append(Repair(kind="between", count=count - len(fresh), text=text))
    return found, made


def at_times(times: Array, clock: Array, values: Array, how: Between) -> Array:
    """Values of a clock at other times; beyond them the first and the last."""
    if how == "linear":
        return np.interp(times, clock, values)
    if how == "held":
        return np.asarray(values[np.maximum(np.searchsorted(clock, times, "right") - 1, 0)])
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(clock, values)(np.clip(times, clock[0], clock[-1])), dtype=float)


def advised_between(role: str) -> Setting:
    """What suits a column: a velocity bends, an acceleration or a force jumps."""
    return Setting("between", f"{role}={'spline' if role == 'velocity' else 'linear'}")
