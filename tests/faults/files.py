"""Faults of files: those that are read, those that are written, and options about them."""

import functools
import gzip
import json
import os
import socket
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from scipy.io import savemat

from axisid import DataError, UsageError, identify, load_axis, read_record, twin_record
from tests.faults.fault import Fault, Misuse
from tests.run_files import run_file

Make = Callable[[Path], list[object]]

_NO_PLACE = "no file can be made there|the folder does not exist"
_NOTES = "what the user wrote\n"
_RESULT = '{"schema": "axisid.identification/1"}\n'


@functools.cache
def columns_of_a_log() -> dict[str, np.ndarray]:
    record = twin_record(load_axis("emps2015"))
    return {
        "time": record.time,
        "reference": record.reference,
        "position": record.position,
        "control": record.control,
    }


def write_log(folder: Path, name: str = "log.csv") -> Path:
    """A log of the paper's twin."""
    columns = columns_of_a_log()
    table = np.column_stack(list(columns.values()))
    head = ",".join(columns)
    np.savetxt(folder / name, table, delimiter=",", header=head, comments="")
    return folder / name


def _pipe(name: str) -> Path:
    os.mkfifo(name)
    return Path(name)


def _loop(name: str) -> Path:
    Path(name).symlink_to(name)
    return Path(name)


def _socket(name: str) -> Path:
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(name)
    return Path(name)


def _result(name: str = "a.json") -> Path:
    """What looks like a result from outside."""
    Path(name).write_text(_RESULT)
    return Path(name)


def _notes(name: str) -> Path:
    Path(name).write_text(_NOTES)
    return Path(name)


def _identify(*options: object) -> Make:
    """Identification of a good log with options."""
    return lambda folder: ["identify", "emps2015", write_log(folder), *options]


def _onto_notes(name: str, *command: object) -> Make:
    """A command that is to write over the user's notes."""
    return lambda _: [*command, _notes(name)]


def _packed_text(_: Path) -> list[object]:
    Path("log.csv.gz").write_bytes(gzip.compress(b"time,position\n" + b"0,0\n" * 1_000_000))
    return ["identify", "emps2015", run_file(Path("log.csv.gz"), max_memory=2e7)]


def _packed_archive(_: Path) -> list[object]:
    with (
        zipfile.ZipFile("log.npz", "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("position.npy", "w") as entry,
    ):
        head = {"descr": "|i1", "fortran_order": False, "shape": (10_000_000,)}
        np.lib.format.write_array_header_1_0(entry, head)
        entry.write(bytes(10_000_000))
    return ["identify", "emps2015", run_file(Path("log.npz"), max_memory=2e7)]


def _packed_matlab(_: Path) -> list[object]:
    savemat("log.mat", {"position": np.zeros(5_000_000)}, do_compression=True)
    return ["identify", "emps2015", run_file(Path("log.mat"), max_memory=2e7)]


def _infinite_result(_: Path) -> list[object]:
    Path("a.json").write_text('{"schema": 1e999}')
    return ["compare-results", "a.json", "a.json"]


def _own_folder_of_code(_: Path) -> list[object]:
    Path("emps2015").mkdir()
    _notes("emps2015/functions.py")
    return ["generate", "emps2015", "--output", "."]


def _own_figure(folder: Path) -> list[object]:
    Path("figures").mkdir()
    _notes("figures/record.pdf")
    return ["identify", "emps2015", write_log(folder), "--figures", "figures"]


def _own_tables(_: Path) -> list[object]:
    Path("results").mkdir()
    _notes("results/tables.txt")
    return ["paper", "--output", "results"]


def _log_as_target(folder: Path) -> list[object]:
    write_log(folder, "other.csv")
    return ["identify", "emps2015", write_log(folder), "--json", "other.csv"]


def _result_again(folder: Path) -> list[object]:
    return ["identify", "emps2015", write_log(folder), "--method", "idm-ls", "--json", _result()]


def _forced(folder: Path) -> list[object]:
    notes = _notes("notes.txt")
    return [
        "identify",
        "emps2015",
        write_log(folder),
        "--method",
        "idm-ls",
        "--json",
        notes,
        "--force",
    ]


def _is_result(file: str) -> Callable[[Path, str], None]:
    def check(folder: Path, _: str) -> None:
        assert json.loads((folder / file).read_text())["axis"] == "emps2015"

    return check


def _tells_its_path(folder: Path, out: str) -> None:
    record = json.loads(out)["record"]
    assert record["source"] == "log.csv"
    assert record["given"] == "./log.csv"
    assert record["path"] == str(folder / "log.csv")


def _given_below(folder: Path) -> list[object]:
    write_log(folder)
    return ["identify", "emps2015", "./log.csv", "--method", "idm-ls", "--json", "-"]


def _read() -> Iterator[Fault]:
    """What cannot be read, or not to its end."""
    named: tuple[tuple[str, Make, int, str], ...] = (
        (
            "a log that is not there",
            lambda f: ["identify", "emps2015", f / "absent.csv"],
            3,
            "No s",
        ),
        ("a log that is a pipe", lambda _: ["identify", "emps", _pipe("p.csv")], 3, "a pipe"),
        ("a packed log that is a pipe", lambda _: ["identify", "emps", _pipe("p.gz")], 3, "a pipe"),
        ("a MATLAB file that is a pipe", lambda _: ["sweep", "emps", _pipe("p.mat")], 3, "a pipe"),
        ("a log that is a device", lambda _: ["identify", "emps", "/dev/zero"], 3, "a device"),
        ("a log that is a socket", lambda _: ["identify", "emps", _socket("s.csv")], 3, "a socket"),
        ("a log that is a folder", lambda f: ["identify", "emps", f], 3, "it is a folder"),
        (
            "a second record that is a pipe",
            lambda _: ["identify", "emps2015", "--validate", _pipe("p.csv")],
            3,
            "a pipe",
        ),
        ("a result that is a pipe", _compared(lambda: _pipe("p.json")), 3, "it is a pipe"),
        ("a result that is a device", _compared(lambda: "/dev/zero"), 3, "it is a pipe, a device"),
        ("a result that is a socket", _compared(lambda: _socket("s.json")), 3, "a socket"),
        ("a result that is a folder", _compared(lambda: "."), 3, "it is a folder"),
        (
            "an exported result that is a pipe",
            lambda _: ["export", _pipe("p.json"), "--axis", "emps2015", "--to", "c"],
            3,
            "it is a pipe",
        ),
        ("a declaration that is a pipe", lambda _: ["show", _pipe("p.toml")], 4, "is a pipe"),
        ("a program that is a pipe", lambda _: ["identify", _pipe("p.py")], 4, "is a pipe"),
        ("a declaration that is a folder", _folder_as_declaration, 4, "is a folder"),
        ("a log that is a loop of links", _looped_log, 3, "Too many levels"),
        ("a declaration that is a loop of links", _looped_axis, 4, "no axis file"),
        ("a result that is a loop of links", _looped_result, 3, "Too many levels"),
        ("a packed text that unfolds without end", _packed_text, 3, "more than 0.02 GB"),
        ("an archive that unfolds without end", _packed_archive, 3, "more than 0.02 GB"),
        ("a MATLAB file that unfolds without end", _packed_matlab, 3, "more than 0.02 GB"),
        (
            "a result with a number beyond all",
            _infinite_result,
            3,
            "is not JSON: number out of range",
        ),
    )
    for name, make, code, says in named:
        yield Fault(name=name, make=make, code=code, says=says)


def _compared(bad: Callable[[], object]) -> Make:
    return lambda _: ["compare-results", bad(), _result()]


def _folder_as_declaration(_: Path) -> list[object]:
    Path("axis.toml").mkdir()
    return ["show", "axis.toml"]


def _looped_log(_: Path) -> list[object]:
    return ["identify", "emps2015", _loop("loop.csv"), "--json", "result.json"]


def _looped_axis(_: Path) -> list[object]:
    return ["identify", _loop("loop.toml"), "--json", "result.json"]


def _looped_result(_: Path) -> list[object]:
    return ["compare-results", _loop("loop.json"), _result(), "--json", "result.json"]


def _write() -> Iterator[Fault]:
    """What cannot be written to, or must not be."""
    kept = "this command did not write it"
    named: tuple[tuple[str, Make, int, str], ...] = (
        (
            "notes as the target of a result",
            _onto_notes("n", "identify", "emps", "--json"),
            2,
            kept,
        ),
        ("a log as the target of a result", _log_as_target, 2, kept),
        (
            "notes as the target of a page",
            _onto_notes("n", "identify", "emps", "--report"),
            2,
            kept,
        ),
        ("a result of another command", _onto_result, 2, kept),
        ("notes as the target of a drawing", _onto_notes("n.png", *_SWEEP), 2, kept),
        ("notes as the target of an export", _onto_notes("notes.c", *_EXPORT), 2, kept),
        ("notes where a figure is to be", _own_figure, 2, kept),
        ("notes where tables are to be", _own_tables, 2, kept),
        ("code of the user's where code is to be", _own_folder_of_code, 2, kept),
        ("a result on a full device", _identify("--json", "/dev/full"), 2, "No space left"),
        (
            "a page on a full device",
            _identify(*_PAGE, "/dev/full", "--json", "-"),
            2,
            "No space left",
        ),
        ("an export on a full device", _export_to_full, 2, "No space left"),
        (
            "a folder in which nothing can be made",
            _identify("--json", "/proc/r.json"),
            2,
            _NO_PLACE,
        ),
        (
            "one file for two outputs",
            _identify("--json", "r", "--report", "r"),
            2,
            "--json is writ",
        ),
        ("a folder of code that is a loop of links", _looped_code, 2, "levels|leads to itself"),
        ("a folder of figures that is a loop", _looped_figures, 2, "it is no folder"),
    )
    for name, make, code, says in named:
        yield Fault(name=name, make=make, code=code, says=says)


_SWEEP = ("sweep", "emps2015", "--figure")
_EXPORT = ("export", "a.json", "--axis", "emps2015", "--to", "c", "-o")
_PAGE = ("--method", "idm-ls", "--report")


def _onto_result(_: Path) -> list[object]:
    return ["sweep", "emps2015", "--json", _result()]


@functools.cache
def _identified() -> str:
    axis = load_axis("emps2015")
    return json.dumps(identify(axis, twin_record(axis), methods="idm-ls").to_dict())


def _export_to_full(_: Path) -> list[object]:
    Path("a.json").write_text(_identified())
    return ["export", "a.json", "--axis", "emps2015", "--to", "c", "-o", "/dev/full"]


def _looped_code(_: Path) -> list[object]:
    return ["generate", "emps2015", "--output", _loop("loop")]


def _looped_figures(folder: Path) -> list[object]:
    return [
        "identify",
        "emps2015",
        write_log(folder),
        "--figures",
        _loop("loop"),
        "--json",
        "r.json",
    ]


def _period_beside_rate(folder: Path) -> list[object]:
    said = run_file(write_log(folder), resample="auto", sample_period=2e-3)
    return ["identify", "emps2015", said]


def _ask() -> Iterator[Fault]:
    """Options that would be ignored."""
    given = (
        (
            "an option given again",
            ("--json", "a.json", "--json", "b.json"),
            "--json is given 2 tim",
        ),
        (
            "a cut-off given again",
            ("--cutoff", "50", "--cutoff", "60"),
            "--cutoff is given 2 times",
        ),
        ("columns given again", ("--columns", "time=t") * 2, "--columns is given 2 times"),
        ("more of what is not printed", ("--full", "--json", "-"), "--full is of what is printed"),
        ("a record like none", ("--validate-like", "1"), "nothing without --validate"),
    )
    for name, options, says in given:
        yield Fault(name=name, make=_identify(*options), code=2, says=says)
    yield Fault(
        name="a period beside a rate, against the clock",
        make=_period_beside_rate,
        code=3,
        says="given as 0.002 s, but the time column steps by 0.001 s",
    )
    yield Fault(
        name="a repair of a twin",
        make=lambda _: ["identify", "emps2015", "--gaps", "split"],
        code=2,
        says="--gaps describes a record",
    )
    yield Fault(
        name="two ways to declare",
        make=lambda _: ["new", "stage", "--newton", "--lagrange"],
        code=2,
        says="--newton/--lagrange is given 2 times",
    )


def _done() -> Iterator[Fault]:
    """What is right, and was wrong or lacking."""
    yield Fault(
        name="a result that is written again",
        make=_result_again,
        code=0,
        says="IDM-LS",
        after=_is_result("a.json"),
    )
    yield Fault(
        name="notes that may go",
        make=_forced,
        code=0,
        says="IDM-LS",
        after=_is_result("notes.txt"),
    )
    yield Fault(
        name="where a record lies", make=_given_below, code=0, says="path", after=_tells_its_path
    )


FAULTS: tuple[Fault, ...] = (*_read(), *_write(), *_ask(), *_done())


MISUSES: tuple[Misuse, ...] = (
    Misuse(
        name="room that is no amount of memory",
        call=lambda: read_record("log.csv", max_memory=-1.0),
        error=UsageError,
        says="give a positive number of bytes",
    ),
    Misuse(
        name="a log in Python that is a device",
        call=lambda: read_record("/dev/null"),
        error=DataError,
        says="no regular file but a pipe, a device",
    ),
)
