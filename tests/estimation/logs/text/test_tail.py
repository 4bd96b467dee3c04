"""A last number that was cut off is told from its neighbours; a whole one is left alone."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from axisid.estimation import Repairs

FORMATS: dict[str, Callable[[float], str]] = {
    "six decimals": lambda v: f"{v:.6f}",
    "exponents": lambda v: f"{v:.6e}",
    "nine digits": lambda v: f"{v:.9g}",
    "all digits": lambda v: repr(float(v)),
    "counts": lambda v: str(round(1e6 * v)),
}


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
