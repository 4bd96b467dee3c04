"""A target is one file and one row; everything else follows from the row."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from axisid import build, identify, load_axis, twin_record
from tests.recipes import recipe_blocks

#: Puts the recipe's file beside the other printers, and its row below theirs.
_ADDED = """
from axisid.codegen import printers
from axisid.exports import targets
from axisid.exports.targets import _PRINTERS, Target

printers.__path__.append({folder!r})
targets.TARGETS += ({row},)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result, and the file that the recipe for a target shows."""
    folder = tmp_path_factory.mktemp("toy")
    axis = build(load_axis("emps2015"))
    result = identify(axis, twin_record(axis))
    (folder / "result.json").write_text(json.dumps(result.to_dict()))
    (folder / "printers").mkdir()
    (folder / "printers" / "javascript.py").write_text(recipe_blocks("Add a target")[0])
    return folder


def run(folder: Path, then: str) -> str:
    row = recipe_blocks("Add a target")[1].strip()
    program = _ADDED.format(folder=str(folder / "printers"), row=row) + then
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        env={**os.environ, "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


#: What `run` is to run: command lines, one after the other.
COMMANDS = """
import sys
from axisid.commands.main import main
for line in {lines!r}:
    sys.argv = ["axisid", *line.split()]
    try:
        main()
    except SystemExit as end:
        assert not end.code, line
"""
EXPORT = "export result.json --axis emps2015 --to js"


def commands(*lines: str) -> str:
    return COMMANDS.format(lines=lines)


@pytest.mark.slow
def test_one_file_and_one_row_add_a_target_to_the_command(folder: Path) -> None:
    # An earlier export is known and written anew.
    text = run(folder, commands(EXPORT, *[f"{EXPORT} -o emps2015.js"] * 2))
    assert "export function emps2015_feedforward(q, dq, ddq) {" in text
    assert "const M = " in text
    assert "Math.sign(dq)" in text
    assert "const tau = emps2015_feedforward(q, dq, ddq);" in text
    assert "return (" in text
    assert (folder / "emps2015.js").read_text() == text
