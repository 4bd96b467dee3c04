"""Fixtures shared by all tests."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from axisid import (
    Identification,
    build,
    load_axis,
    read_record,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.commands.main import main
from axisid.estimation.records.record import Record
from axisid.modeling import LIBRARY
from tests.command_line import Refused, Run
from tests.unjudged import identify

ROOT = Path(__file__).resolve().parents[1]

# Libraries compiled by tests stay among themselves; all workers share the folder.
os.environ.setdefault("AXISID_CACHE", str(ROOT / ".pytest_cache" / "native"))

# A fault of a check is a failure here; a user is told of it beside the estimates.
os.environ.setdefault("AXISID_DEBUG", "1")

settings.register_profile("axisid", deadline=None, derandomize=True)
settings.load_profile("axisid")


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The real records live beside the checkout; they are never copied into it."""
    folder = Path(os.environ.get("AXISID_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real records at {folder}; set AXISID_DATA to their folder")
    return folder


@pytest.fixture(scope="session")
def emps_file(data_folder: Path) -> Path:
    file = data_folder / "emps" / "DATA_EMPS.mat"
    if not file.is_file():
        pytest.skip(f"the EMPS record {file} is absent (nonlinearbenchmark.org)")
    return file


@pytest.fixture(scope="session")
def emps() -> GeneratedAxis:
    return build(load_axis("emps"))


@pytest.fixture(scope="session")
def emps2015() -> GeneratedAxis:
    return build(load_axis("emps2015"))


@pytest.fixture(scope="session")
def emps_record(emps: GeneratedAxis, emps_file: Path) -> Record:
    return read_record(emps_file, emps.axis, sample_period=1e-3)


@pytest.fixture(scope="session")
def twin(emps2015: GeneratedAxis) -> Record:
    return twin_record(emps2015)


@pytest.fixture(scope="session")
def result(emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin)


@pytest.fixture(params=LIBRARY)
def library_axis(request: pytest.FixtureRequest) -> GeneratedAxis:
    return build(load_axis(request.param))


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20150)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command line in this process: exit code, stdout, stderr."""

    def command(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["axisid", *map(str, arguments)])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        code = stop.value.code
        return code if isinstance(code, int) else 0 if code is None else 1, out, err

    return command


@pytest.fixture
def refused(run: Run) -> Refused:
    """Run a command line that says on stderr alone why it ends with an exit code."""

    def command(*arguments: object, says: str = "", code: int = 2) -> str:
        got, out, err = run(*arguments)
        assert (got, out) == (code, ""), err
        assert says in " ".join(err.split())
        return err

    return command


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new folder, in which the test is."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
