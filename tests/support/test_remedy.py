"""Settings are worded as options and as arguments, and are both in truth."""

import ast
import inspect
from collections.abc import Iterator
from functools import reduce
from pathlib import Path

import click
import pytest

import axisid
from axisid.commands.main import cli
from axisid.estimation.choices import LOG_KEYS
from axisid.support.remedy import ARGUMENTS, Setting, as_arguments, as_options

RESAMPLE, SPLIT = Setting("resample", "auto"), Setting("gaps", "split")
UNNAMED = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


@pytest.mark.parametrize("name", ARGUMENTS)
def test_setting_is_an_option_of_a_command_or_a_key_of_a_log(name: str) -> None:
    options = {
        option
        for name, command in cli.commands.items()
        for parameter in command.params
        if isinstance(parameter, click.Option)
        for each in parameter.opts
        for option in (each, f"{name} {each}")
    }
    command, _, option = name.rpartition(" ")
    argument = ARGUMENTS[name]
    if argument.place == "run.toml":
        assert argument.name in LOG_KEYS
    elif not argument.place:
        assert f"{command} --{option}".strip() in options


@pytest.mark.parametrize("name", ARGUMENTS)
def test_setting_is_an_argument_in_python(name: str) -> None:
    argument = ARGUMENTS[name]
    called = reduce(getattr, argument.of.split("."), axisid)
    parameters = inspect.signature(called).parameters
    if argument.name:
        assert argument.name in parameters
    elif "{}" in argument.call:
        assert any(each.kind in UNNAMED for each in parameters.values())
    head = argument.call.partition("(")[0].rpartition("=")[2]
    assert head in ("{}", argument.of.rpartition(".")[2])


@pytest.mark.parametrize(
    ("settings", "options", "arguments"),
    [
        (
            (RESAMPLE, SPLIT),
            "--resample auto --gaps split",
            'repairs=Repairs(resample="auto", gaps="split")',
        ),
        (
            (Setting("columns", "time=NAME,force=NAME:N"), Setting("wrap", "360:deg")),
            '--columns time=NAME,force=NAME:N and wrap = "360:deg" in run.toml',
            'columns={"time": "NAME", "force": "NAME:N"}, repairs=Repairs(wrap="360:deg")',
        ),
        ((Setting("sample-period"),), "sample_period = ... in run.toml", "sample_period=..."),
        ((Setting("max-memory", "BYTES"),), "max_memory = BYTES in run.toml", "max_memory=BYTES"),
        ((Setting("hold", "zoh"),), "--hold zoh", 'Prefilter(hold="zoh")'),
        (
            (Setting("leave-out", "a"), Setting("leave-out", "b")),
            "--leave-out a --leave-out b",
            'leave_out(axis, "a", "b")',
        ),
        ((Setting("fix", "m=2+-0.1"),), "--fix m=2+-0.1", "fix(axis, m=(2, 0.1))"),
        (
            (Setting("shift", "control=-1"), Setting("shift", "force=2ms")),
            'shift.control = -1, shift.force = "2ms" in run.toml',
            'repairs=Repairs(shift={"control": "-1", "force": "2ms"})',
        ),
        ((Setting("start", "nominal"),), 'start="nominal" in Python', 'start="nominal"'),
        (
            (Setting("window", "2..5"), Setting("window", "8..")),
            "--window 2..5 --window 8..",
            "windows=[(2, 5), (8, None)]",
        ),
        (
            (Setting("fit output", "open-loop"),),
            "axisid fit --output open-loop",
            'fit(axis, record, "open-loop")',
        ),
        ((Setting("json"),), "--json", "to_dict() as JSON"),
        ((Setting("wrap", given=False),), "leave wrap out in run.toml", "leave wrap out"),
    ],
)
def test_settings_are_worded_as_options_and_as_arguments(
    settings: tuple[Setting, ...], options: str, arguments: str
) -> None:
    assert as_options(settings) == options
    assert as_arguments(settings) == arguments


@pytest.mark.slow
def test_no_sentence_of_the_library_speaks_in_options(root: Path) -> None:
    """Docstrings may: whoever reads them has the code before them."""
    folders = (root / "modeling", root / "codegen", root / "estimation")
    files = [file for folder in folders for file in folder.rglob("*.py")]
    source = root / "src" / "axisid"
    files += [source / "presentation" / "schema" / "reading.py"]
    for room in ("support", "exports", "presentation/documents"):
        files += (source / room).glob("*.py")
    found = [
        f"{file.relative_to(root)}:{line}: {text}"
        for file in files
        for line, text in _texts(ast.parse(file.read_text(encoding="utf-8")))
        if _names_an_option(text)
    ]
    assert found == []


def _names_an_option(text: str) -> bool:
    words = (word.lstrip("(`'\"") for word in text.split())
    return any(word.startswith("--") and word[2:3].isalpha() for word in words)


def _texts(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """The texts in a module, with their lines, but for its docstrings."""
    told = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            yield node.lineno, node.value
