"""A log in blocks is the log read whole: values, names, and what is assumed of it."""

from pathlib import Path

import numpy as np
import pytest

from axisid import LogBlocks, read_record

N = 400
TIME = 1e-3 * np.arange(N)
POSITION = np.sin(30 * TIME)
COLUMNS = {"time": "t", "position": "q"}


def agree(file: Path, columns: dict[str, str], rows: int = 37) -> None:
    """Blocks of a file hold what its record holds."""
    record = read_record(file, columns=columns)
    blocks = LogBlocks(file=file, columns=columns, rows=rows)
    read = list(blocks)
    for role in columns:
        joined = np.concatenate([block[role] for block in read])
        assert joined == pytest.approx(record.channels()[role], rel=1e-12, abs=1e-12)
    assert blocks.provenance().assumed == record.provenance.assumed


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_names_that_differ_by_the_unit_only_are_told_apart(tmp_path: Path, ending: str) -> None:
    file = tmp_path / f"log{ending}"
    columns = {"t [s]": TIME, "q [mm]": POSITION, "q [m]": 7 * POSITION}
    if ending == ".csv":
        rows = [";".join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)]
        file.write_text("\n".join([";".join(columns), *rows]))
    else:
        pa = pytest.importorskip("pyarrow")
        pytest.importorskip("pyarrow.parquet").write_table(pa.table(columns), file)
    wanted = {"time": "t", "position": "q [mm]"}
    agree(file, wanted)
    (first, *_) = LogBlocks(file=file, columns=wanted)
    assert first["position"] == pytest.approx(1e-3 * POSITION)
