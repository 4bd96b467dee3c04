"""NumPy archives are read; Python objects and names that occur twice are refused."""

from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest

from axisid import read_record
from tests.estimation.logs.samples import NAMED, N, Q, T, U
from tests.refusals import refuses


def test_numpy_archive(tmp_path: Path) -> None:
    file = tmp_path / "log.npz"
    joint = np.zeros(N, dtype=[("q", float), ("u", float)])
    joint["q"], joint["u"] = Q, U
    np.savez(file, time=T, joint=joint, M=np.column_stack([T, 2 * Q]), kp=np.array(3.0))
    record = read_record(file, columns=NAMED | {"reference": "M.2"})
    assert np.array_equal(record.position, Q)
    assert np.array_equal(record.control, U)
    assert np.array_equal(record.reference, 2 * Q)


def test_numpy_archive_of_objects_is_refused_since_it_could_run_code(tmp_path: Path) -> None:
    file = tmp_path / "log.npz"
    np.savez(file, time=np.array([{}, {}], dtype=object))
    with refuses("columns", says=r"time: Python objects, which could"):
        read_record(file)
    np.savez(file, time=T, position=Q, comment=np.array([{}], dtype=object))
    assert np.array_equal(read_record(file).position, Q)


def test_a_name_that_occurs_twice_in_an_archive_is_refused(tmp_path: Path) -> None:
    clash = tmp_path / "clash.npz"
    np.savez(clash, **{"data": np.column_stack([T, Q]), "data.1": T})
    twice = tmp_path / "twice.npz"
    np.savez(twice, time=T, position=Q)
    with ZipFile(twice, "a") as packed, pytest.warns(UserWarning, match="Duplicate"):
        packed.writestr("position.npy", packed.read("position.npy"))
    for file in (clash, twice):
        with refuses("columns", says="occurs twice"):
            read_record(file)
