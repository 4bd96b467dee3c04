"""Faults of files: those that are read, those that are written, and options about them."""

import functools
import json
import os
import socket
from collections.abc import Callable
from pathlib import Path

import numpy as np

from axisid import (
    DataError,
    UsageError,
    load_axis,
    read_record,
    twin_record,
)
from tests.faults.fault import Fault, Misuse
from tests.files import csv_file
from tests.run_files import run_file
from tests.unjudged import identify

#: What writes something into the folder of a fault and gives its path.
Part = Callable[[Path], object]


@functools.cache
def columns_of_a_log() -> dict[str, np.ndarray]:
    record = twin_record(load_axis("emps2015"))
    names = ("time", "reference", "position", "control")
    return {name: getattr(record, name) for name in names}


def write_log(folder: Path, name: str = "log.csv") -> Path:
    """A log of the paper's twin."""
    return csv_file(folder / name, columns_of_a_log())


@functools.cache
def identified() -> str:
    """A result as it is written."""
    axis = load_axis("emps2015")
    return json.dumps(identify(axis, twin_record(axis), methods="idm-ls").to_dict())


def _made(name: str, make: Callable[[str], object]) -> Part:
    """What a call makes at a place, in a folder that may be new."""

    def part(folder: Path) -> str:
        (folder / name).parent.mkdir(exist_ok=True)
        make(name)
        return name

    return part


def _bind(name: str) -> None:
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(name)


def _pipe(name: str) -> Part:
    return _made(name, os.mkfifo)


def _loop(name: str) -> Part:
    return _made(name, lambda name: os.symlink(name, name))


def _text(name: str, text: str = "what the user wrote\n") -> Part:
    """A file of some text; notes by default."""
    return _made(name, lambda name: Path(name).write_text(text))


#: What looks like a result from outside.
_RESULT = _text("a.json", '{"schema": "axisid.identification/1"}\n')


def _there(part: Part) -> Part:
    """A file that is no argument of the command."""

    def made(folder: Path) -> None:
        part(folder)

    return made


def _is_result(file: str) -> Callable[[Path, str], None]:
    def check(folder: Path, _: str) -> None:
        assert json.loads((folder / file).read_text())["axis"] == "emps2015"

    return check


def _tells_its_path(folder: Path, out: str) -> None:
    record = json.loads(out)["record"]
    assert record["source"] == "log.csv"
    assert record["given"] == "./log.csv"
    assert record["path"] == str(folder / "log.csv")


_IDENTIFY = ("identify", "emps2015")
_ON_LOG = (*_IDENTIFY, write_log)
_COMPARE = ("compare-results",)
_EXPORT = ("export", _text("a.json", "{}"), "--axis", "emps2015", "--to", "c", "-o")
_NO_PLACE = "no file can be created there|the folder does not exist"
_KEPT = "this command did not write it"
_FULL = "No space left"
_PERIOD = {"resample": "auto", "sample_period": 2e-3}

#: Name, command, exit code and what is said.
_ROWS: tuple[tuple[str, tuple[object, ...], int, str], ...] = (
    # What cannot be read, or not to its end.
    ("a log that is not there", (*_IDENTIFY, "absent.csv"), 3, "No s"),
    ("a log that is a pipe", (*_IDENTIFY, _pipe("p.csv")), 3, "a pipe"),
    ("a packed log that is a pipe", (*_IDENTIFY, _pipe("p.gz")), 3, "a pipe"),
    ("a MATLAB file that is a pipe", ("sweep", "emps", _pipe("p.mat")), 3, "a pipe"),
    ("a log that is a device", (*_IDENTIFY, "/dev/zero"), 3, "a device"),
    ("a log that is a socket", (*_IDENTIFY, _made("s.csv", _bind)), 3, "a socket"),
    ("a log that is a folder", (*_IDENTIFY, "."), 3, "a folder without a ROS 2 bag"),
    ("a second record that is a pipe", (*_IDENTIFY, "--validate", _pipe("p.csv")), 3, "a pipe"),
    (
        "a ledger that is a pipe",
        ("fleet", write_log, "--axis", "emps2015", _there(_pipe("results/fleet.jsonl"))),
        2,
        "results/fleet.jsonl cannot be used: not a regular file",
    ),
    ("a result that is a pipe", (*_COMPARE, _pipe("p.json"), _RESULT), 3, "not a regular file"),
    ("a result that is a device", (*_COMPARE, "/dev/zero", _RESULT), 3, "not a regular file"),
    ("a result that is a socket", (*_COMPARE, _made("s", _bind), _RESULT), 3, "No such device"),
    ("a result that is a folder", (*_COMPARE, ".", _RESULT), 3, "not a regular file"),
    (
        "an exported result that is a pipe",
        ("export", _pipe("p.json"), "--axis", "emps2015", "--to", "c"),
        3,
        "not a regular file",
    ),
    ("a declaration that is a pipe", ("show", _pipe("p.toml")), 4, "not a regular file"),
    ("a program that is a pipe", ("identify", _pipe("p.py")), 4, "not a regular file"),
    (
        "a declaration that is a folder",
        ("show", _made("axis.toml", os.mkdir)),
        4,
        "not a regular file",
    ),
    (
        "a log that is a loop of links",
        (*_IDENTIFY, _loop("loop.csv"), "--json", "r.json"),
        3,
        "Too many levels",
    ),
    (
        "a declaration that is a loop of links",
        ("identify", _loop("loop.toml"), "--json", "r.json"),
        4,
        "no axis file",
    ),
    (
        "a result that is a loop of links",
        (*_COMPARE, _loop("loop.json"), _RESULT, "--json", "r.json"),
        3,
        "Too many levels",
    ),
    (
        "a result with a number beyond all",
        (*_COMPARE, _text("a.json", '{"schema": 1e999}'), "a.json"),
        3,
        "is not JSON: number out of range",
    ),
    # What cannot be written to, or must not be.
    ("notes as the target of a result", (*_IDENTIFY, "--json", _text("n")), 2, _KEPT),
    (
        "a log as the target of a result",
        (*_ON_LOG, "--json", functools.partial(write_log, name="other.csv")),
        2,
        _KEPT,
    ),
    ("notes as the target of a page", (*_IDENTIFY, "--report", _text("n")), 2, _KEPT),
    ("a result of another command", ("sweep", "emps2015", "--json", _RESULT), 2, _KEPT),
    (
        "notes as the target of a drawing",
        ("sweep", "emps2015", "--figure", _text("n.png")),
        2,
        _KEPT,
    ),
    ("notes as the target of an export", (*_EXPORT, _text("notes.c")), 2, _KEPT),
    (
        "notes where a figure is to be",
        (
            "identify",
            _there(_text("figures/record.pdf")),
            "emps2015",
            "--figures",
            "figures",
        ),
        2,
        _KEPT,
    ),
    (
        "notes where tables are to be",
        ("paper", _there(_text("results/tables.txt")), "--output", "results"),
        2,
        _KEPT,
    ),
    (
        "code of the user's where code is to be",
        (
            "generate",
            _there(_text("emps2015/functions.py")),
            "emps2015",
            "--output",
            ".",
        ),
        2,
        _KEPT,
    ),
    ("a result on a full device", (*_ON_LOG, "--json", "/dev/full"), 2, _FULL),
    (
        "a page on a full device",
        (*_ON_LOG, "--method", "idm-ls", "--report", "/dev/full", "--json", "-"),
        2,
        _FULL,
    ),
    (
        "an export on a full device",
        (
            "export",
            lambda folder: _text("a.json", identified())(folder),
            *("--axis", "emps2015", "--to", "c", "-o", "/dev/full"),
        ),
        2,
        _FULL,
    ),
    ("a folder in which nothing can be made", (*_ON_LOG, "--json", "/proc/r.json"), 2, _NO_PLACE),
    ("one file for two outputs", (*_ON_LOG, "--json", "r", "--report", "r"), 2, "--json is writ"),
    (
        "a folder of code that is a loop of links",
        ("generate", "emps2015", "--output", _loop("loop")),
        2,
        "no folder can be created there",
    ),
    ("a loop of links as the target", (*_IDENTIFY, "--json", _loop("l")), 2, "points to itself"),
    (
        "a folder of code without a name",
        ("generate", "emps2015", "--output", ""),
        2,
        "no folder can be created there",
    ),
    (
        "a folder of results without a name",
        ("fleet", write_log, "--output", ""),
        2,
        "no folder can be created there",
    ),
    (
        "a folder of tables without a name",
        ("paper", "--output", ""),
        2,
        "no folder can be created there",
    ),
    (
        "a folder of figures that is a loop",
        (*_ON_LOG, "--figures", _loop("loop"), "--json", "r.json"),
        2,
        "no folder can be created there",
    ),
    # Options that would be ignored.
    (
        "an option given again",
        (*_ON_LOG, "--json", "a.json", "--json", "b.json"),
        2,
        "--json is given 2 tim",
    ),
    (
        "a cut-off given again",
        (*_ON_LOG, "--cutoff", "50", "--cutoff", "60"),
        2,
        "--cutoff is given 2 times",
    ),
    (
        "columns given again",
        (*_ON_LOG, *("--columns", "time=t") * 2),
        2,
        "--columns is given 2 times",
    ),
    ("more of what is not printed", (*_ON_LOG, "--full", "--json", "-"), 2, "--full has no effect"),
    ("a record like none", (*_ON_LOG, "--validate-like", "1"), 2, "no effect without --validate"),
    (
        "a period beside a rate, against the clock",
        (*_IDENTIFY, lambda folder: run_file(write_log(folder), **_PERIOD)),
        3,
        "sample_period is 0.002 s, but the time column steps by 0.001 s",
    ),
    ("a repair of a twin", (*_IDENTIFY, "--gaps", "split"), 2, "--gaps describes a record"),
    (
        "two ways to declare",
        ("new", "stage", "--newton", "--lagrange"),
        2,
        "--newton/--lagrange is given 2 times",
    ),
)
_LS = ("--method", "idm-ls", "--json")
FAULTS: tuple[Fault, ...] = (
    *(Fault(name=name, make=make, code=code, says=says) for name, make, code, says in _ROWS),
    # What is right, and was wrong or lacking.
    Fault(
        name="a result that is written again",
        make=(*_ON_LOG, *_LS, _RESULT),
        code=0,
        says="IDM-LS",
        after=_is_result("a.json"),
    ),
    Fault(
        name="notes that may go",
        make=(*_ON_LOG, *_LS, _text("notes.txt"), "--force"),
        code=0,
        says="IDM-LS",
        after=_is_result("notes.txt"),
    ),
    Fault(
        name="where a record lies",
        make=(*_IDENTIFY, _there(write_log), "./log.csv", *_LS, "-"),
        code=0,
        says="path",
        after=_tells_its_path,
    ),
)
MISUSES: tuple[Misuse, ...] = (
    Misuse(
        name="room that is no amount of memory",
        call=lambda: read_record("log.csv", max_memory=-1.0),
        error=UsageError,
        says="positive number of bytes",
    ),
    Misuse(
        name="a log in Python that is a device",
        call=lambda: read_record("/dev/null"),
        error=DataError,
        says="pipe, a device",
    ),
)
