"""What a build of the documentation does not check by itself."""

import re
from importlib.util import find_spec
from pathlib import Path

import axisid


def test_every_public_name_is_in_the_api_reference(root: Path) -> None:
    text = "\n".join(page.read_text() for page in (root / "docs" / "api").glob("*.md"))
    listed = set(re.findall(r"\b(axisid\.[\w.]+)$", text, re.MULTILINE))
    faces = (axisid, axisid.modeling, axisid.codegen, axisid.estimation)
    public = {f"{face.__name__}.{name}" for face in faces for name in face.__all__}
    modules = {name for name in public if find_spec(name) is not None}
    assert public - listed <= modules | {"axisid.__version__"}


def test_every_place_that_contributors_are_sent_to_is_there(root: Path) -> None:
    text = (root / "CONTRIBUTING.md").read_text()
    folders = "modeling|codegen|estimation|src|tests|docs|benchmarks"
    named = {*re.findall(rf"`((?:{folders})/[\w/.]+\.(?:py|c|js))`", text)}
    absent = {place for place in named if "NAME" not in place and not (root / place).exists()}
    added = {  # by the recipes
        "estimation/logs/daq.py",
        "estimation/methods/weighted.py",
        "estimation/regression/leave_one_out.py",
        "estimation/diagnostics/turns.py",
        "codegen/printers/javascript.py",
    }
    assert len(named) > 25
    assert absent == added
