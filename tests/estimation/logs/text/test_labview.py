"""LabVIEW measurement files, with the column of comments as LabVIEW writes it."""

from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from tests.refusals import refuses

N = 50
TIME = 1e-3 * np.arange(N)
POSITION = np.sin(9 * TIME)
COLUMNS = {"time": "X_Value", "position": "pos", "control": "cur"}

HEADS = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t,
X_Columns\tOne
Date\t2026/02/01
Time\t12:00:00,1234567
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t50\t50\t
Time\t12:00:00,1234567\t12:00:00,1234567\t
Y_Unit_Label\tmm\tVolts\t
X0\t0,0E+0\t0,0E+0\t
Delta_X\t1,0E-3\t1,0E-3\t
***End_of_Header***\t\t\t
"""


def lvm(file: Path, first: str = "", end: str = "", name: str = "\tComment") -> Path:
    """A file whose first row ends in `first`, every other in `end`."""
    rows = [
        f"{t:.6f}\t{1e3 * q:.9f}\t{k % 7}".replace(".", ",") + (end if k else first)
        for k, (t, q) in enumerate(zip(TIME, POSITION, strict=True))
    ]
    file.write_text("\n".join([f"{HEADS}X_Value\tpos\tcur{name}", *rows]) + "\n")
    return file


@pytest.mark.parametrize(
    ("first", "end", "name"),
    [
        ("", "", "\tComment"),
        ("\t", "\t", "\tComment"),
        ("\tstart; 7", "", "\tComment"),
        ("\tstart", "\t", "\tComment"),
        ("", "", ""),
    ],
)
def test_comments_are_passed_over_and_units_are_those_of_the_head(
    tmp_path: Path, first: str, end: str, name: str
) -> None:
    record = read_record(lvm(tmp_path / "log.lvm", first, end, name), columns=COLUMNS)
    assert record.time == pytest.approx(TIME, abs=1e-12)
    assert record.position == pytest.approx(POSITION, abs=1e-12)
    assert "position: mm -> m" in record.provenance.assumed


def test_file_without_samples_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "log.lvm"
    file.write_text(HEADS)
    with refuses("log-text"):
        read_record(file)
