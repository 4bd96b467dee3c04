"""The numbers of a study as files."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from pyarrow.parquet import read_schema as parquet_schema

from axisid.estimation.monte_carlo.result import write_runs
from tests.estimation.monte_carlo.short import judged
from tests.refusals import refuses


def test_npz_and_parquet_have_the_same_columns(tmp_path: Path) -> None:
    npz, parquet = tmp_path / "runs.npz", tmp_path / "runs.parquet"
    for file in (npz, parquet):
        write_runs(judged(), file)
    frame = pl.read_parquet(parquet)
    with np.load(npz) as arrays:
        assert frame.columns == [name for name in arrays if name != "axisid.monte_carlo"]
        for name in frame.columns:
            assert np.array_equal(arrays[name].astype(str), frame[name].to_numpy().astype(str))
        told = json.loads(str(arrays["axisid.monte_carlo"]))
    assert told["seed"] == 1
    assert told["truth"]["idm-iv.M"] == 100.2
    assert told["noise"]["correlation_time"] == 0
    assert told["chain"]["position"] == told["noise"]["position"] == 3.8e-6
    assert told["prefilter"]["cutoff"] == 60
    assert told["settings"]["covariance"] == "hac"
    assert told["checks"] == 1
    units = {f.name: (f.metadata or {}).get(b"unit", b"") for f in parquet_schema(parquet)}
    assert {name: unit.decode() for name, unit in units.items() if unit} == told["units"]
    assert (units["idm-iv.M"], units["idm-iv.Fc.hac.low"], units["run"]) == (b"kg", b"N", b"")
    assert units["ddm-ls.direct.theta1"] == b"1/kg"


@pytest.mark.parametrize("name", ["runs.csv", "runs"])
def test_other_endings_are_refused(tmp_path: Path, name: str) -> None:
    with refuses("study"):
        write_runs(judged(), tmp_path / name)


def test_a_file_that_cannot_be_written_is_the_users(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with refuses("usage"):
        write_runs(judged(), tmp_path / "file" / "runs.npz")
