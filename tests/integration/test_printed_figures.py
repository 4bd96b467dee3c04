"""What the README and the pages show of the EMPS record is what the program prints of it."""

import re
import runpy
from pathlib import Path
from typing import Any

import pytest

from axisid import Prefilter, Record, build, compare, friction_ladder, load_axis
from tests.command_line import Run


@pytest.mark.slow
def test_the_readme_shows_what_its_command_prints(
    run: Run, root: Path, emps_file: Path, tmp_path: Path
) -> None:
    written = runpy.run_path(str(root / "docs" / "readme_figures.py"))
    text = (root / "README.md").read_text(encoding="utf-8")
    _, out, err = run(*written["command"](text, emps_file, tmp_path))
    assert err == ""
    assert text == written["with_result"](text, out), "run: python docs/readme_figures.py FILE"


@pytest.mark.slow
def test_the_ladder_on_the_page_is_what_is_printed(root: Path, emps_record: Record) -> None:
    page = (root / "docs" / "identifying.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"(?s)```console\n(candidate .*?)```", page)
    recipe = Prefilter(cutoff=100.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")

    def compared(**further: Any) -> str:
        ladder = friction_ladder(load_axis("emps"), **further)
        return compare({n: build(a) for n, a in ladder.items()}, emps_record, recipe).summary()

    printed = " ".join(compared().split())
    at = 0
    for piece in block.split("...\n"):
        found = printed.find(" ".join(piece.split()), at)
        assert found >= 0, f"not printed any more:\n{piece}"
        at = found
    richer = compared(quadratic=True, stribeck=0.02)
    said = re.search(r"held-out errors\s+are ([\d.]+) % and, at\s+V = 0.02 m/s, ([\d.]+) %", page)
    for name, value in zip(("quadratic", "stribeck"), said.groups(), strict=True):
        (row,) = (line for line in richer.splitlines() if line.lower().startswith(name))
        assert f"{float(row.split()[3]):.2f}" == value
