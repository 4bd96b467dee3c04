"""What a command wrote it may write anew; what it did not write stays, unless it is forced."""

import itertools
from pathlib import Path

import pytest

from axisid import load_axis, sweep, twin_record
from axisid.commands.options.outputs import is_earlier
from axisid.paper import STUDY_FILES
from axisid.presentation.matplotlib import write_figures
from axisid.presentation.plots import sweep_plot
from tests.command_line import Refused, Run

TARGETS = ("c", "st", "python", "json", "toml", "csv", "latex")
KINDS = (
    *("identify", "fit", "sweep", "compare", "compare-results", "report", "figure", "export"),
    *("generate", "paper"),
)
QUICK = ("--method", "idm-ls")


def done(run: Run, *arguments: object) -> None:
    code, _, err = run(*arguments)
    assert code == 0, err


@pytest.mark.slow
def test_every_output_is_written_anew_by_its_command_alone(
    run: Run, refused: Refused, here: Path
) -> None:
    commands = {
        "identify": ("identify", "emps2015", *QUICK, "--json", "identify"),
        "fit": ("fit", "emps2015", "--json", "fit"),
        "report": ("identify", "emps2015", *QUICK, "--report", "report"),
        "sweep": ("sweep", "emps2015", "--points", 2, "--json", "sweep"),
        "compare": ("compare", "--ladder", "emps2015", "--json", "compare"),
        "compare-results": ("compare-results", "identify", "identify", "--json", "compare-results"),
    }
    for command in commands.values():
        done(run, *command)
    for name, kind in itertools.product(commands, KINDS):
        assert is_earlier(here / name, kind) == (name == kind)
    for command in commands.values():
        done(run, *command)
    refused(*commands["sweep"][:-1], "identify", says="this command did not write it")


@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
def test_exports_are_written_anew(run: Run, here: Path, target: str) -> None:
    done(run, "identify", "emps2015", *QUICK, "--json", "result.json")
    export = ("export", "result.json", "--axis", "emps2015", "--to", target, "-o", "exported")
    for _ in range(2):
        done(run, *export)
    assert [kind for kind in KINDS if is_earlier(here / "exported", kind)] == ["export"]
    (here / "exported").write_text("mine\n")
    assert run(*export)[0] == 2
    assert (here / "exported").read_text() == "mine\n"
    done(run, *export, "--force")
    assert is_earlier(here / "exported", "export")


@pytest.mark.slow
@pytest.mark.parametrize("form", ["pdf", "svg", "png"])
def test_a_figure_of_every_form_is_known(here: Path, form: str) -> None:
    axis = load_axis("emps2015")
    plot = sweep_plot(sweep(axis, twin_record(axis), (30.0, 60.0)))
    for figure in write_figures([plot], here, form):
        assert [kind for kind in KINDS if is_earlier(figure, kind)] == ["figure"]


def test_generated_code_is_written_anew(run: Run, here: Path) -> None:
    done(run, "generate", "emps2015", "--output", "code")
    for file in (here / "code" / "emps2015").iterdir():
        assert is_earlier(file, "generate")
        file.write_bytes(file.read_bytes() + b" ")
    done(run, "generate", "emps2015", "--output", "code")
    done(run, "generate", "emps2015", "--output", "code", "--check")


@pytest.mark.slow
def test_tables_of_the_paper_are_written_anew(run: Run, here: Path) -> None:
    done(run, "paper", "--output", "results")
    assert all(is_earlier(here / "results" / file, kind) for file, kind in STUDY_FILES.items())


def test_empty_files_and_large_ones(here: Path) -> None:
    empty, large = here / "empty", here / "large"
    empty.touch()
    assert is_earlier(empty, "identify")
    large.write_bytes(bytes(100_000) + b"/Creator (axisid)" + bytes(4000))
    assert is_earlier(large, "figure")
    large.write_bytes(b"mine" + bytes(100_000))
    assert not is_earlier(large, "figure")
    assert not is_earlier(large, "identify")
