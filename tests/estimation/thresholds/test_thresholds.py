"""Every number by which something is judged is a row of one table, used, sourced and documented."""

from pathlib import Path

import pytest

from docs.extensions.threshold_tables import SUBJECTS, rows_of, users

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
