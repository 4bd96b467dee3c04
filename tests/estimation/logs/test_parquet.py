"""Parquet files are read with their units and time stamps."""

from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from tests.estimation.logs.samples import NAMED, STAMPS, N, Q, T, U


def test_parquet_with_time_stamps_and_units_of_its_fields(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    schema = pa.schema(
        [
            pa.field("time", pa.timestamp("us")),
            pa.field("q", pa.float64(), metadata={"unit": "deg"}),
            pa.field("u [mA]", pa.float64()),
            pa.field("state", pa.string()),
        ]
    )
    file = tmp_path / "log.parquet"
    parquet.write_table(pa.table([STAMPS, Q, U, ["run"] * N], schema=schema), file)
    record = read_record(file, columns=NAMED)
    assert record.time == pytest.approx(T, abs=1e-12)
    assert record.position == pytest.approx(np.radians(Q), rel=1e-15)
    assert record.control == pytest.approx(1e-3 * U, rel=1e-15)
    assert {"position: deg -> rad", "control: mA -> A"} <= set(record.provenance.assumed)
    assert "time: time stamps, relative to the first" in record.provenance.assumed
