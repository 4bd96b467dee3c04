"""Faults that random inputs found: in logs of text, and in the files of results."""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from axisid import identify, load_axis, twin_record
from tests.faults.fault import Fault, Misuse

_HEADER = "time;position;reference;control\n"


def _log(text: str) -> Callable[[Path], list[object]]:
    def make(folder: Path) -> list[object]:
        file = folder / "log.csv"
        file.write_text(text)
        return ["identify", "emps2015", file]

    return make


def _rows(first: list[str]) -> str:
    """Rows of a log, the first column of the first ones as it is given."""
    times = [*first, *(f"{1e-3 * k:g}" for k in range(len(first), 40))]
    return "".join(f"{time};{1e-3 * k * k:g};0.5;1.5\n" for k, time in enumerate(times))


@cache
def _written() -> str:
    """A result as it is written."""
    axis = load_axis("emps2015")
    return json.dumps(identify(axis, twin_record(axis), methods="idm-ls").to_dict())


def _result(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], list[object]]:
    """Two results to be compared, the second one changed."""

    def make(folder: Path) -> list[object]:
        whole: dict[str, Any] = json.loads(_written())
        files = folder / "a.json", folder / "b.json"
        files[0].write_text(json.dumps(whole))
        change(whole)
        files[1].write_text(json.dumps(whole))
        return ["compare-results", *files]

    return make


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="a spreadsheet's error in the first cell of a row is no comment",
        make=_log(_HEADER + _rows(["0", "1e-3", "#N/A", "#DIV/0!"])),
        code=3,
        says=r"line 4: '#N/A' in column 'time' is not a number",
    ),
    Fault(
        name="a first row with a time stamp and no number is no header",
        make=_log(_HEADER + "12:00:00.000;;;\n" + _rows(["12:00:00.001", "12:00:00.002"])),
        code=3,
        says=r"line 2: the time stamp '12:00:00\.000' stands where the names .* are expected",
    ),
    Fault(
        name="a figure of a result that is no number",
        make=_result(lambda w: w["estimates"][0].update(simulation_error_percent={})),
        code=3,
        says="lacks what its schema promises: expected float . null, got object",
    ),
    Fault(
        name="a value of a result that is true",
        make=_result(lambda w: w["estimates"][0]["parameters"]["M"].update(value=True)),
        code=3,
        says="expected float, got bool",
    ),
    Fault(
        name="a value of a result beyond floating point",
        make=_result(lambda w: w["estimates"][0]["parameters"]["M"].update(value=10**400)),
        code=3,
        says="number out of range",
    ),
    Fault(
        name="a check of a result without a meaning",
        make=_result(lambda w: w["verdict"][0].update(status="fail", meaning=None)),
        code=3,
        says="expected str, got null",
    ),
)
MISUSES: tuple[Misuse, ...] = ()
