"""Every number by which something is judged is a row of one table, used, sourced and documented."""

import re
from pathlib import Path

import pytest

from axisid.codegen.thresholds.threshold import Threshold
from docs.extensions.threshold_tables import SUBJECTS, page, rows_of, users

ROWS = {name: row for subject in SUBJECTS for name, row in rows_of(subject).items()}


def test_every_module_of_the_rooms_is_a_subject_of_the_page(root: Path) -> None:
    stages = ("codegen", "estimation")
    files = [file.stem for s in stages for file in (root / s / "thresholds").glob("*.py")]
    subjects = [name for name in files if name not in ("__init__", "threshold")]
    assert sorted(subjects) == sorted(SUBJECTS)


def test_a_name_stands_for_one_row() -> None:
    names = [name for subject in SUBJECTS for name in rows_of(subject)]
    assert sorted(names) == sorted({*names})


@pytest.mark.slow
def test_every_row_is_used_somewhere() -> None:
    assert set(ROWS) - set(users()) == set()


def test_a_row_says_its_unit_its_meaning_and_its_source(root: Path) -> None:
    known = {*re.findall(r"@\w+\{(\w+),", (root / "docs" / "references.bib").read_text())}
    for name, row in ROWS.items():
        assert row.unit, name
        assert len(row.meaning) > 20, name
        assert not row.meaning.endswith("."), name
        cited = {*re.findall(r"\[(\w+)\]", row.source)}
        assert cited <= known, name
        said = re.match(r"(measured: .|derived: .|convention|chosen)", row.source)
        assert cited or said, name


def test_a_row_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        Threshold(1.0, "1", "something", "chosen").value = 2.0  # type: ignore[misc]


@pytest.mark.slow
def test_the_page_prints_every_row_with_its_value_and_its_users() -> None:
    lines, used = page().splitlines(), users()
    for name, row in ROWS.items():
        (line,) = (line for line in lines if line.startswith(f"| `{name}` |"))
        assert line.split(" | ")[1:4] == [f"{row.value:g}", row.unit, row.meaning]
        assert all(f"`{module}`" in line for module in used[name]), name
