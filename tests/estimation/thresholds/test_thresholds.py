"""Every number with a source, or by which several rooms judge, is a row of one table, and used."""

import pytest

from docs.extensions.threshold_tables import SUBJECTS, rows_of, users


def test_a_name_stands_for_one_row() -> None:
    names = [name for subject in SUBJECTS for name in rows_of(subject)]
    assert sorted(names) == sorted({*names})


@pytest.mark.slow
def test_every_row_is_used_somewhere() -> None:
    assert {name for subject in SUBJECTS for name in rows_of(subject)} - set(users()) == set()
