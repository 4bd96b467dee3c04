"""The hash of a result is of the bytes that were used; a log that changes meanwhile is refused."""

import hashlib
from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from axisid.estimation.logs import formats, read_table
from axisid.estimation.records.record import Record
from axisid.estimation.tables.table import Table
from tests.refusals import refuses


def written(file: Path, twin: Record, factor: float = 1.0) -> Path:
    """A log of the twin, of one size whatever the factor of its control is."""
    columns = {
        "time": twin.time,
        "position": twin.position,
        "control": factor * np.array(twin.control),
    }
    if file.suffix == ".parquet":
        arrow = pytest.importorskip("pyarrow")
        options = {"compression": "none", "use_dictionary": False, "write_statistics": False}
        pytest.importorskip("pyarrow.parquet").write_table(arrow.table(columns), file, **options)
    else:
        table = np.column_stack(list(columns.values()))
        head = ",".join(columns)
        np.savetxt(file, table, fmt="%+.12e", delimiter=",", header=head, comments="")
    return file


def digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def longer(file: Path, _: Path) -> None:
    with file.open("ab") as stream:
        stream.write(b"\n")


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_hash_of_a_whole_log_is_of_the_bytes_that_were_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, twin: Record, ending: str
) -> None:
    file = written(tmp_path / f"log{ending}", twin)
    record = read_record(file)
    assert record.provenance.sha256 == digest(file)
    whole = Path.read_bytes

    def appended(self: Path) -> bytes:
        content = whole(self)
        longer(self, self)
        return content

    monkeypatch.setattr(Path, "read_bytes", appended)
    with refuses("log-file"):
        read_record(file)


def test_log_that_its_library_reads_is_held_against_its_hash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "log.mf4"
    file.write_bytes(b"MDF     4.10    ")

    def reading(path: Path, _: object) -> Table:
        longer(path, path)
        return Table(source=str(path), columns={})

    row = formats.Format(name="MDF", endings=(".mf4",), read_file=reading)
    monkeypatch.setattr(formats, "FORMATS", (row,))
    with refuses("log-file"):
        read_table(file)


def test_paths_stand_beside_each_other_as_given_and_absolute(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, twin: Record
) -> None:
    (tmp_path / "logs").mkdir()
    written(tmp_path / "logs" / "log.csv", twin)
    monkeypatch.chdir(tmp_path)
    for given in ("logs/log.csv", Path("logs", "log.csv")):
        provenance = read_record(given).provenance
        assert provenance.source == "log.csv"
        assert provenance.given == "logs/log.csv"
        assert provenance.path == str(tmp_path / "logs" / "log.csv")
    assert read_record({"time": twin.time, "position": twin.position}).provenance.path == ""
