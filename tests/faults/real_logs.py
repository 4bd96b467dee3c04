"""Faults of what makes real logs usable: windows, columns, shifts, several records.

And those that random inputs found in logs of text and in the files of results.
"""

import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, tzinfo
from functools import partial
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo

from tests.faults.fault import Fault
from tests.faults.files import columns_of_a_log, identified, write_log
from tests.run_files import run_file

Make = Callable[[Path], list[object]]

_KEPT = '{"schema": "axisid.identification/1"}\n'
_HEADER = "time;position;reference;control\n"


def _on_log(*options: str, logs: int = 1, **said: object) -> Make:
    """Identify from a log, given so often, over a result that must stay as it is."""

    def make(folder: Path) -> list[object]:
        (folder / "kept.json").write_text(_KEPT)
        log = write_log(folder)
        log = run_file(log, **said) if said else log
        return ["identify", "emps2015", *[log] * logs, *options, "--json", "kept.json"]

    return make


def _on_text(name: str, text: Callable[[], str], *options: str, with_log: bool = False) -> Make:
    """Identify from a file of some text, after a log if there is to be one."""

    def make(folder: Path) -> list[object]:
        (folder / "kept.json").write_text(_KEPT)
        (folder / name).write_text(text())
        logs = [write_log(folder)] if with_log else []
        return ["identify", "emps2015", *logs, name, *options, "--json", "kept.json"]

    return make


def _lines(changed: str) -> str:
    """JSON lines of a log, of which the eighth is changed."""
    columns = columns_of_a_log()
    rows = [{name: float(v[i]) for name, v in columns.items()} for i in range(100)]
    lines = [json.dumps(row) for row in rows]
    return "\n".join([*lines[:7], changed, *lines[8:]])


def _without_head() -> str:
    columns = columns_of_a_log().values()
    return "\n".join(",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True))


def _in_zone(start: datetime, zone: str, written: tzinfo) -> str:
    """A log whose stamps are of a zone, as a clock of `written` shows them."""
    columns = columns_of_a_log()
    stamps = ((start + timedelta(seconds=float(t))).astimezone(written) for t in columns["time"])
    others = [v for name, v in columns.items() if name != "time"]
    rows = (
        ";".join([f"{stamp:%Y-%m-%d %H:%M:%S.%f} {zone}", *(f"{float(x):.9g}" for x in row)])
        for stamp, row in zip(stamps, zip(*others, strict=True), strict=True)
    )
    names = [name for name in columns if name != "time"]
    return "\n".join([";".join(["time", *names]), *rows])


def _rows(first: list[str]) -> str:
    """Rows of a log, the first column of the first ones as it is given."""
    times = [*first, *(f"{1e-3 * k:g}" for k in range(len(first), 40))]
    return "".join(f"{time};{1e-3 * k * k:g};0.5;1.5\n" for k, time in enumerate(times))


def _result(change: Callable[[dict[str, Any]], object]) -> Make:
    """Two results to be compared, the second one changed."""

    def make(folder: Path) -> list[object]:
        whole: dict[str, Any] = json.loads(identified())
        files = folder / "a.json", folder / "b.json"
        files[0].write_text(json.dumps(whole))
        change(whole)
        files[1].write_text(json.dumps(whole))
        return ["compare-results", *files]

    return make


_SPRING = datetime(2026, 3, 29, 0, 59, 59, tzinfo=UTC)
_AUTUMN = datetime(2026, 10, 25, 0, 59, 59, tzinfo=UTC)


_BERLIN = ZoneInfo("Europe/Berlin")
#: Name, start, zone as it is written, the clock that the stamps are of, and what is said.
_OF_ZONES = (
    ("zone that is a path", _SPRING, "../etc/passwd", _BERLIN, "not a number .*or a time"),
    ("clock set forward, written as of a place", _SPRING, "Europe/Berlin", _BERLIN, "is 3600"),
    ("clock set forward, written as of one zone", _SPRING, "+01:00", _BERLIN, "step .*is 3600"),
    ("clock set back, written as of one zone", _AUTUMN, "CEST", _BERLIN, "does not increase"),
)
#: Name, options, code and what is said, of one log.
_OF_A_LOG = (
    ("window backwards", ("--window", "3..1"), 2, "does not end after it begins"),
    ("window of no number", ("--window", "nan.."), 2, "Give two times of the log"),
    ("window of words", ("--window", "a..b"), 2, "FROM..TO in seconds"),
    ("window beside the log", ("--window", "100..200"), 3, "The times of the log are 0 to 7.8 s"),
    (
        "windows that overlap",
        ("--window", "1..3", "--window", "2..4"),
        2,
        "Combine them into one window",
    ),
    ("window of two rows", ("--window", "1..1.001"), 3, "has 2 rows. Give at least 3 rows"),
    ("factor of nothing", ("--columns", "position=position:m/0"), 2, "/0 makes every value"),
    ("factor of no number", ("--columns", "position=position:m*nan"), 2, "'nan' is not a number"),
    (
        "factor of absurd size",
        ("--columns", "position=position:m*1e9999999"),
        2,
        "is not a known unit",
    ),
    ("angle for a length", ("--columns", "position=position:deg*5mm"), 2, "m times an angle"),
    (
        "offset of another kind",
        ("--columns", "position=position:counts*360deg/4096+0.2kg"),
        2,
        "an offset in kg cannot be added to rad",
    ),
    (
        "unknown unit",
        ("--columns", "position=position:furlong"),
        2,
        "'furlong' is not a known unit",
    ),
    (
        "column beyond the last",
        ("--columns", "position=#9"),
        3,
        "no column '#9'.*Found: time, refe",
    ),
    ("column before the first", ("--columns", "position=#0"), 3, "no column '#0'"),
)
#: Name, shift, code and what is said.
_SHIFTS = (
    ("shift by a part", {"control": 1.5}, 3, "Give a whole number.*--resample auto"),
    ("shift of the time", {"time": 1}, 3, "shift: the time cannot be shifted"),
    ("shift of no column", {"wheel": 1}, 3, "shift.wheel: the key is unknown"),
    ("shift beyond the log", {"control": 99999}, 3, "is 99999 of 7801 samples"),
    ("shift in kilograms", {"control": "1kg"}, 3, "or a time with its unit, such as 2ms"),
)
#: The same of two logs.
_OF_TWO = (
    ("local of no parameter", ("--local", "wheel"), "no parameter 'wheel'.*has M, Fv, Fc"),
    ("too few known values", ("--known", "M=1"), "there are 2 records. Give one value for each"),
    (
        "too many known values",
        ("--known", "M=1,2,3"),
        "there are 2 records. Give one value for each",
    ),
    ("known words", ("--known", "M=a,b"), "number 1 is not a number"),
    ("local and known", ("--local", "Fc", "--known", "Fc=1,2"), "'Fc' is local.*known values"),
)

FAULTS: list[Fault] = [
    *(
        Fault(name=name, make=_on_log(shift=shift), code=code, says=says)
        for name, shift, code, says in _SHIFTS
    ),
    *(
        Fault(name=name, make=_on_log(*options), code=code, says=says)
        for name, options, code, says in _OF_A_LOG
    ),
    *(
        Fault(name=name, make=_on_log(*options, logs=2), code=2, says=says)
        for name, options, says in _OF_TWO
    ),
    *(
        Fault(
            name=name,
            make=_on_text("zone.csv", partial(_in_zone, start, zone, written)),
            code=3,
            says=says,
        )
        for name, start, zone, written, says in _OF_ZONES
    ),
    Fault(
        name="columns beyond a headerless file's",
        make=_on_text("bare.csv", _without_head, "--columns", "time=#1,position=#7,control=#4"),
        code=3,
        says="no column '#7' for the position.*Found: #1, #2, #3, #4",
    ),
    Fault(
        name="headerless file without columns",
        make=_on_text("bare.csv", _without_head),
        code=3,
        says="Found: #1, #2, #3, #4. Name the columns with --columns",
    ),
    Fault(
        name="JSON line that is cut off",
        make=_on_text("cut.jsonl", lambda: _lines('{"time": 1, ')),
        code=3,
        says="cut.jsonl, line 8 is not JSON",
    ),
    Fault(
        name="JSON line of another kind",
        make=_on_text("odd.jsonl", lambda: _lines("[1, 2]")),
        code=3,
        says="odd.jsonl has no columns of numbers",
    ),
    Fault(
        name="bad record among several",
        make=_on_text("text.csv", lambda: "time,position\nhello,world\n", with_log=True),
        code=3,
        says="1 of 2 records cannot be used: text.csv: no table.*skip-bad",
    ),
    Fault(
        name="no record left of several",
        make=_on_text("text.csv", lambda: "time,position\nhello,world\n", "text.csv", "--skip-bad"),
        code=3,
        says="2 of 2 records cannot be used",
    ),
    Fault(
        name="a spreadsheet's error in the first cell of a row is no comment",
        make=_on_text("odd.csv", lambda: _HEADER + _rows(["0", "1e-3", "#N/A", "#DIV/0!"])),
        code=3,
        says=r"line 4: '#N/A' in column 'time' is not a number",
    ),
    Fault(
        name="a first row with a time stamp and no number is no header",
        make=_on_text(
            "odd.csv",
            lambda: _HEADER + "12:00:00.000;;;\n" + _rows(["12:00:00.001", "12:00:00.002"]),
        ),
        code=3,
        says=r"line 2: the time stamp '12:00:00\.000'.*are expected",
    ),
    Fault(
        name="a figure of a result that is no number",
        make=_result(lambda w: w["estimates"][0].update(simulation_error_percent={})),
        code=3,
        says="does not match its schema: expected float . null, got object",
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
]
