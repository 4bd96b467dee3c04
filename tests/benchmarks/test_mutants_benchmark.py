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
