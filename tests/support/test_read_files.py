"""A log that unfolds beyond the room for it, or changes while it is read, is refused."""

import gzip
import hashlib
import io
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from axisid import read_record
from axisid.estimation.logs import formats, read_table
from axisid.estimation.raw_tables.table import Table
from axisid.estimation.records.record import Record
from axisid.support import memory
from tests.bounded import within
from tests.command_line import Refused
from tests.estimation.logs.test_rosbag import bag_of
from tests.files import csv_file, text_file
from tests.refusals import refuses

ROOM = 20e6  # bytes; each file below unfolds to more and is smaller by far
MEGABYTE = 1_000_000


def array_of_zeros(count: int, kind: str) -> bytes:
    """An array as NumPy writes it."""
    stream = io.BytesIO()
    head = {"descr": kind, "fortran_order": False, "shape": (count,)}
    np.lib.format.write_array_header_1_0(stream, head)
    return stream.getvalue() + bytes(count * np.dtype(kind).itemsize)


def archive(folder: Path, kind: str) -> Path:
    file = folder / "log.npz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("position.npy", array_of_zeros(10 * MEGABYTE, kind))
        packed.writestr("control.npy", array_of_zeros(10 * MEGABYTE, kind))
    return file


def text(folder: Path) -> Path:
    file = folder / "log.csv.gz"
    rows = b"position,control\n" + b"0,0\n" * MEGABYTE
    file.write_bytes(gzip.compress(rows))
    return file


def archive_in_gzip(folder: Path) -> Path:
    file = folder / "log.npz.gz"
    file.write_bytes(gzip.compress(bytes(100 * MEGABYTE)))
    return file


def matlab(folder: Path) -> Path:
    file = folder / "log.mat"
    savemat(file, {"position": np.zeros(5 * MEGABYTE)}, do_compression=True)
    return file


def matlab_of_version_7_3(folder: Path) -> Path:
    h5py = pytest.importorskip("h5py")
    file = folder / "log.mat"
    with h5py.File(file, "w", userblock_size=512) as content:
        # Chunks that were never written take no place in the file.
        made = content.create_dataset("position", (1, 10**12), "f8", chunks=(1, 10**6))
        made.attrs["MATLAB_class"] = np.bytes_("double")
    return file


def parquet(folder: Path) -> Path:
    arrow = pytest.importorskip("pyarrow")
    file = folder / "log.parquet"
    table = arrow.table({"position": np.zeros(4 * MEGABYTE), "control": np.zeros(4 * MEGABYTE)})
    pytest.importorskip("pyarrow.parquet").write_table(table, file)
    return file


def measurement(folder: Path) -> Path:
    asammdf = pytest.importorskip("asammdf")
    file = folder / "log.mf4"
    clock = np.arange(2 * MEGABYTE) * 1e-3
    zeros = np.zeros(len(clock), dtype=np.uint8)
    signals = [asammdf.Signal(zeros, clock, name=name) for name in ("position", "control")]
    with asammdf.MDF(version="4.10") as mdf:
        mdf.append(signals)
        mdf.save(file, overwrite=True, compression=2)
    return file


@pytest.mark.parametrize(
    "make",
    [
        text,
        archive_in_gzip,
        lambda folder: archive(folder, "|i1"),
        lambda folder: archive(folder, "<f8"),
        matlab,
        matlab_of_version_7_3,
        parquet,
        measurement,
    ],
    ids=["text", "archive in gzip", "bytes", "doubles", "matlab", "matlab 7.3", "parquet", "mdf"],
)
def test_packed_log_is_refused_before_it_is_unfolded(
    tmp_path: Path, make: Callable[[Path], Path]
) -> None:
    file = make(tmp_path)
    tracemalloc.start()
    refused = refuses("memory", r"would need more than 0\.02 GB.*max_memory = BYTES")
    with within(100_000), refused:
        read_record(file, max_memory=ROOM)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2.5 * ROOM


def test_messages_of_a_bag_are_counted(tmp_path: Path) -> None:
    file = bag_of(tmp_path, [("/joint_states", k, k, [0.0]) for k in range(100)])
    with refuses("memory"):
        read_record(file, max_memory=1e5)


def test_a_file_too_large_to_read_is_to_be_cut_into_shorter_ones(tmp_path: Path) -> None:
    """Windows would not do: the whole file is read before they are taken."""
    file = text_file(tmp_path / "log.csv", "time,position\n" + "0,1\n" * 1000)
    with refuses("memory", says="into shorter files, .* as several records") as refused:
        read_record(file, max_memory=1e5)
    assert "max_memory" in str(refused.value)
    assert "window" not in str(refused.value)
    with refuses("memory"):
        read_record(file, windows=[(0.0, 1.0)], max_memory=1e5)


def test_log_that_fits_is_read(tmp_path: Path) -> None:
    rows = "\n".join(f"{k},{k % 7}.5,{k % 5}" for k in range(2000))
    file = text_file(tmp_path / "log.csv", f"time,position,control\n{rows}\n")
    need = 3 * file.stat().st_size + 200 * 2001
    assert len(read_record(file, max_memory=need)) == 2000
    with refuses("memory"):
        read_record(file, max_memory=need - 1)
    assert len(read_record(file, max_memory=float("inf"))) == 2000


def test_more_samples_than_can_be_identified_are_refused_unless_the_user_allows_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "memory.max").write_text(f"{64 << 20}\n")
    monkeypatch.setattr(memory, "_LIMITS", (tmp_path / "memory.max",))
    time = 1e-3 * np.arange(60_000)
    file = tmp_path / "log.npz"
    np.savez_compressed(file, time=time, position=np.sin(time), control=np.cos(time))
    told = "identifying the 60000 samples of .*, half of the machine's memory"
    with refuses("memory", says=told) as refused:
        read_record(file)
    assert 'windows=["FROM..TO"]' in str(refused.value)
    assert len(read_record(file, windows=[(0.0, 20.0)])) == 20_001
    assert len(read_record(file, max_memory=1e9)) == 60_000


def test_lack_of_memory_exits_3(refused: Refused, monkeypatch: pytest.MonkeyPatch) -> None:
    def exhausted(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("axisid.estimation.identification.identify", exhausted)
    says = "there is not enough memory for this record"
    assert refused("identify", "emps2015", says=says, code=3).count("\n") == 1


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
        csv_file(file, columns, "%+.12e")
    return file


def longer(file: Path, _: Path) -> None:
    with file.open("ab") as stream:
        stream.write(b"\n")


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_hash_of_a_whole_log_is_of_the_bytes_that_were_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, twin: Record, ending: str
) -> None:
    file = written(tmp_path / f"log{ending}", twin)
    record = read_record(file)
    assert record.provenance.sha256 == hashlib.sha256(file.read_bytes()).hexdigest()
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


def test_paths_stand_beside_each_other_as_given_and_absolute(here: Path, twin: Record) -> None:
    (here / "logs").mkdir()
    written(here / "logs" / "log.csv", twin)
    for given in ("logs/log.csv", Path("logs", "log.csv")):
        provenance = read_record(given).provenance
        assert provenance.source == "log.csv"
        assert provenance.given == "logs/log.csv"
        assert provenance.path == str(here / "logs" / "log.csv")
    assert read_record({"time": twin.time, "position": twin.position}).provenance.path == ""
