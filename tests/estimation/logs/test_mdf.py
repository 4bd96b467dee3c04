"""MDF files are read with the clocks and invalid samples of their channels."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import load_axis, read_record
from axisid.estimation import Repairs
from tests.estimation.logs.samples import N, Q, T, U, mdf
from tests.refusals import refuses


def test_mdf_channels_of_one_name_in_one_group_stay_apart(tmp_path: Path) -> None:
    groups = [(Q, T, "q", ""), (Q + 1, T, "q", "")], [(Q + 2, T, "0.q", "")], [(Q + 3, T, "q", "")]
    file = mdf(tmp_path / "log.mf4", *groups)
    for k, name in enumerate(("0.1.q", "0.2.q", "0.q", "2.q")):
        assert np.array_equal(read_record(file, columns={"position": name}).position, Q + k)
    with refuses("columns", says=r"0\.1\.q, 0\.2\.q, 2\.q, 1\.1\.0\.q"):
        read_record(file, columns={"position": "q"})


def test_mdf_samples_marked_as_invalid_are_told_and_counted(tmp_path: Path) -> None:
    invalid = np.isin(np.arange(N), [5, 7])
    file = mdf(tmp_path / "log.mf4", [(Q, T, "q", "")], invalidation_bits=invalid)
    with refuses("empty-cells", says=r"position is nan in data row 6 \(2 of 50"):
        read_record(file, columns={"position": "q"})
    record = read_record(file, columns={"position": "q"}, repairs=Repairs(resample="auto"))
    empty = record.provenance.repairs[0]
    assert (empty.kind, empty.count) == ("empty", 2)
    assert "q: 2 samples are marked as invalid" in record.provenance.assumed


@pytest.mark.parametrize("declared", ["t", "time"])
def test_time_column_that_the_axis_declares_gives_way_to_the_files_own_clocks(
    tmp_path: Path, declared: str
) -> None:
    """The logger of the axis writes a time column; this file has masters in its place."""
    axis = replace(
        load_axis("emps2015"), columns={"time": declared, "position": "q", "control": "u"}
    )
    both = [(Q, T, "q", ""), (U, T, "u", "")]
    file = mdf(tmp_path / "log.mf4", both)
    for given in (None, 1e-3):
        record = read_record(file, axis, sample_period=given)
        assert record.time == pytest.approx(T)
        told = f"no column {declared!r} for the time"
        assert any(note.startswith(told) for note in record.provenance.assumed)
    mdf(file, both, [(T[::2] + 9, T[::2], declared, "")])
    record = read_record(file, axis)
    assert record.time == pytest.approx(T)
    assert record.provenance.columns == {"position": "q", "control": "u"}
    assert any("has 25 rows, but the position has 50" in said for said in record.provenance.assumed)
    with refuses("time", says="the columns differ in length"):
        read_record(file, axis, columns={"time": declared})
