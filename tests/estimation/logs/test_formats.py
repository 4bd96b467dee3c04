"""A format is one file and one row; a file of another kind than its ending says is told by it."""

import gzip
import json
import os
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from axisid import (
    Record,
    read_record,
)
from axisid.codegen import GeneratedAxis
from axisid.estimation.logs.formats import FORMATS
from tests.recipes import recipe_blocks
from tests.refusals import refuses
from tests.unjudged import identify

#: Puts the recipe's file beside the other readers, its row below theirs, and runs command lines.
_ADDED = """
import sys
from axisid.estimation import logs
logs.__path__.append({folder!r})
from axisid.estimation.logs import formats
from axisid.estimation.logs.daq import read_daq
from axisid.estimation.logs.formats import Format
formats.FORMATS += ({row},)
from axisid.commands.main import main
for line in {lines!r}:
    sys.argv = ["axisid", *line.split()]
    try:
        main()
    except SystemExit:
        pass
"""


@pytest.fixture
def folder(tmp_path: Path, twin: Record) -> Path:
    """The file that the recipe shows, and a record as such a log, also under other endings."""
    (tmp_path / "readers").mkdir()
    (tmp_path / "readers" / "daq.py").write_text(recipe_blocks("Add a format of logs")[0])
    columns = (twin.time, 1e3 * twin.position, twin.reference, twin.control)
    log = b"DAQ1 time[s] position[mm] reference[m] control\n"
    log += np.column_stack([np.asarray(column) for column in columns]).astype("<f8").tobytes()
    for name in ("log.daq", "log.csv"):
        (tmp_path / name).write_bytes(log)
    (tmp_path / "log.daq.gz").write_bytes(gzip.compress(log))
    (tmp_path / "unknown.dat").write_bytes(b"\1\0\0" * 500)
    return tmp_path


def run(folder: Path, *lines: str) -> subprocess.CompletedProcess[str]:
    row = recipe_blocks("Add a format of logs")[1].strip()
    program = _ADDED.format(folder=str(folder / "readers"), row=row, lines=lines)
    return subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        env={**os.environ, "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=True,
    )


@pytest.mark.slow
def test_one_file_and_one_row_add_a_format_to_the_command(
    folder: Path, emps2015: GeneratedAxis, twin: Record
) -> None:
    logs = ("log.daq", "log.daq.gz")
    run(folder, *(f"identify emps2015 {log} --method idm-ls --json {log}.json" for log in logs))
    wanted = identify(emps2015, twin, methods=["idm-ls"])["idm-ls"].parameters
    for log in logs:
        (estimate,) = json.loads((folder / f"{log}.json").read_text())["estimates"]
        for name, parameter in estimate["parameters"].items():
            assert parameter["value"] == pytest.approx(wanted[name].value, rel=1e-9)


def test_every_format_is_in_the_documentation_with_its_endings_and_extra(root: Path) -> None:
    rows = [line for line in (root / "docs" / "logs.md").read_text().splitlines() if "|" in line]
    extras = tomllib.loads((root / "pyproject.toml").read_text())["project"][
        "optional-dependencies"
    ]
    for known in FORMATS:
        assert not known.extra or known.extra in extras
        for ending in known.endings:
            told = [row for row in rows if f"`{ending}`" in row]
            assert told or known.is_text, ending
            assert not known.extra or any(f"`{known.extra}`" in row for row in told)


TEXT = "time,position\n" + "\n".join(f"{k},{k % 7}.5" for k in range(40)) + "\n"


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("log.csv", b"PAR1....", r"a Parquet file.*ending \.parquet"),
        ("log.csv", b"MATLAB 5.0 MAT-file, made", r"a MATLAB file.*ending \.mat"),
        ("log.txt", b"\x89HDF\r\n\x1a\n", r"an HDF5 file.*ending \.mat"),
        ("log.dat", b"MDF     4.10", r"an MDF file.*ending \.mf4"),
        ("log.csv", b"TDSm\x0e\0\0\0", r"a TDMS file.*ending \.tdms"),
        ("log.csv.gz", TEXT.encode(), "not compressed by gzip"),
        ("log.xls", b"\xd0\xcf\x11\xe0\xa1\xb1", "an old Excel or Office file.*as CSV"),
        ("log.csv", b"\n<!DOCTYPE html><html></html>", "a page in HTML"),
        ("log.csv", b'<?xml version="1.0"?>', "an XML document"),
        ("log.csv", b'{"t": [1, 2]}', "a JSON document"),
        ("log.mat", TEXT.encode(), r"text, according to its content.*ending \.csv"),
        ("log.npz", TEXT.encode(), r"text, according to its content.*ending \.csv"),
        ("log.mf4", b"PAR1....", "a Parquet file"),
    ],
)
def test_kind_of_a_file_is_told_by_its_content(
    tmp_path: Path, name: str, content: bytes, message: str
) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    with refuses("log-file", says=message):
        read_record(file)


@pytest.mark.parametrize(
    ("inside", "message"),
    [("xl/workbook.xml", "Excel workbook.*sheet"), ("time.npy", r"a ZIP.*\.npz")],
)
def test_archives_are_told_by_what_is_inside(tmp_path: Path, inside: str, message: str) -> None:
    file = tmp_path / "log.xlsx"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(inside, "")
    with refuses("log-file", says=message):
        read_record(file)


@pytest.mark.parametrize("packing", ["gzip", "zstd"])
def test_packed_text_is_read_as_far_as_there_is_memory(tmp_path: Path, packing: str) -> None:
    pack: Callable[[bytes], bytes] = gzip.compress
    if packing == "zstd":
        pack = partial(pytest.importorskip("pyarrow").compress, codec="zstd", asbytes=True)
    plain, packed = (
        tmp_path / "log.csv",
        tmp_path / f"log.csv{'.gz' if packing == 'gzip' else '.zst'}",
    )
    plain.write_text(TEXT)
    content = pack(TEXT.encode())
    packed.write_bytes(content)
    record = read_record(packed)
    assert np.array_equal(record.position, read_record(plain).position)
    assert f"unpacked by {packing}" in record.provenance.assumed
    for file, wrong, code in (
        (plain, content, "log-file"),
        (packed, content[:-9], "log-file"),
        (packed, TEXT.encode(), "log-file"),
        (packed, pack(bytes(100_000_000)), "memory"),
    ):
        file.write_bytes(wrong)
        with refuses(code):
            read_record(file, max_memory=1e7)


def test_logs_are_regular_files_of_their_kind(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    for ending in (".csv", ".mat", ".mf4"):
        os.mkfifo(tmp_path / f"pipe{ending}")
    for name, message in (
        *((f"pipe{ending}", "regular file") for ending in (".csv", ".mat", ".mf4")),
        ("folder.csv", "a folder"),
        ("/dev/zero", ""),
    ):
        with refuses("log-file", says=message):
            read_record(tmp_path / name)
