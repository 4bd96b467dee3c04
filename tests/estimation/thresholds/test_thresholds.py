"""Every number by which something is judged is a row of one table, used, sourced and documented."""

import ast
import re
from pathlib import Path

import pytest

from axisid.estimation.thresholds.threshold import Threshold
from docs.extensions.threshold_tables import ROOM, SUBJECTS, page, rows_of, users

ROWS = {name: row for subject in SUBJECTS for name, row in rows_of(subject).items()}
#: Floats of modules that judge, which are none of their judgements, and why.
IMPLEMENTATION = {
    "alignment._DELAYS": "the delays that are tried",
    "alignment._STILL": "where an iteration ends",
    "control_law._COLUMN_FAULTS": "factors of units that are tried",
    "control_law._UNITS": "factors of units that are told",
    "instruments._NOTHING": "rounding of a column",
    "instruments._NOTHING_LEFT": "rounding of what is left of a column",
    "clipping._ROUNDING": "rounding of floating point numbers",
    "jumps._TURN": "a whole turn",
    "own_period._NEAR": "how far a search goes",
    "own_period._FINE": "step of a search",
    "resampling._MOST_ROWS": "what there is memory for",
}
JUDGING = ("estimation/diagnostics", "estimation/records")


def _constants(file: Path) -> dict[str, ast.expr]:
    """The constants of a module, by name."""
    found = {}
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            several = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
            pairs = (
                zip(target.elts, node.value.elts, strict=True)
                if several
                else [(target, node.value)]
            )
            found |= {n.id: v for n, v in pairs if isinstance(n, ast.Name) and n.id.isupper()}
    return found


def _has_float(value: ast.expr) -> bool:
    return any(isinstance(n, ast.Constant) and type(n.value) is float for n in ast.walk(value))


def test_every_module_of_the_room_is_a_subject_of_the_page(root: Path) -> None:
    files = {file.stem for file in (root / "estimation" / "thresholds").glob("*.py")}
    assert files - {"__init__", "threshold"} == set(SUBJECTS)


def test_a_name_stands_for_one_row() -> None:
    names = [name for subject in SUBJECTS for name in rows_of(subject)]
    assert sorted(names) == sorted({*names})


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


@pytest.mark.parametrize("folder", JUDGING)
def test_a_room_that_judges_has_no_number_of_its_own(folder: str, root: Path) -> None:
    own = {
        f"{file.stem}.{name}"
        for file in (root / folder).glob("*.py")
        for name, value in _constants(file).items()
        if _has_float(value)
    }
    assert own - set(IMPLEMENTATION) == set()


def test_every_exception_is_still_there(root: Path) -> None:
    there = {
        f"{file.stem}.{name}"
        for folder in JUDGING
        for file in (root / folder).glob("*.py")
        for name, value in _constants(file).items()
        if _has_float(value) or isinstance(value, ast.BinOp)
    }
    assert set(IMPLEMENTATION) - there == set()


def test_the_page_prints_every_row_with_its_value_and_its_users() -> None:
    lines, used = page().splitlines(), users()
    for name, row in ROWS.items():
        (line,) = (line for line in lines if line.startswith(f"| `{name}` |"))
        assert line.split(" | ")[1:4] == [f"{row.value:g}", row.unit, row.meaning]
        assert all(f"`{module}`" in line for module in used[name]), name


def test_the_page_that_prints_the_table_is_listed(root: Path) -> None:
    assert "threshold_tables import page" in (root / "docs" / "thresholds.py").read_text()
    assert "\nthresholds\n" in (root / "docs" / "index.md").read_text()
    assert ROOM.removeprefix("axisid.") == "estimation.thresholds"
