"""Every command explains itself by an example that runs, and completes what it takes."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.shell_completion import BashComplete

from axisid.commands.main import cli
from tests.command_line import Run

COMMANDS = dict(cli.commands)
OF_THE_USER = (
    "DATA_EMPS.mat",
    "log.csv",
    "loaded.csv",
    "logs/*.csv",
    "manifest.csv",
    "trend results",
)  # examples with a record, which cannot run here

WITH_LOGS_ALONE = ("fleet", "trend")
#: Line that a command of more than 30 s prints on standard error.
PROGRESS = re.compile(r"axisid: .+, \d+ s")


def examples(command: click.Command) -> list[str]:
    said = command.epilog.removeprefix("Examples: ").removeprefix("Example: ")
    return [part.strip() for part in re.split(r", or |\. In ", said) if part.startswith("axisid")]


@pytest.mark.parametrize("name", COMMANDS)
def test_help_has_an_example_and_describes_every_option(run: Run, name: str) -> None:
    command = COMMANDS[name]
    code, out, _ = run(name, "--help")
    assert code == 0
    assert examples(command)[0].startswith("axisid ")
    assert f"axisid {name}" in " ".join(out.split())
    assert command.help
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, f"{name} {parameter.name}"
        else:
            assert str(parameter.name).upper() in str(command.help), f"{name} {parameter.name}"


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_the_examples_run_and_print_plain_ascii(
    run: Run, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, root: Path
) -> None:
    ran = 0
    for example in examples(COMMANDS[name]):
        if any(file in example for file in OF_THE_USER):
            continue
        monkeypatch.chdir(root if "--check" in example else tmp_path)
        for line in example.split(" && "):
            words, _, target = line.partition(" > ")
            code, out, err = run(*shlex.split(words)[1:])
            other = [each for each in err.splitlines() if not PROGRESS.fullmatch(each)]
            assert (code, other) == (0, []), line
            assert re.fullmatch(r"[ -~\n\t]*", out), line
            assert out or "-o" in words or target, line
        ran += 1
    assert ran or name in WITH_LOGS_ALONE


def completed(*words: str) -> list[str]:
    *before, incomplete = words
    items = BashComplete(cli, {}, "axisid", "_AXISID_COMPLETE").get_completions(before, incomplete)
    return [f"{item.type} {item.value}" for item in items]


@pytest.mark.usefixtures("here")
def test_commands_axes_files_and_choices_complete() -> None:
    Path("mine.toml").touch()
    Path("emptied.py").touch()
    Path("log.csv").touch()
    assert "plain identify" in completed("id")
    assert completed("identify", "emps") == ["plain emps", "plain emps2015"]
    assert completed("show", "em") == ["plain emps", "plain emps2015", "plain emptied.py"]
    assert completed("identify", "mi") == ["plain mine.toml"]
    assert completed("identify", "some/folder") == ["file some/folder"]
    assert completed("identify", "emps", "lo") == ["file lo"]
    assert completed("identify", "emps", "--method", "idm-i") == ["plain idm-iv"]
    assert completed("compare", "--ladder", "emps2") == ["plain emps2015"]
    assert completed("export", "r.json", "--to", "l") == ["plain latex"]
    assert completed("generate", "emps", "emps2") == ["plain emps2015"]


def test_the_protocol_answers_in_a_process_without_the_stages() -> None:
    program = (
        "import sys\nfrom axisid.commands.main import main\n"
        "try:\n    main()\nexcept SystemExit as e:\n"
        "    print(e.code, sorted({'numpy', 'sympy', 'casadi'} & set(sys.modules)))\n"
    )
    words = {"COMP_WORDS": "axisid show em", "COMP_CWORD": "2"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        cwd="/",
        env={**os.environ, **words, "_AXISID_COMPLETE": "bash_complete"},
    )
    assert done.stdout.splitlines() == ["plain,emps", "plain,emps2015", "0 []"]
