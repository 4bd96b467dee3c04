"""Every result of the catalogue is what it was, to a thousandth of its deviations, on any machine.

``AXISID_GOLDEN=record pytest tests/golden`` writes what the program says now and prints what moved;
commit it with the reason.
"""

import json
import os
from pathlib import Path

import pytest

from tests.golden.cases import CASES, DFKI, EMPS, Case
from tests.golden.results import FOLDER, moves, result_of


def _parameter(case: Case) -> object:
    return pytest.param(case, id=case.name, marks=() if case.is_quick else pytest.mark.slow)


@pytest.mark.parametrize("case", [_parameter(case) for case in CASES])
def test_result_is_the_golden_one(
    case: Case,
    tmp_path: Path,
    root: Path,
    request: pytest.FixtureRequest,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    places = {"folder": tmp_path, "root": root}
    if case.before in (EMPS, DFKI):
        places["data"] = request.getfixturevalue("data_folder")
        if not Path(case.before.format(**places)).exists():
            pytest.skip(f"{case.before} is absent")
    monkeypatch.syspath_prepend(root / "examples")
    result, file = result_of(case, places), FOLDER / f"{case.name}.json"
    kept = json.loads(file.read_text()) if file.is_file() else {}  # of a new case
    rows = [("what", "old", "new", "deviations"), *moves(kept, result, case.rounding)]
    moved = "\n".join(f"{case.name:20} {a:50} {b:>16} {c:>16}  {by}" for a, b, c, by in rows)
    if len(rows) > 1 and os.environ.get("AXISID_GOLDEN") == "record":
        lines = (f"{json.dumps(what)}: {json.dumps(each)}" for what, each in result.items())
        file.write_text("{\n" + ",\n".join(lines) + "\n}\n")
        with capsys.disabled():
            print(f"\n{moved}")
    else:
        assert len(rows) == 1, moved


def test_every_file_is_a_case_s() -> None:
    assert {file.stem for file in FOLDER.iterdir()} == {case.name for case in CASES}


def test_what_moves_by_more_than_rounding_is_told() -> None:
    old = {"M": [100.0, 0.05], "M sd": 0.05, "rows": 714, "verdict precision": "pass"}
    same = old | {"M": [100.00004, 0.05], "M sd": 0.050004}
    assert [*moves(old, same)] == []
    for change in ({"M": [100.0001, 0.05]}, {"M sd": 0.05001}, {"rows": 715}, {"new": 1.0}):
        assert [what for what, *_ in moves(old, old | change)] == [*change]
    assert [*moves(old, old | {"M": [100.1, 0.05]})] == [("M", "100.0", "100.1", "2")]
    assert [*moves(old, old | {"verdict precision": "fail"})]
