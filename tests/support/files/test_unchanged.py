"""The hash of a result is of the bytes that were used; a log that changes meanwhile is refused."""

import hashlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from axisid import DataError, read_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import LogBlocks, identify_stream
from axisid.estimation.logs import formats, read_table
from axisid.estimation.records.record import Record
from axisid.estimation.tables.table import Table
from axisid.support.files.unchanged import HashingStream, read_whole
from tests.refusals import refuses

CHANGED = "changed while it was read. Wait until what writes it has closed it"


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


def replaced(file: Path, other: Path) -> None:
    os.replace(other, file)


def rewritten(file: Path, other: Path) -> None:
    """In place, of the same size, and with the old time: only the bytes tell."""
    status = file.stat()
    with file.open("r+b") as stream:
        stream.write(other.read_bytes())
    assert file.stat().st_size == status.st_size
    os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))


def longer(file: Path, _: Path) -> None:
    with file.open("ab") as stream:
        stream.write(b"\n")


def gone(file: Path, _: Path) -> None:
    file.unlink()


class Changing:
    """Blocks of a log that is changed before the second pass."""

    def __init__(self, blocks: LogBlocks, change: Callable[[], None]) -> None:
        self.blocks, self.change, self.passes = blocks, change, 0

    def __iter__(self) -> Iterator[dict[str, np.ndarray]]:
        self.passes += 1
        if self.passes == 2:
            self.change()
        return iter(self.blocks)


@pytest.mark.parametrize("change", [replaced, rewritten, longer, gone])
@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_log_that_changes_between_passes_is_refused(
    tmp_path: Path,
    emps2015: GeneratedAxis,
    twin: Record,
    ending: str,
    change: Callable[[Path, Path], None],
) -> None:
    file = written(tmp_path / f"log{ending}", twin)
    other = written(tmp_path / f"other{ending}", twin, factor=0.5)
    assert file.stat().st_size == other.stat().st_size
    blocks = LogBlocks(file=file, axis=emps2015.axis, rows=1000)
    provenance = blocks.provenance()
    assert provenance.sha256 == digest(file)
    assert provenance.path == str(file)
    message = CHANGED if change is not gone else "No such file"
    with pytest.raises(DataError, match=message):
        identify_stream(
            emps2015, Changing(blocks, lambda: change(file, other)), provenance=provenance
        )


@pytest.mark.parametrize("change", [replaced, rewritten, longer])
def test_log_that_changes_during_a_pass_is_refused(
    tmp_path: Path, emps2015: GeneratedAxis, twin: Record, change: Callable[[Path, Path], None]
) -> None:
    file = written(tmp_path / "log.csv", twin)
    other = written(tmp_path / "other.csv", twin, factor=0.5)
    blocks = LogBlocks(file=file, axis=emps2015.axis, rows=1000)
    passing = iter(blocks)
    next(passing)
    change(file, other)
    with refuses("changed-file"):
        list(passing)


def test_log_that_stays_is_read_as_often_as_it_is_asked_for(
    tmp_path: Path, emps2015: GeneratedAxis, twin: Record
) -> None:
    file = written(tmp_path / "log.csv", twin)
    blocks = LogBlocks(file=file, axis=emps2015.axis, rows=1000)
    for _ in range(3):
        assert sum(len(block["position"]) for block in blocks) == len(twin)
        next(iter(blocks))  # a pass that is given up does no harm
    assert blocks.provenance().sha256 == digest(file)


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
    with refuses("changed-file"):
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
    with refuses("changed-file"):
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
    told = LogBlocks(file=Path("logs/log.csv")).provenance()
    assert (told.given, told.path) == ("logs/log.csv", str(tmp_path / "logs" / "log.csv"))
    assert read_record({"time": twin.time, "position": twin.position}).provenance.path == ""


def test_stream_is_hashed_whole_in_whatever_order_it_is_read(
    tmp_path: Path, rng: np.random.Generator
) -> None:
    file = tmp_path / "log"
    file.write_bytes(rng.bytes(3_000_001))
    with HashingStream(file) as raw:
        for start in rng.integers(0, 3_000_000, 20):
            raw.seek(int(start))
            raw.read(int(rng.integers(1, 200_000)))
        raw.seek(0)
        raw.read(70_000)
        raw.read(10)
        raw.seek(5)
        raw.read(100_000)
        assert raw.digest() == digest(file)
    assert read_whole(file)[1] == digest(file)
