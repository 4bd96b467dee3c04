"""The examples run, and pages show what is printed."""

import json
import re
import runpy
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import load_axis, twin_record
from axisid.modeling import LIBRARY
from docs.extensions.axis_texts import text_of
from tests.command_line import Run

ROOT = Path(__file__).resolve().parents[2]
# Those that declare a twin; the study of a real record has its own tests.
EXAMPLES = sorted(
    file for file in (ROOT / "examples").glob("*.py") if "experiment=" in file.read_text()
)


@pytest.mark.slow
@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_example_axes_are_identified_from_their_twins(run: Run, file: Path) -> None:
    axis = load_axis(file)
    code, out, err = run("identify", file, "--hold", "zoh", "--json", "-")
    assert (code, err) == (0, "")
    for estimate in json.loads(out)["estimates"]:
        values = {name: v["value"] for name, v in estimate["parameters"].items()}
        assert values == pytest.approx(dict(axis.experiment.truth), rel=0.03)


@pytest.mark.slow
def test_belt_example_is_also_a_program(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(ROOT / "examples" / "belt_drive.py"), run_name="__main__")
    assert "belt drive with a return spring" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_code_of_the_readme_and_the_pages_runs_as_printed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    declaration, script = _blocks("README.md", "python")
    *_, twin_script = _blocks("docs/declaring.md", "python")
    simulation, kept, lanes = _blocks("docs/identifying.md", "python")
    Path("my_axis.py").write_text(declaration)
    toml, *_ = _blocks("docs/declaring.md", "toml")
    Path("my_axis.toml").write_text(toml)
    assert load_axis("my_axis.toml") == load_axis("my_axis.py")
    namespace: dict[str, Any] = {}
    exec(twin_script, namespace)
    twin = twin_record(namespace["axis"])
    np.savetxt(
        "log.csv",
        np.column_stack([twin.time, twin.reference, twin.position, twin.control]),
        delimiter=",",
        header="t,ref,pos,cmd",
        comments="",
    )
    Path("second.csv").write_bytes(Path("log.csv").read_bytes())
    exec(script, {})
    out = capsys.readouterr().out
    assert "truth      m = 6.2 kg" in out
    assert "DDM-IV" in out
    exec(simulation, namespace)
    assert namespace["forces"].shape == (7801, 1000)
    exec(kept, namespace)
    assert capsys.readouterr().out.endswith("(1000,)\n")
    exec(lanes, namespace)


def _blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)


@pytest.mark.parametrize("name", LIBRARY)
def test_gallery_has_every_parameter_of_an_axis(name: str) -> None:
    text = text_of(name)
    assert all(f"| {p.name} | {p.unit} |" in text for p in load_axis(name).parameters)
    assert "Twin: " in text


@pytest.mark.slow
def test_command_of_the_gallery_runs_as_printed(run: Run) -> None:
    (command,) = re.findall(r"^\$ axisid (.*)$", text_of("pendulum"), re.MULTILINE)
    code, out, err = run(*shlex.split(command))  # type: ignore[misc]
    assert (code, err) == (0, "")
    assert "pendulum with Coulomb friction" in out
