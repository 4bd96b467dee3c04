"""The pages of the library axes are current, and their commands run."""

import re
import runpy
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from axisid.modeling import LIBRARY


@pytest.mark.parametrize("name", LIBRARY)
def test_page_is_what_the_declaration_gives(root: Path, name: str) -> None:
    page = runpy.run_path(str(root / "docs" / "axis_pages.py"))["page"]
    file = root / "docs" / "axes" / f"{name}.md"
    assert file.read_text() == page(name), "run: python docs/axis_pages.py"


@pytest.mark.slow
def test_command_of_a_page_runs_as_printed(root: Path, run: Callable[..., object]) -> None:
    text = (root / "docs" / "axes" / "pendulum.md").read_text()
    (command,) = re.findall(r"^\$ axisid (.*)$", text, re.MULTILINE)
    code, out, err = run(*shlex.split(command))  # type: ignore[misc]
    assert (code, err) == (0, "")
    assert "pendulum with Coulomb friction" in out
