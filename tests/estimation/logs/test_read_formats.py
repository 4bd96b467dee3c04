"""Damaged files, missing libraries and mixed columns are explained, whatever the format."""

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from axisid import DataError, read_record
from tests.estimation.logs.samples import N, Q, T, U
from tests.files import text_file
from tests.refusals import refuses

ENDINGS = {
    ".npz": "numpy",
    ".parquet": "pyarrow",
    ".tdms": "nptdms",
    ".mf4": "asammdf",
    ".bag": "rosbags",
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_damaged_files_are_explained(tmp_path: Path, ending: str) -> None:
    pytest.importorskip(ENDINGS[ending])
    file = tmp_path / f"log{ending}"
    file.write_bytes(b"not what it seems" * 20)
    with pytest.raises(DataError, match=rf"log\{ending} cannot be read as an? ") as caught:
        read_record(file)
    assert not str(caught.value).endswith("..")


@pytest.mark.parametrize(
    ("ending", "library", "extra"),
    [
        (".parquet", "pyarrow.parquet", "parquet"),
        (".tdms", "nptdms", "tdms"),
        (".mf4", "asammdf", "mdf"),
        (".bag", "rosbags.highlevel", "rosbags"),
    ],
)
def test_library_that_is_not_installed_is_named_with_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, library: str, extra: str
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    file = tmp_path / f"log{ending}"
    file.write_bytes(b"x")
    name = library.partition(".")[0]
    with refuses(
        "missing-library", says=rf"needs the library {name}.*extra {extra}.*pip install {name}"
    ):
        read_record(file)


@pytest.mark.parametrize("kind", ["json", "records", "mapping", "dataframe"])
def test_truths_among_numbers_are_no_column(tmp_path: Path, kind: str) -> None:
    """A column of nothing else is one, as of a switch."""
    pandas = pytest.importorskip("pandas")
    columns = {
        "time": T.tolist(),
        "position": Q.tolist(),
        "on": [False, *[True] * (N - 1)],
        "u": [True, *U[1:].tolist()],
    }
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    logs: dict[str, Any] = {
        "json": lambda: text_file(tmp_path / "log.json", json.dumps(columns)),
        "records": lambda: text_file(tmp_path / "log.json", json.dumps(rows)),
        "mapping": lambda: columns,
        "dataframe": lambda: pandas.DataFrame(columns),
    }
    log = logs[kind]()
    assert read_record(log, columns={"control": "on"}).control.sum() == N - 1
    with refuses("columns", says="true or false among numbers"):
        read_record(log, columns={"control": "u"})
