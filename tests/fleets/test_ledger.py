"""The ledger: what was written is read, and what is no row is told."""

import math
from pathlib import Path

import numpy as np
import pytest

from axisid import DataError
from axisid.fleets import read_ledger
from axisid.fleets.ledger import LEDGER, ledger_of, write_row
from tests.fleets.logs import CENTRE, row_of


def test_rows_are_read_in_the_order_of_their_last_lines_finite_or_not(tmp_path: Path) -> None:
    odd = row_of("odd", np.array([np.nan, 200.0, 20.0]))
    with ledger_of(tmp_path, anew=True) as ledger:
        for row in (row_of("a", CENTRE), odd, row_of("a", CENTRE + 1.0)):
            write_row(ledger, row)
        ledger.write(b'{"schema": "axisid.fle')  # cut off
    ledger_read = read_ledger(tmp_path)
    rows = ledger_read.rows
    assert ledger_read.broken == (4,)
    assert "1 line of" in ledger_read.broken_text()
    assert list(rows) == ["odd", "a"]
    assert math.isnan(rows["odd"].parameters["M"].value)
    assert rows["a"].parameters["M"].value == CENTRE[0] + 1.0


def test_a_line_that_is_no_row_is_told(tmp_path: Path) -> None:
    (tmp_path / LEDGER).write_text('{"schema": "axisid.fleet/1", "name": null}\n')
    with pytest.raises(DataError, match="line 1 is no row of a fleet"):
        read_ledger(tmp_path)


def test_a_ledger_goes_on_without_empty_lines_also_after_one_that_was_cut_off(
    tmp_path: Path,
) -> None:
    for content in (b"", b"{}\n", b'{"a'):
        (tmp_path / LEDGER).write_bytes(content)
        with ledger_of(tmp_path, anew=False) as ledger:
            write_row(ledger, row_of("a", CENTRE))
        lines = (tmp_path / LEDGER).read_bytes().splitlines()
        assert b"" not in lines
        assert lines[-1].startswith(b'{"schema"')
