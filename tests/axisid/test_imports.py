"""Importing is cheap, stages are used one way, and text is never evaluated."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import axisid

ORDER = ["axisid.modeling", "axisid.codegen", "axisid.estimation"]
FOLDERS = {
    "axisid.modeling": "modeling",
    "axisid.codegen": "codegen",
    "axisid.estimation": "estimation",
}


def imported_by(statement: str) -> set[str]:
    program = f"import sys, json\n{statement}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_import_axisid_brings_nothing_heavy() -> None:
    modules = imported_by("import axisid")
    assert not modules & {"numpy", "scipy", "sympy", "casadi", "matplotlib", "click"}


def test_the_command_line_starts_without_the_stages() -> None:
    modules = imported_by("import axisid.cli")
    assert not modules & {"numpy", "scipy", "sympy", "casadi", "matplotlib"}


def test_the_stages_leave_signal_processing_and_figures_to_their_use() -> None:
    modules = imported_by("import axisid.modeling, axisid.codegen, axisid.estimation")
    assert not modules & {"scipy.signal", "scipy.io", "matplotlib", "pytest"}


def test_importing_axisid_is_quick() -> None:
    """The promise is half a second; the table of -X importtime is free of other processes' load."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", "import axisid"],
        capture_output=True,
        text=True,
        check=True,
    )
    total = [line for line in done.stderr.splitlines() if line.endswith("| axisid")]
    assert int(total[0].split("|")[1]) < 500_000


def test_every_public_name_resolves_and_is_typed() -> None:
    source = Path(axisid.__file__).read_text()
    typed = {
        alias.asname or alias.name
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("axisid.")
        for alias in node.names
    }
    assert typed | {"__version__"} == set(axisid.__all__) == set(dir(axisid))
    for name in axisid.__all__:
        assert getattr(axisid, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        axisid.nonsense  # noqa: B018


def sources(root: Path, stage: str) -> list[Path]:
    return sorted((root / FOLDERS[stage]).rglob("*.py"))


@pytest.mark.parametrize("stage", ORDER)
def test_stages_are_imported_one_way(root: Path, stage: str) -> None:
    later = [
        *ORDER[ORDER.index(stage) + 1 :],
        "axisid.cli",
        "axisid.paper",
        "axisid.figures",
        "axisid.report",
    ]
    for file in sources(root, stage):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [a.name for a in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                assert not any(name == s or name.startswith(f"{s}.") for s in later), file
                assert name != "axisid", file


def test_estimation_knows_no_sympy_and_modeling_no_numerics(root: Path) -> None:
    banned = {
        "axisid.estimation": {"sympy", "casadi"},
        "axisid.modeling": {"numpy", "scipy", "casadi"},
    }
    for stage, packages in banned.items():
        for file in sources(root, stage):
            for node in ast.walk(ast.parse(file.read_text())):
                if isinstance(node, ast.Import):
                    assert not {a.name.split(".")[0] for a in node.names} & packages, file
                elif isinstance(node, ast.ImportFrom):
                    assert (node.module or "").split(".")[0] not in packages, file


def test_commands_know_nothing_of_the_command_line_that_gathers_them(root: Path) -> None:
    files = {f.stem: f.read_text() for f in sorted((root / "src" / "axisid").glob("*.py"))}
    assert {name for name, text in files.items() if "axisid.cli" in text} == {"__main__"}
    assert "click.option" not in files["cli"]


def test_no_function_that_evaluates_text_is_called(root: Path) -> None:
    banned = {"sympify", "parse_expr", "lambdify", "eval", "S", "simplify"}
    for stage in ORDER:
        for file in sources(root, stage):
            for node in ast.walk(ast.parse(file.read_text())):
                if isinstance(node, ast.Call):
                    name = getattr(node.func, "attr", getattr(node.func, "id", ""))
                    assert name not in banned, f"{file}:{node.lineno} calls {name}"
                    allowed = file.name == "execute.py" and stage == "axisid.codegen"
                    assert name != "exec" or allowed, f"{file}:{node.lineno} calls exec"
