"""A file of another kind than its ending says is told by its content, with what to do."""

import gzip
import os
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from axisid import read_record
from tests.refusals import refuses

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
        ("log.mat", TEXT.encode(), r"text by its content.*ending \.csv"),
        ("log.npz", TEXT.encode(), r"text by its content.*ending \.csv"),
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
    [("xl/workbook.xml", "an Excel workbook.*save the sheet"), ("time.npy", r"a ZIP.*\.npz")],
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
        *((f"pipe{ending}", "no regular file") for ending in (".csv", ".mat", ".mf4")),
        ("folder.csv", "a folder"),
        ("/dev/zero", ""),
    ):
        with refuses("log-file", says=message):
            read_record(tmp_path / name)
