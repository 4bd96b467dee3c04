"""Errors have a code, and a sentence that says what to do."""

import json
import pickle
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import axisid
from axisid import AxisidError, Record, read_record
from axisid.codegen.artefacts import write_files
from axisid.estimation import Repairs
from axisid.estimation.regression.simulated_rows import loop_reference
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.signals.filtered_record import check_filter
from axisid.modeling.text.mistakes import TextError
from axisid.support.errors import DeclarationError
from docs.extensions.error_tables import coded_errors, page

N = 400
TIME = 1e-3 * np.arange(N)
FILTER = axisid.Prefilter(cutoff=20.0)
POSITION = 3 * np.sin(30 * TIME)
GAP = np.where(np.arange(N) < 200, TIME, TIME + 0.5)
TEXT = "\n".join(
    ["time,position", *(f"{t:.3f},{float(q)!r}" for t, q in zip(TIME, POSITION, strict=True))]
)


def log(**columns: object) -> dict[str, object]:
    return {"time": TIME, "position": POSITION} | columns


def written(folder: Path, text: str) -> Path:
    file = folder / "log.csv"
    file.write_text(text)
    return file


def emps() -> axisid.codegen.GeneratedAxis:
    return axisid.build(axisid.load_axis("emps2015"), native=False)


def bare() -> Record:
    """A record of a position alone."""
    return Record(time=TIME, position=POSITION)


def streamed(folder: Path) -> Path:
    """What a file of a result begins with that is no longer read."""
    file = folder / "stream.json"
    file.write_text(json.dumps({"schema": "axisid.stream/1"}))
    return file


Case = Callable[[Path], object]
#: What leads to an error of each code.
CASES: dict[str, Case] = {
    "uneven-time": lambda _: read_record(log(time=GAP)),
    "backward-time": lambda _: read_record(log(time=np.where(TIME < 0.2, TIME, TIME - 0.1))),
    "slow-resampling": lambda _: read_record(log(), repairs=Repairs(resample=10.0)),
    "gaps": lambda _: read_record(log(time=GAP), repairs=Repairs(resample="auto")),
    "no-time": lambda _: read_record({"position": POSITION}),
    "empty-cells": lambda _: read_record(log(position=np.where(TIME == 0.1, np.nan, POSITION))),
    "wrapped": lambda _: read_record(log(position=np.mod(40 * TIME, 2 * np.pi))),
    "other-modulus": lambda _: read_record(log(), repairs=Repairs(wrap=1.0)),
    "broken-line": lambda folder: read_record(written(folder, f"{TEXT}\n0.4")),
    "no-number": lambda folder: read_record(written(folder, f"{TEXT}\n0.400,a\n")),
    "memory": lambda folder: read_record(written(folder, TEXT), max_memory=1.0),
    "unknown-unit": lambda _: read_record(log(), columns={"position": "position:furlong"}),
    "other-unit": lambda _: read_record(log(), columns={"position": "position:ms"}),
    "no-column": lambda _: read_record({"time": TIME, "q": POSITION}),
    "column-twice": lambda _: read_record(log(), columns={"reference": "position"}),
    "time-unit": lambda _: check_filter(axisid.Prefilter(), emps(), N, 1.0, "log"),
    "no-injected": lambda _: read_record(log(), injected_at="control"),
    "injected-where": lambda _: read_record(log(e=POSITION), columns={"injected": "e"}),
    "no-force": lambda _: FilteredRecord.bind(emps(), bare(), FILTER).force,
    "no-reference": lambda _: loop_reference(emps(), bare()),
    "too-few-candidates": lambda _: axisid.compare([emps()], bare()),
    "not-written": lambda folder: write_files(written(folder, ""), {Path("a"): "text"}),
    "other-document": lambda folder: axisid.load_result(streamed(folder)),
}


@pytest.mark.parametrize("code", CASES)
def test_error_says_what_to_do_and_not_by_options_alone(code: str, tmp_path: Path) -> None:
    with pytest.raises(AxisidError) as refused:
        CASES[code](tmp_path)
    error = refused.value
    assert error.code == code
    assert " --" not in str(error).replace("with --json", "")
    assert str(error).endswith((".", ")"))


@pytest.mark.parametrize("code", ["uneven-time", "no-reference"])
def test_a_code_survives_a_pickle(code: str, tmp_path: Path) -> None:
    with pytest.raises(AxisidError) as refused:
        CASES[code](tmp_path)
    kept = pickle.loads(pickle.dumps(refused.value))  # noqa: S301
    assert (kept.code, str(kept)) == (code, str(refused.value))


@pytest.mark.parametrize(
    "error",
    [DeclarationError("two mistakes:", ["a", "b\nc"]), TextError("why.", "a + ", 4, code="b")],
)
def test_errors_of_several_parts_survive_a_pickle(error: AxisidError) -> None:
    kept = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert str(kept) == str(error)
    assert vars(kept) == vars(error)


@pytest.mark.slow
def test_a_code_means_one_fault() -> None:
    """It is written once, or is a constant's where several places refuse the same."""
    written = Counter(error.code for error in coded_errors() if error.is_literal)
    shared = {error.code for error in coded_errors() if not error.is_literal}
    assert {code: times for code, times in written.items() if times > 1} == {}
    assert shared & written.keys() == set()
    assert all(re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", code) for code in {*written, *shared})


@pytest.mark.slow
def test_page_of_errors_lists_every_code(root: Path) -> None:
    assert "error_tables import page" in (root / "docs" / "errors.py").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `([a-z0-9-]+)`", page(), re.MULTILINE)
    assert listed == sorted({error.code for error in coded_errors()})
    assert {*CASES, "usage", "data", "text-unknown-name"} <= {*listed}
