"""The command line: contract, exit codes, one sentence on stderr, nothing half-written."""

import json
import os
import runpy
import stat
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import identify
from axisid.estimation.methods import METHODS
from axisid.estimation.records.record import Record
from tests.command_line import Refused, Run
from tests.files import csv_file

N = 2000


def shell(arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run the command line as a shell does."""
    command = f"{sys.executable} -m axisid {arguments}"
    return subprocess.run(command, shell=True, capture_output=True, text=True, check=False)  # noqa: S602


@pytest.fixture
def log(tmp_path: Path, twin: Record) -> Callable[..., Path]:
    """A log of the paper's twin with some columns changed."""
    names = ("time", "reference", "position", "control")
    columns = {name: getattr(twin, name)[:N] for name in names}

    def write(name: str = "log.csv", rows: int = N, **changes: Any) -> Path:
        table = {k: v[:rows] for k, v in {**columns, **changes}.items() if v is not None}
        return csv_file(tmp_path / name, table)

    return write


@pytest.mark.slow
def test_json_keeps_its_contract(run: Run) -> None:
    code, out, err = run("identify", "emps2015", "--json", "-")
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert [e["method"] for e in result["estimates"]] == [*METHODS]
    for estimate in result["estimates"]:
        deviations = np.sqrt(np.diag(estimate["covariance"]))
        assert deviations == pytest.approx([v["sd"] for v in estimate["parameters"].values()])
        if estimate["method"] in ("idm-iv", "ddm-iv", "didim"):
            assert estimate["iterations"][-1]["M"] == estimate["parameters"]["M"]["value"]


@pytest.mark.slow
def test_settings_reach_the_prefilter(run: Run, log: Callable[..., Path]) -> None:
    options = "--method idm-ls --cutoff 50 --decimate 4 --hold zoh --reversals keep --json -"
    code, out, _ = run("identify", "emps2015", log(), *options.split())
    assert code == 0
    assert json.loads(out)["prefilter"] == {
        "cutoff": 50.0,
        "order": 4,
        "decimate": 4,
        "decimation": "matlab",
        "drop": [58, 58],
        "hold": "zoh",
        "reversals": "keep",
        "silent": 0,
    }


def test_bad_data_exits_3_with_one_sentence(
    refused: Refused, log: Callable[..., Path], twin: Record
) -> None:
    spoilt = np.where(np.arange(N) == 41, np.nan, twin.position[:N])
    for changes, message in (
        ({"position": spoilt}, "position is nan in data row 42"),
        ({"time": twin.time[:N] + (twin.time[:N] > 1.0)}, "time step before data row"),
        ({"control": None}, "neither a force nor a control column"),
        (
            {"rows": 60},
            "the record has 60 samples, but 121 or more are needed",
        ),
    ):
        said = refused("identify", "emps2015", log(**changes), says=message, code=3)
        assert len(said.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["emps2015", "absent.csv"], 3, "absent.csv cannot be read"),
        (["nosuch"], 4, "there is no axis 'nosuch'"),
        (["emps2015", "--cutoff", "600"], 2, "not below 500 Hz"),
        (["emps2015", "--cutoff", "-1"], 2, "the cutoff is -1.0. Give"),
        (["emps2015", "--decimate", "0"], 2, "the decimation is 0"),
        (["emps2015", "--decimate", "x"], 2, "not a valid integer"),
        (["emps2015", "--method", "ols"], 2, "'ols' is not one of"),
        (["emps2015", "--columns", "time"], 2, "not ROLE=NAME"),
        (["emps2015", "--window", "1..2"], 2, "describes a record"),
        (["emps2015", "--json", "no/such/folder/x.json"], 2, "does not exist"),
        ([], 2, "Missing argument"),
        (["emps2015", "--nonsense"], 2, "No such option"),
        (["emps2015", "--fix", "M"], 2, "'M' does not fix a parameter"),
        (["emps2015", "--fix", "mass=1"], 2, "there is no parameter 'mass' to fix"),
        (
            ["emps2015", "--method", "all", "--method", "didim"],
            2,
            "--method all cannot be combined",
        ),
    ],
)
def test_bad_arguments_are_explained(
    refused: Refused, arguments: list[str], code: int, message: str
) -> None:
    assert refused("identify", *arguments, says=message, code=code).count("\n") == 1


@pytest.mark.slow
def test_instruments_without_a_reference_column(
    run: Run, refused: Refused, log: Callable[..., Path]
) -> None:
    file = log(reference=None)
    refused("identify", "emps2015", file, "--method=idm-iv", says="no reference column", code=3)
    code, out, _ = run("identify", "emps2015", file, "--json", "-")
    assert code == 0
    assert set(json.loads(out)["skipped"]) == {"idm-iv", "ddm-iv", "didim"}


NO_LAW = """
from axisid import Coordinate, Parameter, newton
from axisid.elements import Drive, viscous
q = Coordinate("q")
M, Fv = Parameter("M", "kg", nominal=100.0), Parameter("Fv", "N/(m/s)")
axis = newton("bare", coordinate=q, parameters=(M, Fv), inertia=M, resistance=(viscous(Fv, q),),
              drive=Drive(gain=35.15))
"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import nonsense_xyz", "cannot be imported"),
        (NO_LAW.replace("viscous(Fv, q)", "3.0*Fv*q.acceleration**2"), "not linear in the accel"),
        (NO_LAW.replace("viscous(Fv, q)", "Fv*q"), "the term Fv*q is in kg m/s"),
        (NO_LAW.replace('"Fv"', '"double"'), "keyword of C"),
    ],
)
def test_bad_axes_exit_4(refused: Refused, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "bad.py").write_text(text)
    said = refused("identify", tmp_path / "bad.py", "log.csv", says=message, code=4)
    assert "Traceback" not in said


def test_internal_faults_are_told_from_user_faults(
    refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_: str) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr("axisid.modeling.parsing.load_axis", broken)
    monkeypatch.delenv("AXISID_DEBUG", raising=False)
    refused("identify", "emps", says="internal fault: RuntimeError: boom", code=1)
    monkeypatch.setenv("AXISID_DEBUG", "1")
    with pytest.raises(RuntimeError, match="boom"):
        from axisid.commands.main import main

        main()


@pytest.mark.slow
def test_json_never_replaces_an_input_or_what_is_no_file(
    run: Run, refused: Refused, log: Callable[..., Path], tmp_path: Path
) -> None:
    record = log()
    before = record.read_bytes()
    axis = tmp_path / "mine.py"
    axis.write_text("from axisid import load_axis\naxis = load_axis('emps2015')\n")
    for named, place in (("emps2015", record), (axis, axis), (f"{axis}:axis", axis)):
        refused("identify", named, record, "--json", place, says="it is an input of this run")
    assert record.read_bytes() == before
    for place in ("", tmp_path):
        refused("identify", "emps2015", "--json", place)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    code, _, _ = run("identify", "emps2015", "--method", "idm-ls", "--json", pipe)
    assert code == 0
    assert json.loads(os.read(reader, 1 << 20))["axis"] == "emps2015"
    os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.slow
def test_json_follows_links_and_keeps_modes(run: Run, tmp_path: Path) -> None:
    target, link = tmp_path / "target.json", tmp_path / "link.json"
    target.write_text('{"schema": "axisid.identification/1"}')
    target.chmod(0o600)
    link.symlink_to(target)
    assert run("identify", "emps2015", "--method", "idm-ls", "--json", link)[0] == 0
    assert link.is_symlink()
    assert json.loads(target.read_text())["axis"] == "emps2015"
    assert stat.S_IMODE(target.stat().st_mode) == 0o600


@pytest.mark.slow
@pytest.mark.parametrize(
    ("redirect", "code"), [("| true", 0), ("> /dev/full", 2), ("<&- >&- 2>&-", 0)]
)
def test_result_file_is_written_whole_even_if_standard_output_fails_or_streams_are_closed(
    tmp_path: Path, redirect: str, code: int
) -> None:
    file = tmp_path / "result.json"
    done = shell(f"identify emps2015 --json {file} {redirect}")
    assert done.returncode == code
    assert json.loads(file.read_text())["axis"] == "emps2015"
    assert "Traceback" not in done.stderr
    assert "internal fault" not in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        ("--help > /dev/full", 2, "No space left on device"),
        ("identify emps2015 --method idm-ls --json - > /dev/full", 2, "No space left on device"),
        ("identify emps2015 absent.csv 2> /dev/full", 3, ""),
        ("--version >&-", 0, ""),
        ("identify emps2015 --json - >&-", 2, "standard output is closed"),
    ],
)
def test_streams_that_are_full_or_closed_keep_the_exit_code_and_cost_a_sentence_at_most(
    arguments: str, code: int, says: str
) -> None:
    done = shell(arguments)
    assert (done.returncode, done.stdout) == (code, "")
    assert says in done.stderr
    assert done.stderr.count("\n") == bool(says)


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        "identify emps2015 --json r.json --figures figures",
        "sweep emps2015 --json r.json --figure sweep.pdf",
        "paper --output results",
    ],
)
def test_matplotlib_that_does_not_start_is_told_before_anything_is_done(
    tmp_path: Path, arguments: str
) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "axisid", *arguments.split()],
        env={**os.environ, "MPLBACKEND": "bogus"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert "matplotlib cannot be imported" in done.stderr
    assert "the variable MPLBACKEND" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_result_is_read_from_standard_input(tmp_path: Path, run: Run, refused: Refused) -> None:
    file = tmp_path / "a.json"
    assert run("identify", "emps2015", "--method", "idm-ls", "--json", file)[0] == 0
    done = shell(f"compare-results /dev/stdin {file} < {file}")
    assert (done.returncode, done.stderr) == (0, "")
    assert "the settings are the same" in done.stdout
    os.truncate(file, 10**8)
    refused("compare-results", file, file, says="is larger than 64 MB", code=3)


@pytest.mark.slow
def test_axis_file_that_prints_does_not_spoil_json(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "chatty.py"
    file.write_text("from axisid import load_axis\nprint('hello')\naxis = load_axis('emps2015')\n")
    code, out, err = run("identify", file, "--method", "idm-ls", "--json", "-")
    assert code == 0
    assert json.loads(out)["axis"] == "emps2015"
    assert err == "hello\n"


@pytest.mark.slow
def test_failed_method_exits_6_after_the_others_were_reported(
    run: Run,
    log: Callable[..., Path],
    tmp_path: Path,
    twin: Record,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """From a nominal mass of nothing, and from least squares of a control of the other sign."""
    nominal = partial(identify, start="nominal")
    monkeypatch.setattr("axisid.commands.options.stages.identify", nominal, raising=False)
    (tmp_path / "empty.py").write_text(
        "from dataclasses import replace\nfrom axisid import Parameter, load_axis\n"
        "a = load_axis('emps2015')\n"
        "axis = replace(a, parameters=(Parameter('M', 'kg'), *a.parameters[1:]))\ndel a\n"
    )
    flipped = log(control=-twin.control[:N])
    code, out, err = run("identify", tmp_path / "empty.py", flipped, "--json", "-")
    assert code == 6
    result = json.loads(out)
    assert [e["method"] for e in result["estimates"]] == ["idm-ls", "ddm-ls"]
    assert set(result["failed"]) == {"idm-iv", "ddm-iv"}
    assert len(err.splitlines()) == 2  # of instruments, and of didim


def test_interrupt_exits_130(refused: Refused, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("axisid.modeling.parsing.load_axis", interrupted)
    assert refused("identify", "emps2015", code=130).strip() == "axisid: interrupted"


def test_interrupt_of_the_imports_exits_130(monkeypatch: pytest.MonkeyPatch) -> None:
    class Interrupted:
        def __getattr__(self, _: str) -> None:
            raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "axisid.commands.main", Interrupted())
    with pytest.raises(SystemExit) as ended:
        runpy.run_module("axisid")
    assert ended.value.code == 130


def test_library_names_are_not_taken_by_user_axes(refused: Refused, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("from axisid import load_axis\naxis = load_axis('emps')\n")
    command = ("generate", tmp_path / "mine.py", "--output", tmp_path / "generated")
    refused(*command, says="belongs to the library")
    assert not (tmp_path / "generated").exists()


@pytest.mark.slow
def test_result_of_a_handful_of_rows_is_written_as_json(run: Run, log: Callable[..., Path]) -> None:
    for samples in (140, 180, 250):
        file = log(rows=samples)
        code, out, err = run("identify", "emps2015", file, "--method", "idm-ls", "--json", "-")
        assert code in (0, 3, 6), err
        assert "internal fault" not in err
        if code == 0:
            json.loads(out, parse_constant=lambda name: pytest.fail(name))


@pytest.mark.slow
def test_no_word_of_arithmetic_stands_before_what_is_said(
    run: Run, log: Callable[..., Path], twin: Record
) -> None:
    file = log(position=1e95 * twin.position[:N])
    _, _, err = run("identify", "emps2015", file, "--columns", "position=position:m")
    assert "IDM-IV, DDM-IV could not be estimated" in err
    assert "encountered in" not in err


@pytest.mark.slow
def test_file_name_that_is_no_text_is_written_in_the_report(
    run: Run, log: Callable[..., Path], tmp_path: Path
) -> None:
    page, file = tmp_path / "page.html", log(os.fsdecode(b"log\xff.csv"))
    code, _, err = run("identify", "emps2015", file, "--method", "idm-ls", "--report", page)
    assert (code, page.is_file()) == (0, True), err
