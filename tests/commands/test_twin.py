"""``axisid twin``: logs to try the other commands on."""

from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]

SHORT = ("--speed", "0.05", "--speed", "0.1", "--acceleration", "0.75", "--seconds", "0.3")


def test_a_log_is_identified_as_the_command_says(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    noise = ("--position-noise", "1e-8", "--velocity-noise", "1e-6", "--truth", "M=90")
    code, out, _ = run("twin", "emps2015", "--output", "twin.csv", *SHORT, *noise)
    assert code == 0
    wrote, true, following = out.splitlines()
    assert wrote == "wrote twin.csv"
    assert true == "true: M = 90 kg, Fv = 236.9 N/(m/s), Fc = 24.8 N"
    words = following.removeprefix("next: axisid ").split()
    assert words == ["identify", "emps2015", "twin.csv", "--columns", "velocity=velocity"]
    code, out, _ = run(*words, "--method", "idm-ls")
    assert code == 0
    assert "velocity = velocity" in out


@pytest.mark.slow
def test_many_logs_are_a_fleet_and_its_results_a_trend(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
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


def test_only_logs_of_twins_are_written_over(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    arguments = ("twin", "emps2015", *SHORT, "--output")
    assert [run(*arguments, file)[0] for _ in range(2)] == [0, 0]
    file.write_text("time,position\n")
    code, _, err = run(*arguments, file)
    assert (code, "this command did not write it" in err) == (2, True)
    folder = tmp_path / "logs"
    assert [run(*arguments, folder, "--count", "1")[0] for _ in range(2)] == [0, 0]
    (folder / "manifest.csv").write_text("log,axis,serial\n")
    assert run(*arguments, folder, "--count", "1")[0] == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--output", "logs"], "or add --count or --days"),
        (["--output", "t.csv", "--scatter", "2%"], "--scatter says nothing without --count"),
        (["--output", "logs", "--count", "2", "--drift", "M=1%"], "nothing without --days"),
        (["--output", "logs", "--count", "2", "--scatter", "M=x"], "write NAME=SHARE"),
        (["--output", "logs", "--count", "2", "--scatter", "m=1%"], "does not declare"),
        (["--output", "logs", "--count", "2", "--scatter", "1e9%"], "a share of its value"),
        (["--output", "t.csv", "--speed", "0.1"], "--acceleration"),
        (["--output", "t.csv", "--repeat", "2"], "nothing without --speed"),
        (["--output", "t.csv", "--dwell", "0.2"], "nothing without --speed"),
        (["--output", "t.csv", "--truth", "M"], "write NAME=VALUE"),
    ],
)
def test_what_makes_no_sense_is_refused(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run("twin", "emps2015", *arguments)
    assert (code, out) == (2, "")
    assert said in err
    assert not [*tmp_path.iterdir()]
