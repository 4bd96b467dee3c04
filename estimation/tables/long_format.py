"""Long tables, in which a row has the time, the name and the value of one signal, made wide."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from axisid.support.arrays import Array

from .table import Column, Samples, Table, loaded_column
from .unit_labels import label_unit

# of the rows have the time of the row before; one half with two names, more with more
_MIN_ROWS_AT_ONE_TIME = 0.4

_NAMES = frozenset("name signal channel variable topic key tag symbol measurement field".split())
_VALUES = frozenset(("value", "val", "values", "y", "data", "wert"))
_UNITS = frozenset(("unit", "units", "einheit"))
_MOST_SIGNALS = 1000
_FEWEST_ROWS = 2  # of a signal
_MOST_PARTS = 4  # time, name, value, unit


def wide(table: Table) -> Table:
    """A table as it is, or with a column for each signal of a long one.

    Long is a table of one column of text, one of times and one of values, beside one of units,
    whose headings say so (``name`` or ``signal``, ``value``), or whose rows come at the same times.
    Each signal has a clock of its own.
    """
    found = _parts(table)
    if found is None:
        return table
    names, times, values, units = found
    clock, numbers = table.columns[times], table.columns[values].read().values
    seconds = clock.read().values
    columns: dict[str, Column] = {}
    order = np.unique(np.asarray(names, dtype=str), return_inverse=True)
    clocks: list[Array] = []
    for k, name in enumerate(order[0]):
        places = np.flatnonzero(order[1] == k)
        own = seconds[places]
        shared = next((each for each in clocks if np.array_equal(each, own)), own)
        if shared is own:
            clocks.append(own)
        unit = units[places[0]] if units else ""
        columns[str(name)] = loaded_column(numbers[places], unit=unit, clock=shared)
    told = f"rows of {times}, name and {values}, made {len(columns)} columns by their names"
    timed = _with_seconds(columns, clock.unit)
    notes = (*table.notes, *((clock.note,) if clock.note else ()), told)
    return replace(table, columns=timed, notes=notes, texts={})


def _with_seconds(columns: dict[str, Column], unit: str) -> dict[str, Column]:
    """Columns whose clocks are in seconds, where the times have a unit."""
    found = label_unit(unit) if unit else None
    if found is None or found[0] == 1.0:
        return columns

    def scaled(column: Column) -> Column:
        samples = column.read()
        assert samples.clock is not None  # noqa: S101
        made = Samples(values=samples.values, clock=found[0] * samples.clock)
        return replace(column, read=lambda: made)

    return {name: scaled(column) for name, column in columns.items()}


def _parts(
    table: Table,
) -> tuple[Sequence[str], str, str, Sequence[str]] | None:
    """Names of the signals, row by row, the columns of times and of values, and units."""
    texts = dict(table.texts)
    units: Sequence[str] = ()
    for label in [*texts]:
        if label.lower() in _UNITS and len(texts) > 1:
            units = texts.pop(label)
    numeric = [name for name, c in table.columns.items() if name not in table.texts]
    if len(texts) != 1 or len(numeric) != 2:
        return None
    ((label, names),) = texts.items()
    signals = {*names}
    enough = 2 <= len(signals) <= _MOST_SIGNALS and len(names) >= _FEWEST_ROWS * len(signals)
    if not enough or "" in signals:
        return None
    values = next((name for name in numeric if name.lower() in _VALUES), numeric[1])
    times = next(name for name in numeric if name != values)
    said = label.lower() in _NAMES and values.lower() in _VALUES
    # A column of numbers with a damaged one is text too, and has no names in it.
    if not (said or (_at_one_time(table, times) and not any(map(_is_number, signals)))):
        return None
    return names, times, values, units


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _at_one_time(table: Table, times: str) -> bool:
    """Whether rows share their times."""
    seconds = table.columns[times].read().values
    same = sum(a == b for a, b in pairwise(seconds[:10_000].tolist()))
    return bool(same >= _MIN_ROWS_AT_ONE_TIME * min(len(seconds), 10_000))
