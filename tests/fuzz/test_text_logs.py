"""Logs as text, in any dialect and with anything wrong in them, are read right or refused."""

import math
from pathlib import Path

import numpy as np
import pytest

from axisid import DataError
from axisid.estimation.logs import read_table
from tests.fuzz.cases import Fuzz, WrongError, pieces_left_out
from tests.fuzz.text_logs import TextLog, changed_log, damaged, smaller_logs


def _compare(log: TextLog, name: str, column: int, values: np.ndarray) -> None:
    """Hold a column that was read against what was written."""
    if log.odd:
        raise WrongError(f"a line that is no row is passed over: column {name}")
    rows = len(log.rows)
    if len(values) not in ((rows, rows - 1) if log.cut else (rows,)):
        raise WrongError(f"rows: {len(values)} of {rows} in column {name}")
    for row, value in enumerate(values.tolist()):
        written = log.value(row, column)
        if log.cut and row == rows - 1 and math.isnan(value):
            continue
        if written is None:
            if not math.isnan(value):
                raise WrongError(f"junk: {log.rows[row][column]!r} is read as {value!r}")
            continue
        alike = value == written or (math.isnan(value) and math.isnan(written))
        close = bool(log.seconds) and column == 0 and abs(value - written) < 1e-6
        if not (alike or close):
            raise WrongError(f"number: {log.rows[row][column]!r} is read as {value!r}")


def _columns(log: TextLog, file: Path) -> dict[str, np.ndarray]:
    """Columns that can be read, of those that have a name of their own."""
    file.write_bytes(log.content)
    found = {}
    for name, column in read_table(file).columns.items():
        try:
            found[name] = column.read().values
        except DataError:
            continue
    return found


def _places(log: TextLog) -> dict[str, int]:
    return {name: k for k, name in enumerate(log.names)}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "log.csv"


@pytest.mark.slow
def test_what_is_read_is_what_was_written(file: Path) -> None:
    def check(log: TextLog) -> None:
        places = _places(log)
        for name, values in _columns(log, file).items():
            if name not in places:
                raise WrongError(f"name: a column {name!r} that was not written")
            _compare(log, name, places[name], values)

    Fuzz(
        name="text logs",
        count=600,
        draw=changed_log,
        check=check,
        smaller=smaller_logs,
        shown=lambda log: repr(log.content),
    ).run()


@pytest.mark.slow
def test_damaged_bytes_are_read_or_refused(file: Path) -> None:
    def check(text: str) -> None:
        file.write_bytes(text.encode("latin-1"))
        table = read_table(file)
        for column in table.columns.values():
            try:
                column.read()
            except DataError:
                continue

    Fuzz(
        name="damaged logs",
        count=600,
        draw=lambda rng: damaged(changed_log(rng).content, rng).decode("latin-1"),
        check=check,
        smaller=pieces_left_out,
        shown=lambda text: repr(text.encode("latin-1")),
    ).run()
