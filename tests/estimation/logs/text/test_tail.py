"""A last number that was cut off is told from its neighbours; a whole one is left alone."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from axisid import Record, read_record
from axisid.estimation import Repairs
from axisid.estimation.logs.text.dialect import sniff
from axisid.estimation.logs.text.reader import is_cut

FORMATS: dict[str, Callable[[float], str]] = {
    "six decimals": lambda v: f"{v:.6f}",
    "exponents": lambda v: f"{v:.6e}",
    "nine digits": lambda v: f"{v:.9g}",
    "all digits": lambda v: repr(float(v)),
    "counts": lambda v: str(round(1e6 * v)),
}


def judged(cells: list[str]) -> bool:
    lines = [(k, f"{k};{cell}") for k, cell in enumerate(cells, 1)]
    return is_cut(lines, sniff("log", lines))


@pytest.mark.slow
@pytest.mark.parametrize("role", ["position", "reference", "control"])
@pytest.mark.parametrize("written", FORMATS)
def test_whole_numbers_are_kept_and_cut_ones_are_seen_where_it_matters(
    twin: Record, written: str, role: str
) -> None:
    """What matters is a tenth of the spread of the rows above and more."""
    cells = [FORMATS[written](v) for v in twin.channels()[role]]
    alarms, missed, tried = 0, 0, 0
    ends = range(600, len(cells), 397)
    for end in ends:
        *above, last = cells[end - 101 : end]
        alarms += judged([*above, last])
        spread = float(np.std([float(cell) for cell in above]))
        for left in (last[:-1], last[: len(last) // 2]):
            off = abs(float(left.rstrip("e+-") or 0) - float(last)) > 0.1 * spread
            tried, missed = tried + off, missed + (off and not judged([*above, left]))
    assert alarms <= 0.1 * len(ends)
    assert missed <= 0.2 * tried + 1


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize(
    ("separator", "mark", "end"),
    [(",", ".", ""), (";", ",", ""), ("  ", ".", ""), (",", ".", ","), ("\t", ".", "")],
)
def test_cut_row_is_left_out_and_counted(
    tmp_path: Path, separator: str, mark: str, end: str, encoding: str
) -> None:
    file = tmp_path / "log.csv"
    time = 1e-3 * np.arange(3000)
    rows = zip(time, np.sin(9 * time), np.cos(9 * time), strict=True)
    lines = [separator.join(f"{v:.6f}".replace(".", mark) for v in row) + end for row in rows]
    text = "\n".join([separator.join(("time", "position", "control")), *lines])
    file.write_bytes(f"{text}\n".encode(encoding))
    assert not read_record(file).provenance.repairs
    file.write_bytes(text[:-4].encode(encoding))
    for repairs in (Repairs(), Repairs(tail="drop")):
        kept = read_record(file, repairs=repairs)
        (told,) = kept.provenance.repairs
        assert (len(kept), told.kind, told.count) == (2999, "tail", 1)
        assert "from line 3001" in told.text
