"""A format is one file and one row; everything else follows from the row."""

import gzip
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from axisid import Record, identify
from axisid.codegen import GeneratedAxis
from axisid.estimation.logs.formats import FORMATS
from tests.recipes import recipe_blocks

#: Puts the recipe's file beside the other readers, its row below theirs, and runs command lines.
_ADDED = """
import sys
from axisid.estimation import logs
logs.__path__.append({folder!r})
from axisid.estimation.logs import formats
from axisid.estimation.logs.daq import read_daq
from axisid.estimation.logs.formats import Format, Signature
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
