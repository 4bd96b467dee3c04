"""A last number that was cut off is told from its neighbours; a whole one is left alone."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from axisid import DataError, Record, read_record
from axisid.estimation import Repairs
from axisid.estimation.logs.text.cut_number import cut_number
from axisid.support.remedy import Setting

FORMATS: dict[str, Callable[[float], str]] = {
    "six decimals": lambda v: f"{v:.6f}",
    "three decimals": lambda v: f"{v:.3f}",
    "exponents": lambda v: f"{v:.6e}",
    "nine digits": lambda v: f"{v:.9g}",
    "five digits": lambda v: f"{v:.5g}",
    "all digits": lambda v: repr(float(v)),
    "counts": lambda v: str(round(1e6 * v)),
}
FIXED = ("six decimals", "three decimals", "exponents")


def prefixes(cell: str) -> list[str]:
    """What may be left of a number, as a number."""
    found = []
    for stop in range(1, len(cell)):
        try:
            float(cell[:stop])
        except ValueError:
            continue
        found.append(cell[:stop])
    return found


def judged(cells: list[str], *, ended: bool) -> str:
    return cut_number(cells, [cell[-1] for cell in cells], ended=ended)


@pytest.mark.parametrize("role", ["time", "position", "reference", "control"])
@pytest.mark.parametrize("written", FORMATS)
def test_whole_numbers_of_a_twin_raise_no_alarm(twin: Record, written: str, role: str) -> None:
    cells = [FORMATS[written](v) for v in twin.channels()[role]]
    ends = range(600, len(cells), 397)
    for ended, allowed in ((True, 0), (False, 1)):
        alarms = [end for end in ends if judged(cells[end - 401 : end], ended=ended)]
        assert len(alarms) <= allowed


@pytest.mark.parametrize("role", ["position", "reference", "control"])
@pytest.mark.parametrize("written", FORMATS)
def test_numbers_that_were_cut_are_seen_where_it_matters(
    twin: Record, written: str, role: str
) -> None:
    """What is not seen is within a tenth of the spread of the 400 rows above, almost always.

    Of whole numbers with as much noise as signal, three in four are seen.
    """
    values = twin.channels()[role]
    cells = [FORMATS[written](v) for v in values]
    missed, tried = [], 0
    for end in range(600, len(cells), 701):
        above, last = cells[end - 401 : end - 1], cells[end - 1]
        spread = float(np.std([float(cell) for cell in above]))
        for left in prefixes(last):
            seen = judged([*above, left], ended=False)
            off = abs(float(left) - float(last))
            tried += off > 0.1 * spread
            missed += [left] if off > 0.1 * spread and not seen else []
            assert seen or written not in FIXED
    assert tried
    assert len(missed) <= (0.3 if (written, role) == ("counts", "control") else 0.1) * tried


def test_few_rows_tell_nothing() -> None:
    cells = [f"{v:.6f}" for v in np.sin(np.arange(15.0))]
    assert not judged([*cells, "0.12"], ended=False)
    assert not judged([f"{v:.6f}" for v in np.sin(np.arange(60.0))] + ["0.12"], ended=True)


def test_empty_cells_and_other_words_are_passed_over() -> None:
    cells = [f"{v:.6f}" for v in np.sin(np.arange(200.0))]
    cells[50], cells[70] = "", "nan"
    ends = ["1"] * 201
    assert cut_number([*cells, "0.12"], ends, ended=False) == "the numbers above it have 6 decimals"
    assert cut_number([*cells, ""], ends, ended=False) == ""


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize(
    ("separator", "mark", "end"),
    [(",", ".", ""), (";", ",", ""), ("  ", ".", ""), (",", ".", ","), ("\t", ".", "")],
)
def test_cut_row_is_told_and_left_out_on_request(
    tmp_path: Path, separator: str, mark: str, end: str, encoding: str
) -> None:
    file = tmp_path / "log.csv"
    time = 1e-3 * np.arange(3000)
    rows = zip(time, np.sin(9 * time), np.cos(9 * time), strict=True)
    lines = [separator.join(f"{v:.6f}".replace(".", mark) for v in row) + end for row in rows]
    text = "\n".join([separator.join(("time", "position", "control")), *lines])
    file.write_bytes(f"{text}\n".encode(encoding))
    assert not read_record(file).provenance.doubts
    for lost in (1, 4) if end else (2, 4):
        file.write_bytes(text[:-lost].encode(encoding))
        (told,) = read_record(file).provenance.doubts
        assert "line 3001, the last, looks cut off inside its last number" in told.text
        assert told.remedy is not None
        assert told.remedy.settings == (Setting("tail", "drop"),)
        kept = read_record(file, repairs=Repairs(tail="drop"))
        assert len(kept) == 2999
        assert "from line 3001" in kept.provenance.repairs[0].text


def test_row_that_lacks_a_cell_is_refused_as_before(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    rows = "\n".join(f"{k}.5,{k}.25,{k}.125" for k in range(300))
    file.write_text(f"time,position,control\n{rows}\n300.5,300")
    with pytest.raises(DataError) as refused:
        read_record(file)
    assert refused.value.code == "broken-line"
    assert refused.value.remedy is not None
    assert refused.value.remedy.settings == (Setting("tail", "drop"),)


@pytest.mark.parametrize("cell", ["e0", "+e5", ".", "-", ".e1", ""])
def test_text_that_only_looks_like_a_number_is_no_cut_one(cell: str) -> None:
    cells = [*(f"{k}.25e+00" for k in range(120)), cell]
    assert cut_number(cells, ["0"] * 120 + ["\n"], ended=False) == ""


def test_an_exponent_that_no_number_holds_explains_nothing_and_warns_of_nothing(
    tmp_path: Path,
) -> None:
    file = tmp_path / "log.csv"
    file.write_bytes(
        b";;\n;;0\n;;0\r0\r;0\n;6\n6e504\n;0\n1\n;0\n3\r;3\r;;3\r;7\r7\r;;7\r;;4\r2\r;2\r3\r;;2\n;;0"
    )
    with np.errstate(all="raise"), pytest.raises(DataError):
        read_record(file)
