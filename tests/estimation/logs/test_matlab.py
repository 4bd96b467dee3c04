"""MATLAB files of every version; objects that only MATLAB opens come with the command to run."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from axisid import read_record
from tests.refusals import refuses

N = 40
T = 1e-3 * np.arange(N)
Q = np.sin(T * 200)
COLUMNS = {"time": "t", "position": "q"}


def hdf5(file: Path, fill: Callable[[Any], None]) -> Path:
    """A v7.3 file: HDF5 behind MATLAB's own header of 512 bytes."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(file, "w", userblock_size=512) as content:
        fill(content)
    with file.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    return file


def stored(group: Any, name: str, values: np.ndarray, kind: str = "double") -> Any:
    data = group.create_dataset(name, data=np.atleast_2d(values))
    data.attrs["MATLAB_class"] = np.bytes_(kind)
    return data


@pytest.mark.parametrize("version", ["4", "5"])
def test_vectors_are_columns(tmp_path: Path, version: str) -> None:
    file = tmp_path / "log.mat"
    savemat(file, {"t": T, "q": Q, "kp": 3.0}, format=version)  # type: ignore[arg-type]
    assert np.array_equal(read_record(file, columns=COLUMNS).position, Q)


def test_structures_cells_and_matrices_have_dotted_names_numbered_as_in_matlab(
    tmp_path: Path,
) -> None:
    file = tmp_path / "log.mat"
    signals = np.array([{"label": "set", "values": 2 * Q}, {"label": "act", "values": Q}])
    cells = np.empty((2, 2), dtype=object)
    cells[0, 0], cells[1, 0], cells[0, 1], cells[1, 1] = T, "text", Q, 2 * Q
    structures = np.empty((2, 2), dtype=[("v", object)])
    for k, place in enumerate(((0, 0), (1, 0), (0, 1), (1, 1))):
        structures[place] = (k * Q,)
    out = {"time": T, "signals": signals}
    savemat(file, {"out": out, "M": np.column_stack([T, Q]), "c": cells, "s": structures})
    for named, times in (("out.signals.2.values", 1), ("M.2", 1), ("c.3", 1), ("s.4.v", 3)):
        record = read_record(file, columns={"time": "out.time", "position": named})
        assert np.array_equal(record.position, times * Q)
    with refuses("columns", says=r"out\.time, out\.signals\.1\.values"):
        read_record(file)
    with refuses("columns", says=r"column 'c\.2' for the position"):
        read_record(file, columns={"position": "c.2"})


def test_matrix_that_is_wider_than_long_is_taken_by_its_rows(tmp_path: Path) -> None:
    file = tmp_path / "log.mat"
    savemat(file, {"ans": np.vstack([T, Q, 2 * Q])})  # as Simulink's To File writes it
    record = read_record(file, columns={"time": "ans.1", "position": "ans.2", "force": "ans.3"})
    assert np.array_equal(record.position, Q)
    assert np.array_equal(record.force, 2 * Q)
    notes = [note for note in record.provenance.assumed if "wider than long" in note]
    assert notes == ["ans: wider than long, so its rows are read as columns"]


def referred(content: Any, values: list[np.ndarray]) -> Any:
    """References to data sets of their own, as MATLAB stores the elements of cells."""
    h5py = pytest.importorskip("h5py")
    kept = content.require_group("#refs#")
    references = np.empty((len(values), 1), dtype=h5py.ref_dtype)
    for k, each in enumerate(values):
        references[k, 0] = stored(kept, f"r{len(kept)}", each).ref
    return references


def test_version_7_3_is_read_as_the_others_are(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")

    def fill(content: Any) -> None:
        log, scope = content.create_group("log"), content.create_group("scope")
        stored(log, "t", T)
        stored(log, "M", np.vstack([Q, 3 * Q]))  # MATLAB stores a matrix transposed
        stored(log, "name", np.frombuffer(b"axis", dtype="u1").astype("u2"), "char")
        cells = content.create_dataset("c", data=referred(content, [T, Q]), dtype=h5py.ref_dtype)
        cells.attrs["MATLAB_class"] = np.bytes_("cell")
        signals = scope.create_group("signals")
        signals.attrs["MATLAB_class"] = np.bytes_("struct")
        references = referred(content, [2 * Q, 3 * Q])
        signals.create_dataset("values", data=references, dtype=h5py.ref_dtype)
        content["nothing"] = h5py.Empty("f8")
        content["complex"] = Q + 1j

    file = hdf5(tmp_path / "log.mat", fill)
    for time, position, force in (
        ("c.1", "c.2", "scope.signals.2.values"),
        ("log.t", "log.M.1", "log.M.2"),
    ):
        record = read_record(file, columns={"time": time, "position": position, "force": force})
        assert np.array_equal(record.position, Q)
        assert np.array_equal(record.force, 3 * Q)
        assert "MATLAB v7.3" in record.provenance.assumed
    for wanted, said in (
        ("complex", "'complex' for the position"),
        ("q", r"c\.1, c\.2, log\.M\.1, log\.M\.2, log\.t"),
    ):
        with refuses("columns", says=said):
            read_record(file, columns={"position": wanted})


def opaque(name: str) -> bytes:
    """A v7 file with one object, as MATLAB writes a timeseries: an opaque element."""

    def element(kind: int, data: bytes) -> bytes:
        return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    flags = element(6, struct.pack("<II", 17, 0))
    reference = element(6, struct.pack("<II", 13, 0)) + element(5, struct.pack("<ii", 1, 6))
    reference += element(1, b"") + element(6, struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1))
    inner = element(14, reference)
    names = b"".join(element(1, text) for text in (name.encode(), b"MCOS", b"timeseries"))
    header = b"MATLAB 5.0 MAT-file".ljust(116) + b"\0" * 8 + b"\x00\x01IM"
    return header + element(14, flags + names + inner)


def test_timeseries_of_version_7_is_explained_with_the_command(tmp_path: Path) -> None:
    file = tmp_path / "log.mat"
    file.write_bytes(opaque("pos"))
    with refuses("columns", says=r"the variables pos\. pos is an object.*t = pos\.Time"):
        read_record(file)


@pytest.mark.parametrize("kind", ["7.3", "7", "6"])
def test_damaged_file_is_explained(tmp_path: Path, rng: np.random.Generator, kind: str) -> None:
    file = tmp_path / "log.mat"
    if kind == "7.3":
        hdf5(file, lambda content: stored(content, "t", T))
    else:
        savemat(file, {"t": T, "q": rng.normal(size=1000)}, do_compression=kind == "7")
    whole = file.read_bytes()
    damaged = [whole[:size] for size in (130, 200, 513, 700, len(whole) // 2)]
    spoilt = rng.integers(200, len(whole), 20 if kind == "7" else 0)
    damaged += [whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :] for at in spoilt]
    for content in damaged:
        file.write_bytes(content)
        with refuses("log-file", says=r"log\.mat"):
            read_record(file)


@pytest.mark.parametrize("version", ["4", "5"])
def test_two_variables_of_one_name_are_refused(tmp_path: Path, version: str) -> None:
    """SciPy keeps one of them."""
    first, second = tmp_path / "first.mat", tmp_path / "second.mat"
    savemat(first, {"t": T, "q": Q}, format=version)
    savemat(second, {"q": 2 * Q}, format=version)
    head = 128 if version == "5" else 0
    file = tmp_path / "both.mat"
    file.write_bytes(first.read_bytes() + second.read_bytes()[head:])
    with refuses("columns", says="occurs twice"):
        read_record(file, columns=COLUMNS)
