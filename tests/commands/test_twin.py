"""`axisid twin`: logs of twins are written as the commands that follow take them."""

from pathlib import Path

import pytest

from tests.command_line import Refused, Run

SHORT = ("--speed", "0.05", "--speed", "0.1", "--acceleration", "0.75", "--seconds", "0.3")


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_a_log_is_identified_as_the_command_says(run: Run) -> None:
    noise = ("--position-noise", "1e-8", "--velocity-noise", "1e-6", "--truth", "M=90")
    code, out, _ = run("twin", "emps2015", "--output", "twin.csv", *SHORT, *noise)
    assert code == 0
    wrote, true, following = out.splitlines()
    assert wrote == "wrote twin.csv"
    assert true == "true values: M = 90 kg, Fv = 236.9 N/(m/s), Fc = 24.8 N"
    words = following.removeprefix("next: axisid ").split()
    assert words == ["identify", "emps2015", "twin.csv", "--columns", "velocity=velocity"]
    code, out, _ = run(*words, "--method", "idm-ls")
    assert code == 0
    assert "velocity = velocity" in out


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_many_logs_are_a_fleet_and_its_results_a_trend(run: Run) -> None:
    many = ("--count", "2", "--days", "2", "--scatter", "1%", "--scatter", "Fc=0.05")
    code, out, _ = run("twin", "emps2015", "--output", "logs", *SHORT, *many, "--drift", "Fv=3%")
    assert (code, out.splitlines()[0]) == (0, "wrote 4 logs and logs/manifest.csv")
    words = out.splitlines()[1].removeprefix("next: axisid ").split()
    assert words == ["fleet", "logs/manifest.csv"]
    code, out, _ = run(*words, "--method", "idm-ls", "--jobs", "1")
    assert code == 0
    assert "4 identified" in out
    code, out, _ = run("trend", "results", "--by", "date")
    assert code == 0
    assert "emps2015 0002, 2 results by IDM-LS" in out


@pytest.mark.slow
def test_only_logs_of_twins_are_written_over(run: Run, refused: Refused, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    arguments = ("twin", "emps2015", *SHORT, "--output")
    assert [run(*arguments, file)[0] for _ in range(2)] == [0, 0]
    file.write_text("time,position\n")
    refused(*arguments, file, says="this command did not write it")
    folder = tmp_path / "logs"
    assert [run(*arguments, folder, "--count", "1")[0] for _ in range(2)] == [0, 0]
    (folder / "manifest.csv").write_text("log,axis,serial\n")
    refused(*arguments, folder, "--count", "1")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--output", "logs"], "add --count or --days"),
        (["--output", "t.csv", "--count", "2"], "omit these options"),
        (["--output", "t.csv", "--scatter", "2%"], "--scatter has no effect without --count"),
        (["--output", "logs", "--count", "2", "--drift", "M=1%"], "no effect without --days"),
        (["--output", "logs", "--count", "2", "--scatter", "M=x"], "Write NAME=SHARE"),
        (["--output", "logs", "--count", "2", "--scatter", "m=1%"], "no parameter of this name"),
        (["--output", "logs", "--count", "2", "--scatter", "1e9%"], "a share of the value"),
        (["--output", "t.csv", "--speed", "0.1"], "--acceleration"),
        (["--output", "t.csv", "--repeat", "2"], "no effect without --speed"),
        (["--output", "t.csv", "--dwell", "0.2"], "no effect without --speed"),
        (["--output", "t.csv", "--truth", "M"], "Write NAME=VALUE"),
    ],
)
def test_twins_that_make_no_sense_are_refused(
    refused: Refused, here: Path, arguments: list[str], said: str
) -> None:
    refused("twin", "emps2015", *arguments, says=said)
    assert not [*here.iterdir()]
