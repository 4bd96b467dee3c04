"""The committed code is what the declarations give, and `generate` never harms a file."""

import functools
import hashlib
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from axisid import build, load_axis
from axisid.codegen.generated_axes.folder import check_files, expected_files, write_files
from axisid.modeling import LIBRARY
from tests.command_line import Refused, Run
from tests.files import text_file


@functools.cache
def library_files() -> dict[Path, str]:
    return expected_files([load_axis(name) for name in LIBRARY])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    generated = tmp_path / "generated"
    write_files(generated, library_files())
    return generated


@pytest.mark.slow
def test_committed_code_is_current(root: Path) -> None:
    assert check_files(root / "generated", library_files()) == []


FINE = (
    "from dataclasses import replace\nfrom axisid import load_axis\n"
    "emps = load_axis('emps')\n"
    "axis = replace(emps, name='fine', drive=replace(emps.drive, quantisation=1e-309))\n"
)


@pytest.mark.parametrize(
    ("text", "said"),
    [("1/0\n", "division by zero"), (FINE, "quantisation is 1e-309")],
    ids=["no axis", "a step that no float holds"],
)
def test_bad_axis_among_good_ones_writes_nothing(
    refused: Refused, tmp_path: Path, text: str, said: str
) -> None:
    bad = text_file(tmp_path / "bad.py", text)
    refused("generate", "emps", bad, "--output", tmp_path / "generated", says=said, code=4)
    assert not (tmp_path / "generated").exists()


@pytest.mark.slow
def test_text_is_the_same_in_a_fresh_process_with_another_hash_seed() -> None:
    program = (
        "from axisid.codegen.generated_axes import expected_files; from axisid import load_axis;"
        "from axisid.modeling import LIBRARY;"
        "import hashlib;"
        "print(hashlib.sha256(repr(sorted(expected_files(map(load_axis, LIBRARY)).items()))"
        ".encode()).hexdigest())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONHASHSEED": "77"},  # this process has a random one, or 0
        capture_output=True,
        text=True,
        check=True,
    )
    here = hashlib.sha256(repr(sorted(library_files().items())).encode()).hexdigest()
    assert done.stdout.strip() == here


@pytest.mark.parametrize("name", LIBRARY)
def test_committed_module_is_the_program_that_runs(root: Path, name: str) -> None:
    """Imported on its own, without axisid, the committed file gives the same functions."""
    namespace: dict[str, object] = {}
    exec((root / "generated" / name / "functions.py").read_text(), namespace)
    makers = namespace["FUNCTIONS"]
    assert isinstance(makers, dict)
    axis = build(load_axis(name))
    assert set(makers) == set(axis.functions)
    rng = np.random.default_rng(4)
    for function, make in makers.items():
        alone, built = make(), axis.functions[function]
        arguments = [rng.uniform(0.1, 1.0, built.size_in(i)) for i in range(built.n_in())]
        for a, b in zip(alone.call(arguments), built.call(arguments), strict=True):
            assert np.array_equal(a.full(), b.full())


@pytest.mark.slow
def test_check_tells_stale_missing_and_orphan_files_and_the_command(run: Run, folder: Path) -> None:
    assert run("generate", "--check", "--output", folder)[0] == 0
    stale = folder / "emps" / "functions.py"
    stale.write_text(stale.read_text().replace("casadi.if_else", "casadi.fmax"))
    (folder / "emps2015" / "equations.txt").unlink()
    (folder / "old").mkdir()
    (folder / "old" / "functions.py").write_text("")
    code, out, err = run("generate", "--check", "--output", folder)
    assert code == 1
    assert f"stale: {stale}" in out
    assert "missing: " in out
    assert "orphan: " in out
    assert f"Run: axisid generate --output {folder}" in err
    assert run("generate", "--output", folder)[0] == 0
    shutil.rmtree(folder / "old")
    assert run("generate", "--check", "--output", folder)[0] == 0


@pytest.mark.parametrize("named", [True, False])
def test_check_finds_what_is_left_of_axes_that_are_gone_and_foreign_files(
    folder: Path, named: bool
) -> None:
    (folder / "emps").rename(folder / "gone")
    (folder / "emptied" / "__pycache__").mkdir(parents=True)
    (folder / "crank" / "notes.txt").write_text("x")
    (folder / "crank" / "lost").symlink_to(folder / "nowhere")
    (folder / "beside.txt").write_text("x")
    left = {path: text for path, text in library_files().items() if path.parts[0] != "emps"}
    checked = {p: t for p, t in left.items() if p.parts[0] == "crank"} if named else left
    found = check_files(folder, checked, others=LIBRARY if named else None)
    assert {finding.state for finding in found} == {"orphan"}
    foreign = {
        "crank/notes.txt",
        "crank/lost",
        *(f"gone/{p.name}" for p in library_files() if p.parts[0] == "emps"),
    }
    beside = set() if named else {"beside.txt", "emptied"}
    assert {str(finding.path) for finding in found} == foreign | beside


def test_user_axis_is_generated_into_a_folder_of_its_name(run: Run, tmp_path: Path) -> None:
    mine = text_file(
        tmp_path / "mine.py",
        "from dataclasses import replace\nfrom axisid import load_axis\n"
        "axis = replace(load_axis('emps'), name='mine')\n",
    )
    assert run("generate", mine, "--output", tmp_path / "generated")[0] == 0
    code = tmp_path / "generated" / "mine" / "functions.py"
    whole = code.read_text()
    code.write_text("<<<<<<< HEAD")  # a generated folder is made anew whatever became of its files
    assert run("generate", mine, "--output", tmp_path / "generated")[0] == 0
    assert code.read_text() == whole
    assert run("generate", mine, "--check", "--output", tmp_path / "generated")[0] == 0


@pytest.mark.slow
def test_file_size_limit_leaves_the_old_file_whole(folder: Path) -> None:
    """A real limit in a real process: the write is cut in the middle."""
    target = text_file(folder / "emps" / "functions.py", "old")

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    done = subprocess.run(
        [sys.executable, "-B", "-m", "axisid", "generate", "--force", "--output", str(folder)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=limit,
    )
    assert done.returncode == 2
    assert "cannot be written" in done.stderr
    assert target.read_text() == "old"
    assert not list(folder.rglob(".*"))


def test_output_that_is_a_file_is_refused(refused: Refused, tmp_path: Path) -> None:
    (tmp_path / "generated").write_text("mine")
    refused("generate", "--output", tmp_path / "generated", says="is a file")
    assert (tmp_path / "generated").read_text() == "mine"


def test_binary_rubbish_in_place_of_code_is_stale_not_a_crash(folder: Path) -> None:
    (folder / "emps" / "functions.py").write_bytes(b"\xff\xfe\x00")
    findings = check_files(folder, expected_files([load_axis("emps")]), others=LIBRARY)
    assert [f.state for f in findings] == ["stale"]


def test_two_axes_of_one_name_are_refused(refused: Refused, tmp_path: Path) -> None:
    says = "two axes are named 'emps'"
    refused("generate", "emps", "emps", "--output", tmp_path / "g", says=says)
