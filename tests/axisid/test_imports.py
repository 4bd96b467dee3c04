"""Importing is cheap, every public name is there, and text is never evaluated."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import axisid
from axisid import Record, identify
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.commands.options import stages

STAGES = ("modeling", "codegen", "estimation")


def imported_by(statement: str) -> set[str]:
    program = f"import sys, json\n{statement}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize(
    ("module", "other"), [("axisid", "click"), ("axisid.commands.main", "rich")]
)
def test_axisid_and_the_command_line_start_without_the_stages(module: str, other: str) -> None:
    modules = imported_by(f"import {module}")
    assert not modules & {"numpy", "scipy", "sympy", "casadi", "matplotlib", other}


def test_what_a_command_takes_of_a_room_is_kept_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("axisid.estimation.identification.identify", None)
    assert stages.identify is None
    monkeypatch.undo()
    assert axisid.identify is stages.identify is identify


@pytest.mark.slow
def test_the_stages_and_saved_results_leave_searches_signals_and_figures_to_their_use(
    emps2015: GeneratedAxis, twin: Record, tmp_path: Path
) -> None:
    file = tmp_path / "result.json"
    identify(emps2015, twin, methods=["idm-ls"], bootstrap=0).save(file)
    rooms = ("estimation.model_selection", "presentation.result_files", "exports")
    of_rooms = "import " + ", ".join(f"axisid.{room}" for room in rooms)
    modules = imported_by(f"{of_rooms}\naxisid.load_result({str(file)!r})")
    assert "axisid.estimation.records.reading" in modules
    heavy = ("scipy.signal", "scipy.io", "scipy.stats", "scipy.interpolate", "scipy.optimize")
    assert not modules & {*heavy, "matplotlib", "pytest"}


@pytest.mark.slow
def test_no_function_that_evaluates_text_is_called(root: Path) -> None:
    banned = {"sympify", "parse_expr", "lambdify", "eval", "S", "simplify"}
    for stage in STAGES:
        for file in sorted((root / stage).rglob("*.py")):
            for node in ast.walk(ast.parse(file.read_text())):
                if isinstance(node, ast.Call):
                    name = getattr(node.func, "attr", getattr(node.func, "id", ""))
                    assert name not in banned, f"{file}:{node.lineno} calls {name}"
                    allowed = file.name == "casadi_functions.py" and stage == "codegen"
                    assert name != "exec" or allowed, f"{file}:{node.lineno} calls exec"
