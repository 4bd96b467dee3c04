"""Where commands write: places are checked before anything is computed, then written to."""

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import click

from axisid.command_inputs import file_of
from axisid.terminal import show_text


class Result(Protocol):
    """What a command found."""

    def summary(self) -> str:
        """Say it in words and tables."""

    def to_dict(self) -> dict[str, Any]:
        """Say it as JSON does."""


def json_option(said: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add ``--json``, which the command takes as `json_file`."""
    return click.option("--json", "json_file", metavar="FILE", help=said)


def check_json(file: str | None, *inputs: str | None) -> None:
    """As `check_output`, for ``--json``."""
    check_output(file, "--json", *inputs)


def check_output(file: str | None, option: str, *inputs: str | None) -> None:
    """Refuse a place that cannot be written to before anything is computed."""
    if file is None:
        return
    path = Path(file)
    if file == "-" and option == "--json":
        problem = "standard output is closed" if sys.stdout is None else ""
    elif file in ("", "-") or os.path.isdir(file):
        problem = "it is no file; name one"
    elif not os.path.isdir(path.parent):
        problem = "the folder does not exist; make it first"
    elif path.is_symlink() and not _leads_somewhere(path):
        problem = "the link leads to itself; name another file"
    elif path.resolve() in {file_of(given).resolve() for given in inputs if given}:
        problem = "it is an input of this run; name another file"
    else:
        problem = ""
    if problem:
        raise click.BadParameter(f"{file!r}: {problem}", param_hint=option)


def _leads_somewhere(link: Path) -> bool:
    try:
        link.resolve()
        link.stat()
    except FileNotFoundError:
        return True  # a file that can be made
    except (OSError, RuntimeError):
        return False
    return True


def check_folder(folder: str | None) -> None:
    """Refuse a folder that can neither be used nor made."""
    if folder is None or os.path.isdir(folder):
        return
    if not folder or os.path.exists(folder) or not os.path.isdir(Path(folder).parent):
        raise click.BadParameter(
            f"{folder!r}: it is no folder, nor a new one in a folder; name one",
            param_hint="--figures",
        )


def write_output(file: str | None, text: str) -> None:
    """Write a text into a file, or to standard output for ``-`` or None."""
    if file is None or file == "-":
        click.echo(text, nl=False)
    else:
        _write(Path(file), text)


def _write(path: Path, text: str) -> None:
    from axisid.codegen import replace_file
    from axisid.modeling import UsageError

    try:
        replace_file(path, text)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}.") from error


def put_result(result: Result, json_file: str | None) -> None:
    """Write a result where ``--json`` says, and print it unless that is standard output."""
    if json_file is not None:
        put_json(json_file, result.to_dict())
    if json_file != "-":
        show_text(result.summary())


def put_json(file: str, result: dict[str, Any]) -> None:
    """Write a result as JSON into a file, or to standard output for ``-``."""
    write_output(file, json.dumps(result, indent=2, allow_nan=False) + "\n")
