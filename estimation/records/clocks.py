"""The times of the roles' columns: one time column, each column's own, or an even count."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from axisid.estimation.tables import Samples, Table
from axisid.estimation.thresholds import MAX_UNEVEN_STEP
from axisid.support.errors import DataError
from axisid.support.remedy import Remedy, Setting

from .between import SELDOM_ROLES, advised_between, samples_apart
from .time_steps import long_steps

_RESAMPLE = Setting("resample", "auto")


def clocked(
    table: Table, samples: Mapping[str, Samples], sample_period: float | None
) -> dict[str, Samples]:
    """Every column but time with its times: the time column's, its own, or a count."""
    columns = {role: s for role, s in samples.items() if role != "time"}
    if "time" in samples:
        time = samples["time"].values
        lengths = {role: len(s.values) for role, s in samples.items()}
        if len(set(lengths.values())) > 1:
            raise _unequal(table, lengths)
        return {role: replace(s, clock=time) for role, s in columns.items()}
    if all(s.clock is not None for s in columns.values()):
        return columns
    if sample_period is None:
        raise DataError(
            f"{table.source}: there is no time column among {table.listed()}; ",
            Remedy.of(
                "name it with ",
                Setting("columns", "time=NAME"),
                ", or give ",
                Setting("sample-period"),
                ".",
                f" {table.missing}" if table.missing else "",
            ),
            code="no-time",
        )
    return {
        role: replace(s, clock=sample_period * np.arange(len(s.values), dtype=np.float64))
        for role, s in columns.items()
    }


def filled(table: Table, columns: Mapping[str, Samples], *, uneven: bool) -> dict[str, Samples]:
    """Columns without the samples that lack a value, where these may be left out."""
    if uneven:
        columns = {role: _filled(s) for role, s in columns.items()}
    else:
        _check_filled(table, columns)
        _check_one_clock(table, columns)
    for role, s in columns.items():
        if not len(s.values):
            raise DataError(
                f"{table.source}: the {role} has no row with a number and a time.",
                code="no-timed-number",
            )
    return dict(columns)


def _filled(samples: Samples) -> Samples:
    """The samples that have a value and a time; their number shows in what is said of them."""
    return samples.taken(np.isfinite(samples.values) & np.isfinite(samples.times))


def _check_filled(table: Table, columns: Mapping[str, Samples]) -> None:
    """Refuse cells without a finite number, a log's way to write a lower rate."""
    for role, samples in columns.items():
        for is_time, cells in ((True, samples.times), (False, samples.values)):
            empty, count = np.flatnonzero(~np.isfinite(cells)), len(cells)
            if not empty.size:
                continue
            row, drawn = int(empty[0]), None if is_time else _or_drawn(role, samples)
            where = f"in data row {row + 1} ({empty.size} of {count}"
            said = (
                f"has no time {where})"
                if is_time
                else f"is {cells[row]} {where} cells hold no number)"
            )
            raise DataError(
                f"{table.source}: the {role} {said}. ",
                Remedy.of(_advice_on_empty(samples), drawn, _or_end(table, row, count), "."),
                code="empty-cells",
            )


def _or_drawn(role: str, samples: Samples) -> Remedy | None:
    """More to do about a measured column that is written in every so many rows."""
    if role not in SELDOM_ROLES or samples_apart(samples.values) == 1:
        return None
    return Remedy.of(", or draw it between its values (", advised_between(role), ")")


def _advice_on_empty(samples: Samples) -> Remedy:
    """What to do about empty cells: few in a row are bridged, a burst of them is a gap."""
    if long_steps(_filled(samples).times, MAX_UNEVEN_STEP.value).size:
        return Remedy.of(
            "More of them follow one another than can be bridged: resample what is there and cut "
            "where it is missing (",
            _RESAMPLE,
            Setting("gaps", "split"),
            ")",
        )
    return Remedy.of(
        "Remove such rows, or resample a column that is written less often than the others (",
        _RESAMPLE,
        ")",
    )


def _or_end(table: Table, row: int, count: int) -> Remedy | None:
    """More to do about a row without a number where it and all after it look cut off."""
    if row < count - table.incomplete:
        return None
    return Remedy.of(", or leave the end of the log out (", Setting("tail", "drop"), ")")


def _check_one_clock(table: Table, columns: Mapping[str, Samples]) -> None:
    first, shared = next((role, s.times) for role, s in columns.items())
    for role, samples in columns.items():
        clock = samples.times
        if len(clock) != len(shared):
            raise _unequal(
                table,
                {first: len(shared), role: len(clock)},
                Remedy.of(
                    "Where they are sampled at different rates, resample them (", _RESAMPLE, ")."
                ),
            )
        if clock is not shared and not np.array_equal(clock, shared, equal_nan=True):
            raise DataError(
                f"{table.source}: {first} and {role} are sampled at different times; ",
                Remedy.of("resample them (", _RESAMPLE, ")."),
                code="different-times",
            )


def _unequal(table: Table, lengths: Mapping[str, int], advice: Remedy | None = None) -> DataError:
    """The error of columns that differ in length, with what is wrong with the file."""
    listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
    why = f" ({'; '.join(table.warnings)})" if table.warnings else ""
    found = f"{table.source}: the columns differ in length: {listed}{why}."
    return DataError(f"{found} " if advice else found, advice, code="different-lengths")
