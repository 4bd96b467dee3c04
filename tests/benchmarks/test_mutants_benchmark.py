"""The mutants are of the program as it is, and their tests are there."""

from pathlib import Path

import pytest
from mutants import MUTANTS, text_with


@pytest.mark.parametrize("name", MUTANTS)
def test_the_text_of_a_mutant_is_found_once_and_its_tests_exist(name: str, root: Path) -> None:
    file, _, _, tests = MUTANTS[name]
    assert text_with(name) != (root / file).read_text()
    for test in tests:
        path, _, function = test.partition("::")
        assert f"def {function.partition('[')[0]}" in (root / path).read_text()


def test_a_mutant_whose_text_is_gone_is_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "estimation" / "loops" / "law_run.py"
    file.parent.mkdir(parents=True)
    file.write_text("")
    with pytest.raises(SystemExit, match=r"'a late law acts at once': .*law_run\.py has 0 times"):
        text_with("a late law acts at once", tmp_path)
