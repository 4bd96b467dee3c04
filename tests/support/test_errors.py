"""Errors have a code, and a sentence that says what to do."""

import json
import pickle
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import axisid
from axisid import AxisidError, Record, read_record
from axisid.codegen.generated_axes import write_files
from axisid.estimation import Repairs
from axisid.estimation.regression.simulated_instruments import loop_reference
from axisid.estimation.signals import FilteredRecord
from axisid.modeling.parsing.grammar import TextError
from axisid.support.errors import DeclarationError
from docs.extensions.error_tables import coded_errors, page
from tests.files import text_file

N = 400
TIME = 1e-3 * np.arange(N)
FILTER = axisid.Prefilter(cutoff=20.0)
POSITION = 3 * np.sin(30 * TIME)
GAP = np.where(np.arange(N) < 200, TIME, TIME + 0.5)
TEXT = "\n".join(
    ["time,position", *(f"{t:.3f},{float(q)!r}" for t, q in zip(TIME, POSITION, strict=True))]
)

BARE = Record(time=TIME, position=POSITION)
SLOW = Record(time=1e3 * TIME, position=POSITION)


def log(**columns: object) -> dict[str, object]:
    return {"time": TIME, "position": POSITION} | columns


def emps() -> axisid.codegen.GeneratedAxis:
    return axisid.build(axisid.load_axis("emps2015"), native=False)


def streamed(folder: Path) -> Path:
    """What a file of a result begins with that is no longer read."""
    return text_file(folder / "stream.json", json.dumps({"schema": "axisid.stream/1"}))


Case = Callable[[Path], object]
#: Codes, and what leads to an error of each.
CASES: list[tuple[str, Case]] = [
    ("uneven-time", lambda _: read_record(log(time=GAP))),
    ("time", lambda _: read_record(log(time=np.where(TIME < 0.2, TIME, TIME - 0.1)))),
    ("resampling", lambda _: read_record(log(), repairs=Repairs(resample=10.0))),
    ("uneven-time", lambda _: read_record(log(time=GAP), repairs=Repairs(resample="auto"))),
    ("time", lambda _: read_record({"position": POSITION})),
    ("empty-cells", lambda _: read_record(log(position=np.where(TIME == 0.1, np.nan, POSITION)))),
    ("wrap", lambda _: read_record(log(position=np.mod(40 * TIME, 2 * np.pi)))),
    ("wrap", lambda _: read_record(log(), repairs=Repairs(wrap=1.0))),
    ("log-text", lambda folder: read_record(text_file(folder / "log.csv", f"{TEXT}\n0.4"))),
    ("log-text", lambda folder: read_record(text_file(folder / "log.csv", f"{TEXT}\n0.400,a\n"))),
    ("memory", lambda folder: read_record(text_file(folder / "log.csv", TEXT), max_memory=1.0)),
    ("units", lambda _: read_record(log(), columns={"position": "position:furlong"})),
    ("units", lambda _: read_record(log(), columns={"position": "position:ms"})),
    ("columns", lambda _: read_record({"time": TIME, "q": POSITION})),
    ("columns", lambda _: read_record(log(), columns={"reference": "position"})),
    ("filter", lambda _: FilteredRecord.bind(emps(), SLOW, FILTER)),
    ("test-signal", lambda _: read_record(log(), injected_at="control")),
    ("test-signal", lambda _: read_record(log(e=POSITION), columns={"injected": "e"})),
    ("missing-column", lambda _: FilteredRecord.bind(emps(), BARE, FILTER).force),
    ("missing-column", lambda _: loop_reference(emps(), BARE)),
    ("comparison", lambda _: axisid.compare([emps()], BARE)),
    ("file", lambda folder: write_files(text_file(folder / "log.csv", ""), {Path("a"): "text"})),
    ("result-file", lambda folder: axisid.load_result(streamed(folder))),
]


@pytest.mark.parametrize(("code", "case"), CASES)
def test_error_says_what_to_do_and_not_by_options_alone(
    code: str, case: Case, tmp_path: Path
) -> None:
    with pytest.raises(AxisidError) as refused:
        case(tmp_path)
    error = refused.value
    assert error.code == code
    assert " --" not in str(error).replace("with --json", "")
    assert str(error).endswith((".", ")"))
    kept = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert (kept.code, str(kept)) == (code, str(error))


@pytest.mark.parametrize(
    "error",
    [DeclarationError("two mistakes:", ["a", "b\nc"]), TextError("why.", "a + ", 4, code="b")],
)
def test_errors_of_several_parts_survive_a_pickle(error: AxisidError) -> None:
    kept = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert str(kept) == str(error)
    assert vars(kept) == vars(error)


@pytest.mark.slow
def test_codes_are_few_words() -> None:
    """One for each kind of error and stage, such as ``log-text``."""
    codes = {error.code for error in coded_errors()}
    assert all(re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", code) for code in codes)
    assert len(codes) < 100


@pytest.mark.slow
def test_page_of_errors_lists_every_code(root: Path) -> None:
    assert "error_tables import page" in (root / "docs" / "errors.py").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `([a-z0-9-]+)`", page(), re.MULTILINE)
    assert listed == sorted({error.code for error in coded_errors()})
    assert {*(code for code, _ in CASES), "usage", "data"} <= {*listed}
